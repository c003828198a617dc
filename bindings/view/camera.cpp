#include "view/camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace feder::view {
namespace {

float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The eight corners of a box.
void corner(const Bounds& b, int i, float out[3]) {
  for (int k = 0; k < 3; ++k) out[k] = i >> k & 1 ? b.high[k] : b.low[k];
}

// Half the box of an instance, turned: |R| (scale * half size of the unit geometry).
Bounds box_of(const Instance& i, const Geometry& g) {
  const float x = i.rotation[0], y = i.rotation[1], z = i.rotation[2], w = i.rotation[3];
  const float r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                         {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                         {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Bounds b;
  for (int row = 0; row < 3; ++row) {
    float low = 0, high = 0;
    for (int k = 0; k < 3; ++k) {
      const float stretch = k == 1 ? i.stretch : 0;
      const float l = r[row][k] * (i.scale[k] * g.low[k] - stretch), h = r[row][k] * (i.scale[k] * g.high[k] + stretch);
      low += std::min(l, h), high += std::max(l, h);
    }
    b.low[row] = i.position[row] + low, b.high[row] = i.position[row] + high;
  }
  return b;
}

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The boxes that are not far from most of them: within six times the median distance from the median place.
Bounds without_strays(const std::vector<Bounds>& boxes) {
  float center[3];
  std::vector<float> values(boxes.size());
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < boxes.size(); ++i) values[i] = (boxes[i].low[k] + boxes[i].high[k]) / 2;
    center[k] = median(values);
  }
  float largest = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    float d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const float d = (boxes[i].low[k] + boxes[i].high[k]) / 2 - center[k];
      d2 += d * d;
    }
    values[i] = std::sqrt(d2);
  }
  const float usual = median(values);
  Bounds all;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (int k = 0; k < 3; ++k)
      largest = std::max(largest, values[i] <= usual ? boxes[i].high[k] - boxes[i].low[k] : 0);
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (values[i] <= 6 * usual + largest || boxes.size() < 4) all.include(boxes[i]);
  return all;
}

}  // namespace

Bounds subject_of(const Frame& f) {
  std::vector<Bounds> boxes, fixed;
  for (const Batch& batch : f.batches)
    for (std::uint32_t i = batch.first; i < batch.first + batch.count; ++i)
      if (!(f.instances[i].flags & kSensor))
        (f.instances[i].flags & kFixed ? fixed : boxes)
            .push_back(box_of(f.instances[i], *f.geometries[batch.geometry]));
  Bounds b = boxes.empty() ? Bounds{} : without_strays(boxes);
  for (const MeshVertex& v : f.vertices) b.include(v.position);
  for (const Point& p : f.points) b.include(p.position, p.radius);
  for (const Line& l : f.lines) b.include(l.a), b.include(l.b);
  if (b.empty())
    for (const Bounds& x : fixed) b.include(x);
  float size = 0;
  for (int k = 0; k < 3; ++k) size = std::max(size, b.high[k] - b.low[k]);
  // fixed things near the moving ones belong to the picture, as far as they are near
  const Bounds core = b;
  for (const Bounds& x : fixed) {
    Bounds cut;
    for (int k = 0; k < 3; ++k)
      cut.low[k] = std::max(x.low[k], core.low[k] - 0.2f * size),
      cut.high[k] = std::min(x.high[k], core.high[k] + 0.2f * size);
    if (cut.low[0] <= cut.high[0] && cut.low[1] <= cut.high[1] && cut.low[2] <= cut.high[2]) b.include(cut);
  }
  return b;
}

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

void Camera::look_at(const float from[3], const float at[3]) {
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
void Camera::fit(const Bounds& b, float aspect) {
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

void Camera::fit(const Frame& frame, float aspect) {
  if (frame.dimension == 2) yaw = pitch = 0, fov = kPlanarFov;
  fit(subject_of(frame), aspect);
}

Matrix4 Camera::view() const {
  float r[3], u[3], b[3], e[3];
  axes(r, u, b);
  eye(e);
  return {{r[0], u[0], b[0], 0, r[1], u[1], b[1], 0, r[2], u[2], b[2], 0, -dot(r, e), -dot(u, e), -dot(b, e), 1}};
}

Matrix4 Camera::projection(float aspect) const {
  const float near = 0.01f * distance, far = 200 * distance, t = 1 / std::tan(fov / 2);
  return {
      {t / aspect, 0, 0, 0, 0, t, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0}};
}

void Camera::ray(float x, float y, int width, int height, float origin[3], float direction[3]) const {
  float right[3], up[3], back[3];
  axes(right, up, back);
  eye(origin);
  const float t = std::tan(fov / 2), aspect = static_cast<float>(width) / static_cast<float>(height);
  const float u = (2 * x / static_cast<float>(width) - 1) * t * aspect,
              v = (1 - 2 * y / static_cast<float>(height)) * t;
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
