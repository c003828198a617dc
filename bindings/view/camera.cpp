#include "view/camera.h"

#include <cmath>

namespace feder::view {
namespace {

float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The eight corners of a box.
void corner(const Bounds& b, int i, float out[3]) {
  for (int k = 0; k < 3; ++k) out[k] = i >> k & 1 ? b.high[k] : b.low[k];
}

// What the picture is about: the moving things, with as much of the fixed ones as is near them.
Bounds subject(const Frame& f) {
  if (f.moving.empty()) return f.bounds;
  Bounds b = f.moving;
  float size = 0;
  for (int i = 0; i < 3; ++i) size = std::max(size, b.high[i] - b.low[i]);
  const float margin = 0.25f * size;
  for (int i = 0; i < 3 && !f.bounds.empty(); ++i) {
    b.low[i] = std::max(f.bounds.low[i], b.low[i] - margin);
    b.high[i] = std::min(f.bounds.high[i], b.high[i] + margin);
  }
  return b;
}

}  // namespace

Matrix4 operator*(const Matrix4& a, const Matrix4& b) {
  Matrix4 r;
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < 4; ++i) {
      float sum = 0;
      for (int k = 0; k < 4; ++k) sum += a.m[4 * k + i] * b.m[4 * c + k];
      r.m[4 * c + i] = sum;
    }
  return r;
}

void Camera::axes(float right[3], float up[3], float back[3]) const {
  const float cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
  back[0] = sy * cp, back[1] = sp, back[2] = cy * cp;
  right[0] = cy, right[1] = 0, right[2] = -sy;
  up[0] = -sy * sp, up[1] = cp, up[2] = -cy * sp;
}

void Camera::eye(float out[3]) const {
  float right[3], up[3], back[3];
  axes(right, up, back);
  for (int i = 0; i < 3; ++i) out[i] = target[i] + distance * back[i];
}

void Camera::look(const float from[3], const float at[3]) {
  const float d[3] = {from[0] - at[0], from[1] - at[1], from[2] - at[2]};
  const float n = std::sqrt(dot(d, d));
  for (int i = 0; i < 3; ++i) target[i] = at[i];
  if (!(n > 0)) return;
  distance = n;
  pitch = std::asin(d[1] / n);
  yaw = std::atan2(d[0], d[2]);
}

// The distance is the least at which every corner of the subject is inside the image with a margin: corner p (relative
// to the target) at depth distance - p.back needs |p.up| <= m t (distance - p.back), t = tan(fov / 2).
void Camera::fit(const Frame& frame, float aspect) {
  const Bounds b = subject(frame);
  if (frame.dimension == 2) yaw = 0, pitch = 0;
  if (b.empty()) return;
  for (int i = 0; i < 3; ++i) target[i] = (b.low[i] + b.high[i]) / 2;
  float right[3], up[3], back[3];
  axes(right, up, back);
  const float tall = 0.86f * std::tan(fov / 2), wide = tall * aspect;
  float needed = 0.05f;
  for (int i = 0; i < 8; ++i) {
    float p[3];
    corner(b, i, p);
    for (int k = 0; k < 3; ++k) p[k] -= target[k];
    const float depth = dot(p, back);
    needed = std::max({needed, depth + std::abs(dot(p, up)) / tall, depth + std::abs(dot(p, right)) / wide});
  }
  distance = needed;
}

Matrix4 Camera::view() const {
  float r[3], u[3], b[3], e[3];
  axes(r, u, b);
  eye(e);
  return {{r[0], u[0], b[0], 0, r[1], u[1], b[1], 0, r[2], u[2], b[2], 0, -dot(r, e), -dot(u, e), -dot(b, e), 1}};
}

Matrix4 Camera::projection(float aspect) const {
  const float near = 0.01f * distance, far = 200 * distance, t = 1 / std::tan(fov / 2);
  return {{t / aspect, 0, 0, 0, 0, t, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0}};
}

void Camera::ray(float x, float y, int width, int height, float origin[3], float direction[3]) const {
  float right[3], up[3], back[3];
  axes(right, up, back);
  eye(origin);
  const float t = std::tan(fov / 2), aspect = static_cast<float>(width) / static_cast<float>(height);
  const float u = (2 * x / static_cast<float>(width) - 1) * t * aspect, v = (1 - 2 * y / static_cast<float>(height)) * t;
  float n = 0;
  for (int i = 0; i < 3; ++i) direction[i] = u * right[i] + v * up[i] - back[i], n += direction[i] * direction[i];
  for (int i = 0; i < 3; ++i) direction[i] /= std::sqrt(n);
}

bool Camera::project(const float point[3], int width, int height, float& x, float& y) const {
  float right[3], up[3], back[3], e[3];
  axes(right, up, back);
  eye(e);
  const float d[3] = {point[0] - e[0], point[1] - e[1], point[2] - e[2]};
  const float depth = -dot(d, back);
  if (!(depth > 0)) return false;
  const float t = std::tan(fov / 2) * depth, aspect = static_cast<float>(width) / static_cast<float>(height);
  x = (dot(d, right) / (t * aspect) + 1) / 2 * static_cast<float>(width);
  y = (1 - dot(d, up) / t) / 2 * static_cast<float>(height);
  return true;
}

}  // namespace feder::view
