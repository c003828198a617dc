// Positions of nets keep what rounding takes off them: small steps add up, for every integrator.
#include <cmath>

#include "integrate/integrator.h"
#include "nets.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

// One free point far out, moving by 1/200 of its last place per step, and a pinned one.
NetDesc drifter(const std::string& integrator, Real place, Real speed) {
  NetDesc d;
  d.points = {Vec3(place, -place, 0), Vec3(place, 0, 0)};
  d.velocities = {Vec3(speed, speed, 0), Vec3(0, 0, 0)};
  d.masses = {1, 1};
  d.integrator = integrator;
  return d;
}

}  // namespace

TEST_CASE("steps far below the last place of a position add up", "[springs][compensated]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const std::string name = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(name);
  const Real place = 1000;
  const double dt = 1.0 / 1024, last_place = static_cast<double>(kEpsilon) * 512;
  const Real speed = static_cast<Real>(last_place / 200 / dt);
  World w(weightless(dt, 1), kSpringsOnly);
  Springs& springs = w.need<Springs>();
  const ObjectId net = springs.add_net(drifter(name, place, speed));
  springs.pin(net, 1);
  step(w, 2000);
  const double expected = 2000 * dt * static_cast<double>(speed);  // ten last places
  CHECK(static_cast<double>(springs.point(net, 0)[0] - place) == Approx(expected).margin(1.1 * last_place));
  CHECK(static_cast<double>(springs.point(net, 0)[1] + place) == Approx(expected).margin(1.1 * last_place));
  CHECK(springs.point(net, 1) == Vec3(place, 0, 0));
}

TEST_CASE("the low part of a position is state: in hash and snapshot, gone when a point is put somewhere",
          "[springs][compensated]") {
  const Real place = 1000, speed = kEpsilon * 512 * 1024 / 200;
  World a(weightless(1.0 / 1024, 1), kSpringsOnly), b(weightless(1.0 / 1024, 1), kSpringsOnly);
  const ObjectId in_a = a.need<Springs>().add_net(drifter("velocity_verlet", place, speed));
  const ObjectId in_b = b.need<Springs>().add_net(drifter("velocity_verlet", place, speed));
  const std::uint64_t fresh = a.hash();
  step(a, 50);
  CHECK(a.need<Springs>().point(in_a, 0)[0] == place);  // nothing to be seen yet
  CHECK(a.hash() != fresh);
  const std::string saved = a.snapshot();
  step(a, 500);
  const std::uint64_t later = a.hash();
  a.restore(saved);
  step(a, 500);
  CHECK(a.hash() == later);
  // two nets with different histories are equal once their points are set to equal positions
  a.restore(saved);
  b.need<Springs>().set_velocity(in_b, 0, Vec3(2 * speed, 0, 0));
  step(b, 50);
  CHECK(a.hash() != b.hash());
  const auto put = [&](Springs& springs, ObjectId net) {
    for (const std::size_t i : {0u, 1u}) {
      springs.set_point(net, i, Vec3(place, 0, 0));
      springs.set_velocity(net, i, Vec3(0, 0, 0));
    }
  };
  put(a.need<Springs>(), in_a), put(b.need<Springs>(), in_b);
  CHECK(a.hash() == b.hash());
}

// 1 kg and 1e6 kg in series (tests of the study: two_masses): at fine steps the heavy one moves by less than its last
// place per step. Both modes in closed form.
TEST_CASE("finer steps do not make a heavy and a light mass worse", "[springs][compensated]") {
  const char* const method = GENERATE("rk4", "heun", "leapfrog", "velocity_verlet", "yoshida4", "bdf2", "tr_bdf2");
  CAPTURE(method);
  const double k = 1e4, mass = 1e6, t_end = 10;
  const int steps = 40000;
  World w(weightless(t_end / steps, 1), kSpringsOnly);
  Springs& springs = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(Real(1.05), 0, 0), Vec3(Real(2.1), 0, 0)};
  d.masses = {1, 1, static_cast<Real>(mass)};
  d.springs = {{0, 1, static_cast<Real>(k), 0, 1, kInfinity}, {1, 2, static_cast<Real>(k), 0, 1, kInfinity}};
  d.integrator = method;
  const ObjectId net = springs.add_net(d);
  springs.pin(net, 0);
  // modes of M^-1/2 K M^-1/2 = [2k, -k/s; -k/s, k/mass], s = sqrt(mass)
  const double s = std::sqrt(mass), a = 2 * k, b = -k / s, c = k / mass, mean = (a + c) / 2;
  const double root = std::sqrt((a - c) * (a - c) / 4 + b * b), fast = mean + root, slow = (a * c - b * b) / fast;
  const double u0 = static_cast<double>(d.points[1][0]) - 1, u1 = (static_cast<double>(d.points[2][0]) - 2) * s;
  double heavy = 0;
  for (const double l : {slow, fast}) {
    const double vx = b, vy = l - a, square = vx * vx + vy * vy;
    heavy += (vx * u0 + vy * u1) / square * vy * std::cos(std::sqrt(l) * t_end);
  }
  step(w, steps);
  const double error = std::fabs(static_cast<double>(springs.point(net, 2)[0]) - 2 - heavy / s) / 0.1;
  // bdf2 and tr_bdf2 still round their velocities, which the next step takes over
  const bool remembers = std::string(method).ends_with("bdf2");
  CHECK(error <= (remembers ? 1e-4 : 1e-5));
}
