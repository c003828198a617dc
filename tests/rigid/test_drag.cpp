// Forces against velocity on bodies: each acts over a substep with what it was at its start, and may stop a body in it.
#include "feder/force.h"
#include "rigid/closed_scene.h"

using namespace feder;

TEST_CASE("drag of any strength stops a body and never turns it round", "[rigid]") {
  const std::string kind = GENERATE("drag", "wind", "buoyancy");
  const double strength = GENERATE(1e2, 1e4, 1e9);  // N s/m, on 1 kg
  const int forces = GENERATE(1, 3);
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(kind, strength, forces, solver);
  ClosedScene s(solver);
  s.desc.gravity = Vec3::Zero();
  const ObjectId ball = s.rigid().add_body(body_of(make_sphere(Real(0.2)), Vec3(0, 0, 0)));
  s.rigid().set_velocity(ball, Vec3(20, 0, 0));
  Params options;
  options.set(kind == "buoyancy" ? "drag" : "linear", strength);
  if (kind == "buoyancy") options.set("height", 10.0), options.set("gravity", 0.0);
  for (int k = 0; k < forces; ++k) {
    ForceEntry on;
    on.all = true;
    s.world().add_force(kind, options, std::move(on), "", 0);
  }
  Real last = 20;
  for (int k = 0; k < 60; ++k) {
    s.world().step();
    const Real now = s.velocity(ball)[0];
    CHECK(now >= Real(-1e-4));
    CHECK(now <= last + Real(1e-4));
    last = now;
  }
  CHECK(last < Real(1e-3));
}

TEST_CASE("drag that a substep resolves is what it was", "[rigid]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  s.desc.gravity = Vec3::Zero();
  const ObjectId ball = s.rigid().add_body(body_of(make_sphere(Real(0.2)), Vec3(0, 0, 0)));
  s.rigid().set_velocity(ball, Vec3(20, 0, 0));
  Params options;
  options.set("linear", 24.0);  // a tenth of m/h
  ForceEntry on;
  on.all = true;
  s.world().add_force("drag", options, std::move(on), "", 0);
  s.world().step();
  CHECK(s.velocity(ball)[0] == Approx(20 * std::pow(0.9, 4)).epsilon(1e-5));
}
