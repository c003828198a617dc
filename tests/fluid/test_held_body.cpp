// A body that is held under water: the water lifts it by the weight of what it displaces.
#include <cmath>

#include "fluid/tank.h"
#include "state/bodies.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Mean lift over the weight of the displaced water, of a body in the middle of a cube of water `width` wide. The body
// is so heavy that it hardly moves in a step, and is put back after each: what it has gained is the force.
double lift_of(const std::string& solver, const ShapePtr& shape, Real width, Real spacing) {
  World w(one_substep(), fluid_catalog());
  add_tank(w, vec3(width, 0, width));
  const Vec3 middle = vec3(width, width, width) / 2;
  BodyDesc b;
  b.shape = shape, b.position = middle, b.gravity_scale = 0, b.density = 1e6, b.can_sleep = false;
  Rigid& rigid = w.need<Rigid>();
  const ObjectId body = rigid.add_body(b);
  FluidDesc d;
  d.solver = solver, d.spacing = spacing;
  Fluid& f = w.need<Fluid>();
  const ObjectId water = f.add_fluid(d);
  const int n = static_cast<int>(width / spacing + Real(0.5));
  std::vector<Vec3> points;
  for (int i = 0; i < n * n * n; ++i) {
    const Vec3 x = spacing * vec3(static_cast<Real>(i % n) + Real(0.5), static_cast<Real>(i / (n * n)) + Real(0.5),
                                  static_cast<Real>(i / n % n) + Real(0.5));
    Vec3 out;
    if (shape->distance(x - middle, 2 * spacing, out) > Real(0.3) * spacing) points.push_back(x);
  }
  f.fill(water, points, Vec3::Zero());
  const double seconds = 0.5 * kShare;
  double gained = 0;
  for (int half = 0; half < 2; ++half) {
    gained = 0;
    for (double t = 0; t < seconds; t += w.desc().dt) {
      w.step();
      gained += rigid.bodies().velocity[rigid.index(body)][1];
      rigid.set_velocity(body, Vec3::Zero()), rigid.set_angular_velocity(body, Vec3::Zero());
      rigid.set_pose(body, Pose{middle, Quat{}});
    }
  }
  CHECK(w.is_finite());
  const double mass = 1e6, lift = mass * gained / seconds;  // N by m3 of the body
  return lift / (1000 * 9.81);
}

}  // namespace

TEST_CASE("a held ball is lifted by the weight of the water it displaces", "[fluid][held]") {
  if (!kLarge || kAsserts) return;
  const Real d = Real(0.05);
  CHECK(lift_of("dfsph", make_sphere(5 * d), 16 * d, d) == Approx(1).epsilon(0.03));
}

TEST_CASE("bodies that are held are lifted by the weight of the water they displace", "[fluid][.][map]") {
  const Real d = Real(0.05), r = GENERATE(Real(5), Real(7));
  const std::string solver = "dfsph";
  CAPTURE(r);
  CHECK(lift_of(solver, make_sphere(r * d), 4 * r * d, d) == Approx(1).epsilon(0.03));
  CHECK(lift_of(solver, make_box(2 * r * d, 2 * r * d, 2 * r * d), 4 * r * d, d) == Approx(1).epsilon(0.03));
}
