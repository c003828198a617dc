// Kinds of springs: strings, springs without length, two points at one spot; forces on some points.
#include <cmath>

#include "integrate/integrator.h"
#include "nets.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("a string lets go below its rest length and pulls beyond it", "[springs]") {
  const char* integrator = GENERATE("symplectic_euler", "implicit_euler");
  CAPTURE(integrator);
  World w(weightless(1e-3, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(2, 1, 1, 100);
  d.springs[0].tension_only = true;
  d.springs[0].damping = Real(0.5);
  d.integrator = integrator;
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  CHECK(s.spring(net, 0).tension_only);
  // slack: flies inwards freely, and past the anchor
  s.set_velocity(net, 1, Vec3(-2, 0, 0));
  step(w, 500);
  CHECK(static_cast<double>(s.point(net, 1)[0]) == Approx(0).margin(1e-4));
  CHECK(s.velocity(net, 1)[0] == -2);
  CHECK(w.energy().elastic == 0);
  // taut on the far side: thrown back, slower, and slack again
  step(w, 1500);
  CHECK(s.point(net, 1)[0] > -1);
  CHECK(s.velocity(net, 1)[0] > Real(1));
  CHECK(s.velocity(net, 1)[0] < Real(2));
  // it never pushed: once slack, the speed is constant
  const Real speed = s.velocity(net, 1)[0];
  step(w, 100);
  CHECK(s.velocity(net, 1)[0] == speed);
}

TEST_CASE("a spring without rest length is linear in all directions", "[springs]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const char* integrator = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(integrator);
  World w(weightless(1e-3, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(0, 0, 0)};  // both ends at one spot: no force, no direction needed
  d.velocities = {Vec3(0, 0, 0), Vec3(3, 0, 4)};
  d.masses = {1, 1};
  d.springs = {{0, 1, 25, 0, 0}};
  d.integrator = integrator;
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  step(w, 100);  // x = v/w sin(w t)
  const double x = std::sin(0.5) / 5;
  CHECK(static_cast<double>(s.point(net, 1)[0]) == Approx(3 * x).epsilon(5e-3));
  CHECK(static_cast<double>(s.point(net, 1)[2]) == Approx(4 * x).epsilon(5e-3));
  CHECK(s.point(net, 1)[1] == 0);
  CHECK_FALSE(w.residuals().empty());
  for (const Residual& r : w.residuals())
    if (r.name == "springs.coincident_ends") CHECK(r.value == 0);
}

TEST_CASE("two points at one spot are pushed apart along x, and it is told", "[springs]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const char* integrator = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(integrator);
  World w(weightless(1e-3, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.name = "pair";
  d.points = {Vec3(1, 2, 3), Vec3(1, 2, 3)};
  d.masses = {1, 3};
  d.springs = {{1, 0, 100, 0, Real(0.5)}};
  d.integrator = integrator;
  const ObjectId net = s.add_net(d);
  w.step();
  int told = 0;
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning && w.events().warning_code(e) == "coincident") {
      ++told;
      CHECK(e.a == net);
      CHECK_THAT(w.events().warning_message(e), Catch::Contains("pair") && Catch::Contains("spring 1"));
    }
  CHECK(told == 1);
  double counted = 0;
  for (const Residual& r : w.residuals())
    if (r.name == "springs.coincident_ends") counted = r.value;
  CHECK(counted >= 1);
  w.step();
  CHECK(warning_of(w) == "");
  step(w, 20);
  CHECK(w.is_finite());
  CHECK(s.point(net, 0)[0] < 1);
  CHECK(s.point(net, 1)[0] > 1);
  CHECK(s.point(net, 0)[1] == 2);
  const Momentum m = w.momentum();
  CHECK(std::fabs(m.linear[0]) < 1e-5);
}

TEST_CASE("a force generator on some points leaves the others alone", "[springs]") {
  const char* integrator = GENERATE("symplectic_euler", "implicit_euler");
  World w(weightless(), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(5, 1, 2, 0);
  d.integrator = integrator;
  const ObjectId net = s.add_net(d), other = s.add_net(d);
  Params p;
  p.set("acceleration", std::vector<double>{0, 0, 5});
  ForceEntry on;
  on.target = net;
  on.points = {1, 3};
  w.add_force("gravity", p, std::move(on), "", 0);
  step(w, 60);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(static_cast<double>(s.velocity(net, i)[2]) == Approx(i % 2 ? 5 : 0).epsilon(1e-4));
    CHECK(s.velocity(other, i)[2] == 0);
  }
  const Energy e = w.energy();
  CHECK(e.kinetic + e.potential == Approx(0).margin(2));  // order 1
  CHECK(e.kinetic == Approx(2 * 25).epsilon(1e-3));
}

TEST_CASE("stiffness and mass ratios far apart stay finite under implicit Euler", "[springs]") {
  const Real stiffness = GENERATE(Real(1), Real(1e4), Real(1e8));
  CAPTURE(stiffness);
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(12, Real(0.1), Real(1e-3), stiffness);
  for (std::size_t i = 0; i < 12; i += 3) d.masses[i] = Real(1e3);
  d.integrator = "implicit_euler";
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  step(w, 120);
  CHECK(w.is_finite());
  CHECK(s.advice(net, 1.0 / 60, 4).stable);
  CHECK(s.point(net, 11)[1] < 0);
}
