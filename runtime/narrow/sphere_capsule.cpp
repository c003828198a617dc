// Sphere against capsule: the nearest point of the segment. A centre on the axis leaves across it.
// Source: Ericson, "Real-Time Collision Detection" (2005), 5.1.2. Keeps nothing between calls. Weak spot: on the axis
// the direction is that of the capsule's x, whatever the motion.
#include "narrow/narrow_phase.h"
#include "narrow/round.h"

namespace feder {
namespace {

int sphere_capsule(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                   Manifold* out) {
  const Real half = b.support(vec3(0, 1, 0))[1];
  const Real along = clamp(to_local(pose_b, pose_a.position)[1], -half, half);
  return round_contact(pose_a.position, a.radius(), to_world(pose_b, vec3(0, along, 0)), b.radius(), margin,
                       rotate(pose_b.rotation, vec3(1, 0, 0)), *out);
}

}  // namespace

PairRow narrow_sphere_capsule() { return {"sphere", "capsule", sphere_capsule}; }

}  // namespace feder
