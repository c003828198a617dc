// Sphere against box: the point of the box nearest to the centre; a centre inside leaves by the nearest face.
// Source: Arvo, "A Simple Method for Box-Sphere Intersection Testing", Graphics Gems (1990). Keeps nothing between
// calls. Weak spot: the normal of a centre inside jumps where two faces are equally near.
#include "geom/box.h"
#include "narrow/narrow_phase.h"

namespace feder {
namespace {

int sphere_box(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
               Manifold* out) {
  const Vec3& h = static_cast<const Box&>(b).half();
  const Vec3 c = to_local(pose_b, pose_a.position);
  Vec3 near, outward;
  Real distance;
  std::uint32_t feature = 0;  // per axis: below, between, above
  for (int i = 0, digit = 1; i < 3; ++i, digit *= 3) {
    near[i] = clamp(c[i], -h[i], h[i]);
    feature += static_cast<std::uint32_t>(digit) * (c[i] < -h[i] ? 0u : (c[i] > h[i] ? 2u : 1u));
  }
  const Vec3 d = c - near;
  const Real squared = dot(d, d), limit = a.radius() + margin;
  if (squared > limit * limit) return 0;
  if (squared > 0) {
    distance = std::sqrt(squared);
    outward = d / distance;
  } else {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
      if (h[i] - std::abs(c[i]) < h[axis] - std::abs(c[axis])) axis = i;
    distance = std::abs(c[axis]) - h[axis];
    outward = Vec3::Zero();
    outward[axis] = c[axis] < 0 ? Real(-1) : Real(1);
    near[axis] = outward[axis] * h[axis];
    feature = 27u + static_cast<std::uint32_t>(axis);
  }
  const Real separation = distance - a.radius();
  const Vec3 n = rotate(pose_b.rotation, outward);
  out->normal = -n;
  out->count = 1;
  out->points[0] = {to_world(pose_b, near) + n * (separation / 2), separation, feature};
  return 1;
}

}  // namespace

PairRow narrow_sphere_box() { return {"sphere", "box", sphere_box}; }

}  // namespace feder
