#include "geom/plane.h"

#include "base/error.h"

namespace feder {

// Unbounded, except across a plane exactly along an axis.
Aabb Plane::bounds(const Pose& pose) const {
  const Vec3 n = rotate(pose.rotation, normal_);
  const Real d = distance_ + dot(n, pose.position);
  Aabb box = Aabb::everything();
  for (int i = 0; i < 3; ++i) {
    if (n[(i + 1) % 3] != 0 || n[(i + 2) % 3] != 0) continue;
    (n[i] > 0 ? box.hi[i] : box.lo[i]) = n[i] > 0 ? d : -d;
  }
  return box;
}

bool Plane::raycast(const Vec3& o, const Vec3& d, RayHit& hit) const {
  const Real height = dot(normal_, o) - distance_, down = -dot(normal_, d);
  if (height <= 0) return hit = {0, Vec3::Zero()}, true;
  if (down < height) return false;
  return hit = {height / down, normal_}, true;
}

ShapePtr Plane::section() const {
  const Vec3 flat = vec3(normal_[0], normal_[1], 0);
  const Real n = length(flat);
  if (!(n > Real(1e-6))) throw SceneError("plane: a normal along z has no 2D section");
  return make_plane(flat, distance_);
}

ShapePtr make_plane(const Vec3& normal, Real distance) {
  const Real n = length(normal);
  if (!(n > 0) || !std::isfinite(n) || !std::isfinite(distance))
    throw SceneError("plane: expected a finite normal other than 0 and a finite distance, got normal (" +
                     std::to_string(normal[0]) + ", " + std::to_string(normal[1]) + ", " + std::to_string(normal[2]) +
                     "), distance " + std::to_string(distance));
  return std::make_shared<Plane>(normal / n, distance / n);
}

ShapeKind geom_plane() {
  return {"plane", [] {
            return std::vector<ShapePtr>{make_plane(vec3(0, 1, 0), 0), make_plane(vec3(1, -2, Real(0.5)), Real(0.3))};
          }};
}

}  // namespace feder
