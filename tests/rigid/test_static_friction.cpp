// Coulomb's law of rest: a block on a slope holds iff tan(angle) <= friction_static, however its load arrives and
// however low the dynamic friction is. At default settings; "holds" means less than 1 mm in 5 s.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

constexpr double kDegree = 3.14159265358979 / 180;

enum class Load { made_in_place, gravity_tilted, ramp_turned };

struct Crate {
  Real width, height;  // m
};

// Angle of a ramp that rotates for four seconds: without jerk, so that the load stays below that at its end.
double turned_part(double t) {
  const double u = std::min(1.0, t / 4);
  return u * u * u * (10 + u * (6 * u - 15));
}

// Sliding distance after `seconds` under the whole load, m; ends early where it is clear.
double slides(const char* solver, Load load, Crate crate, double angle, double mu_s, double mu_d, double seconds = 5) {
  ClosedScene s(solver);
  const Quat turn = from_axis_angle(Vec3(0, 0, 1), Real(-angle));
  const Vec3 up = load == Load::made_in_place ? rotate(turn, Vec3(0, 1, 0)) : Vec3(0, 1, 0);
  BodyDesc ground;
  if (load == Load::ramp_turned) {
    ground = body_of(make_box(20, 1, 20), Vec3(0, Real(-0.5), 0));
    ground.type = BodyType::kinematic;
  } else {
    ground = ground_of(0, up);
  }
  BodyDesc d = body_of(make_box(crate.width, crate.height, crate.width), crate.height / 2 * up);
  if (load == Load::made_in_place) d.rotation = turn;
  ground.friction_static = d.friction_static = Real(mu_s);
  ground.friction_dynamic = d.friction_dynamic = Real(mu_d);
  const ObjectId ramp = s.rigid().add_body(ground), block = s.rigid().add_body(d);
  if (load == Load::gravity_tilted) {
    s.run(0.5);
    s.world().set_gravity(Vec3(Real(kG * std::sin(angle)), Real(-kG * std::cos(angle)), 0));
  }
  if (load == Load::ramp_turned) {
    for (int i = 1; i <= 240; ++i) {
      const Quat now = from_axis_angle(Vec3(0, 0, 1), Real(-angle * turned_part(i * s.desc.dt)));
      s.rigid().move_to(ramp, {rotate(now, Vec3(0, Real(-0.5), 0)), now});
      s.run(s.desc.dt);
    }
  }
  const Vec3 start = s.position(block);
  double way = 0;
  for (double t = 0; t < seconds && way < 1e-3; t += 0.1) {
    s.run(0.1);
    const Vec3 gone = s.position(block) - start;
    way = double(length(gone));
  }
  return way;
}

}  // namespace

TEST_CASE("a block holds iff static friction reaches the slope, however the load comes", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const Load load = GENERATE(Load::made_in_place, Load::gravity_tilted, Load::ramp_turned);
  const double degrees = GENERATE(5.0, 25.0, 40.0);
  const double angle = degrees * kDegree, slope = std::tan(angle);
  // a plate, a cube, and a tower that is a seventh short of tipping
  const Crate crates[] = {{1, Real(0.1)}, {1, 1}, {Real(0.5), Real(std::min(2.0, 0.5 / (1.15 * slope)))}};
  for (const Crate& crate : crates)
    for (const double ratio : {1.0, 0.9, 0.5, 0.25, 0.1, 0.0}) {
      CAPTURE(solver, int(load), degrees, crate.height, ratio);
      CHECK(slides(solver, load, crate, angle, 1.02 * slope, ratio * 1.02 * slope) < 1e-3);
      CHECK(slides(solver, load, crate, angle, 0.99 * slope, ratio * 0.99 * slope) >= 1e-3);
    }
}
