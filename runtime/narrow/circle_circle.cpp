// Circle against circle: the line of centres, in the plane z = 0.
// Keeps nothing between calls. Weak spot: concentric circles part along y, whatever their motion.
#include "narrow/narrow_phase.h"
#include "narrow/round.h"

namespace feder {
namespace {

int circle_circle(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                  Manifold* out) {
  const Vec3 p = vec3(pose_a.position[0], pose_a.position[1], 0), q = vec3(pose_b.position[0], pose_b.position[1], 0);
  return round_contact(p, a.radius(), q, b.radius(), margin, vec3(0, 1, 0), *out);
}

}  // namespace

PairRow narrow_circle_circle() { return {"circle", "circle", circle_circle}; }

}  // namespace feder
