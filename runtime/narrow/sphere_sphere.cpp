// Sphere against sphere: the line of centres.
#include "narrow/narrow_phase.h"
#include "narrow/round.h"

namespace feder {
namespace {

int sphere_sphere(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                  Manifold* out) {
  out->points[0].feature = 0;
  out->count = round_point(pose_a.position, a.radius(), pose_b.position, b.radius(), margin, vec3(0, 1, 0), out->normal,
                           out->points[0]);
  return out->count;
}

}  // namespace

PairRow narrow_sphere_sphere() { return {"sphere", "sphere", sphere_sphere}; }

}  // namespace feder
