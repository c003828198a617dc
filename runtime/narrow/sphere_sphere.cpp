// Sphere against sphere: the line of centres.
// Keeps nothing between calls. Weak spot: concentric spheres part along y, whatever their motion.
#include "narrow/narrow_phase.h"
#include "narrow/round.h"

namespace feder {
namespace {

int sphere_sphere(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                  Manifold* out) {
  return round_contact(pose_a.position, a.radius(), pose_b.position, b.radius(), margin, vec3(0, 1, 0), *out);
}

}  // namespace

PairRow narrow_sphere_sphere() { return {"sphere", "sphere", sphere_sphere}; }

}  // namespace feder
