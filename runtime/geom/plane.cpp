// Plane: bounds, rays and its 2D section.
#include "geom/plane.h"

#include "feder/error.h"
#include "feder/params.h"

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

namespace {

ShapePtr make(const ShapeInput& in) {
  const Real size = length(in.direction);
  if (!(size > Real(1e-12) && size < Real(1e12)))
    throw SceneError("plane: expected a normal of a direction, got one of length " + print_number(size));
  const auto distance = static_cast<Real>(in.sizes[0] / static_cast<double>(size));
  if (!std::isfinite(distance)) throw SceneError("plane: expected a finite distance, got " + print_number(in.sizes[0]));
  const Vec3 n = in.direction / size;
  const Real rest = length(n);  // of rounding
  return std::make_shared<Plane>(n / rest, distance / rest,
                                 ShapeArguments{.sizes = in.sizes, .direction = in.direction});
}

}  // namespace

ShapeKind geom_plane() {
  return {"plane",
          "([nx, ny, nz, [d]])",
          "the half-space n.x >= d is free; y >= 0 when left out",
          {},
          {{"normal", ShapeArgumentType::direction, 0}, {"distance", ShapeArgumentType::number, 0}},
          make,
          [] {
            return std::vector<ShapePtr>{make_plane(vec3(0, 1, 0), 0), make_plane(vec3(1, -2, Real(0.5)), Real(0.3))};
          },
          false,
          "ground, floor"};
}

}  // namespace feder
