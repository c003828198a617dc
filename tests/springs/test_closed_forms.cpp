// Nets against closed forms: pendulum period, frequencies of chains, hanging chain, free fall with drag.
#include <cmath>

#include "integrate/integrator.h"
#include "nets.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

// Times of upward zero crossings of `value(step)` in seconds, by linear interpolation; the mean period.
template <class F>
double mean_period(World& w, int steps, F&& value) {
  double before = value(), first = -1, last = -1;
  int crossings = 0;
  for (int k = 0; k < steps; ++k) {
    const double t = w.time();
    w.step();
    const double now = value();
    if (before < 0 && now >= 0) {
      last = t + (w.time() - t) * before / (before - now);
      if (first < 0) first = last;
      ++crossings;
    }
    before = now;
  }
  return crossings > 1 ? (last - first) / (crossings - 1) : 0;
}

const char* any_integrator() {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  return integrators()[static_cast<std::size_t>(row)].name;
}

bool order_two_or_symplectic(const char* name) {
  Arena arena("test");
  const IntegratorInfo info = find_variant(integrators(), name, "integrator").make(arena, Params())->info();
  return info.symplectic || info.order >= 2;
}

}  // namespace

TEST_CASE("a stiff spring pendulum has the pendulum's period", "[springs]") {
  const char* integrator = any_integrator();
  if (!order_two_or_symplectic(integrator)) return;  // first-order ones damp or blow up, see the contract test
  CAPTURE(integrator);
  WorldDesc wd;
  wd.dt = 1.0 / 240;
  wd.substeps = 8;
  World w(wd, kSpringsOnly);
  NetDesc d;
  // 90 degrees from the vertical; the length is that of the hanging pendulum
  d.points = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  d.masses = {1, 1};
  d.springs = {{0, 1, Real(1e5), 0, 1}};
  d.integrator = integrator;
  Springs& s = w.need<Springs>();
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  const double period = mean_period(w, 240 * 10, [&] { return static_cast<double>(s.point(net, 1)[0]); });
  // elliptic integral: 2.3678419475762374 for the rigid pendulum; a spring of 1e5 N/m is up to 3e-4 longer
  CHECK(period == Approx(2.36784194757).epsilon(5e-4));
}

TEST_CASE("chains swing with their eigenfrequencies", "[springs]") {
  // ten free masses of 1 kg with springs of 100 N/m, started on one eigenvector
  struct Case {
    const char* ends;
    bool left, right;
    double w;
    int mode;
  };
  const Case c = GENERATE(
      Case{"fixed-fixed", true, true, 2.846296765465703, 1}, Case{"fixed-fixed", true, true, 19.79642883761865, 10},
      Case{"fixed-free", true, false, 1.494601871728485, 1}, Case{"free-free", false, false, 3.128689300804617, 1});
  const char* integrator = any_integrator();
  if (!order_two_or_symplectic(integrator)) return;
  CAPTURE(c.ends, c.mode, integrator);
  // large swings in large steps, so that float positions do not round a step's motion away
  World w(weightless(1.0 / 480, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  const std::size_t extra = c.left + c.right, n = 10;
  NetDesc d = row_net(n + extra, 1, 1, 100);
  d.integrator = integrator;
  const double pi = 3.141592653589793;
  for (std::size_t j = 1; j <= n; ++j) {
    double phi = std::sin(static_cast<double>(j) * c.mode * pi / 11);
    if (!c.right) phi = std::sin(static_cast<double>(j) * (2 * c.mode - 1) * pi / 21);
    if (!c.left) phi = std::cos((static_cast<double>(j) - 0.5) * c.mode * pi / 10);
    d.points[j - 1 + c.left][0] += static_cast<Real>(0.3 * phi);
  }
  const ObjectId net = s.add_net(d);
  if (c.left) s.pin(net, 0);
  if (c.right) s.pin(net, n + extra - 1);
  const std::size_t probe = c.left;  // the first free mass moves in every mode
  const double rest = static_cast<double>(probe);
  const double period = mean_period(w, 480 * 10, [&] { return static_cast<double>(s.point(net, probe)[0]) - rest; });
  CHECK(2 * pi / period == Approx(c.w).epsilon(1e-3));
}

TEST_CASE("a hanging chain carries the weight below every link", "[springs]") {
  WorldDesc wd;
  wd.substeps = 8;
  World w(wd, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(11, Real(0.1), Real(0.5), 20000);
  for (std::size_t i = 0; i < d.points.size(); ++i) d.points[i] = Vec3(0, Real(-0.1) * static_cast<Real>(i), 0);
  d.masses.back() = 5;
  d.damping = 4;
  const char* integrator = GENERATE("symplectic_euler", "implicit_euler");
  d.integrator = integrator;
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  step(w, 60 * 15);
  for (std::size_t k = 0; k < 10; ++k) {
    const double below = 9.81 * (5 + 0.5 * static_cast<double>(9 - k));
    const double tension = 20000 * 0.1 * static_cast<double>(s.strain(net, k));
    CHECK(tension == Approx(below).epsilon(sizeof(Real) == 4 ? 2e-3 : 1e-5));
  }
}

TEST_CASE("extreme mass ratio: a chain of 10 links holds 1e6 kg", "[springs]") {
  // springs of 1e8 N/m, nine masses of 1 kg and a last of 1e6 kg: top tension 9810088.29 N
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(11, 1, 1, Real(1e8));
  for (std::size_t i = 0; i < d.points.size(); ++i) d.points[i] = Vec3(0, -static_cast<Real>(i), 0);
  d.masses.back() = Real(1e6);
  d.damping = 3;
  d.integrator = "implicit_euler";
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  step(w, 60 * 10);
  CHECK(1e8 * static_cast<double>(s.strain(net, 0)) == Approx(9810088.29).epsilon(1e-3));
  CHECK(static_cast<double>(s.point(net, 10)[1]) == Approx(-10.9810044).epsilon(1e-5));
}

TEST_CASE("drag by the damping of a net gives the exponential fall", "[springs]") {
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(0, 0, 0)};
  d.masses = {2};
  d.damping = 3;
  const ObjectId net = s.add_net(d);
  step(w, 60);
  // v = -(g/c)(1 - e^-ct)
  CHECK(static_cast<double>(s.velocity(net, 0)[1]) == Approx(-9.81 / 3 * (1 - std::exp(-3.0))).epsilon(2e-3));
}

TEST_CASE("energy of a net: kinetic, weight, springs, and all together kept", "[springs]") {
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(2, 1, 2, 500);
  d.springs[0].rest_length = Real(0.8);
  d.integrator = "velocity_verlet";
  const ObjectId net = s.add_net(d);
  s.set_point(net, 0, Vec3(0, 3, 0));
  s.set_point(net, 1, Vec3(1, 3, 0));
  s.set_velocity(net, 1, Vec3(0, 0, 4));
  const Energy e = w.energy();
  CHECK(e.kinetic == Approx(16));
  CHECK(e.potential == Approx(2 * 2 * 9.81 * 3));
  CHECK(e.elastic == Approx(0.5 * 500 * 0.04).epsilon(1e-5));
  const double before = e.kinetic + e.potential + e.elastic;
  step(w, 120);
  const Energy f = w.energy();
  CHECK(std::fabs(f.kinetic + f.potential + f.elastic - before) < 2e-3 * before);
}
