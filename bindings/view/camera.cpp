#include "view/camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace feder::view {
namespace {

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
  std::vector<float> values(boxes.size());
  Float3 center;
  for (int k = 0; k < 3; ++k) {
    std::transform(boxes.begin(), boxes.end(), values.begin(), [k](const Bounds& b) { return b.center()[k]; });
    center[k] = median(values);
  }
  std::transform(boxes.begin(), boxes.end(), values.begin(),
                 [&](const Bounds& b) { return length(b.center() - center); });
  const float usual = median(values);
  float largest = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (values[i] <= usual) largest = std::max(largest, boxes[i].longest_side());
  Bounds all;
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
  // fixed things near the moving ones belong to the picture, as far as they are near
  const Bounds core = b;
  const float rim = 0.2f * b.longest_side();
  const Float3 near{rim, rim, rim};
  for (const Bounds& x : fixed) {
    const Bounds cut{max(x.low, core.low - near), min(x.high, core.high + near)};
    if (cut.low.x <= cut.high.x && cut.low.y <= cut.high.y && cut.low.z <= cut.high.z) b.include(cut);
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

CameraAxes Camera::axes() const {
  const float cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
  return {{cy, 0, -sy}, {-sy * sp, cp, -cy * sp}, {sy * cp, sp, cy * cp}};
}

void Camera::look_at(Float3 eye, Float3 at) {
  const Float3 d = eye - at;
  const float n = length(d);
  target = at;
  if (!(n > 0)) return;
  distance = n;
  pitch = std::asin(d.y / n);
  yaw = std::atan2(d.x, d.z);
}

// The distance is the least at which every corner of the subject is inside the image with a margin: corner p (relative
// to the target) at depth distance - p.back needs |p.up| <= m t (distance - p.back), t = tan(fov / 2).
void Camera::fit(const Bounds& b, float aspect) {
  if (b.empty()) return;
  target = b.center();
  const auto [right, up, back] = axes();
  const float tall = 0.86f * std::tan(fov / 2), wide = tall * aspect;
  float needed = 0.05f;
  for (int i = 0; i < 8; ++i) {
    const Float3 corner{(i & 1 ? b.high : b.low).x, (i & 2 ? b.high : b.low).y, (i & 4 ? b.high : b.low).z};
    const Float3 p = corner - target;
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
  const auto [r, u, b] = axes();
  const Float3 e = eye();
  return {{r.x, u.x, b.x, 0, r.y, u.y, b.y, 0, r.z, u.z, b.z, 0, -dot(r, e), -dot(u, e), -dot(b, e), 1}};
}

Matrix4 Camera::projection(float aspect) const {
  const float near = 0.01f * distance, far = 200 * distance, t = 1 / std::tan(fov / 2);
  return {
      {t / aspect, 0, 0, 0, 0, t, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0}};
}

std::pair<Float3, Float3> Camera::ray(float x, float y, int width, int height) const {
  const auto [right, up, back] = axes();
  const float t = std::tan(fov / 2), aspect = static_cast<float>(width) / static_cast<float>(height);
  const float u = (2 * x / static_cast<float>(width) - 1) * t * aspect,
              v = (1 - 2 * y / static_cast<float>(height)) * t;
  const Float3 direction = u * right + v * up - back;
  return {eye(), direction / length(direction)};
}

bool Camera::project(Float3 point, int width, int height, float& x, float& y) const {
  const auto [right, up, back] = axes();
  const Float3 d = point - eye();
  const float depth = -dot(d, back);
  if (!(depth > 0)) return false;
  const float t = std::tan(fov / 2) * depth, aspect = static_cast<float>(width) / static_cast<float>(height);
  x = (dot(d, right) / (t * aspect) + 1) / 2 * static_cast<float>(width);
  y = (1 - dot(d, up) / t) / 2 * static_cast<float>(height);
  return true;
}

}  // namespace feder::view
