// What is said about a net before it runs, against what happens when it runs.
#include <algorithm>
#include <cmath>

#include "integrate/integrator.h"
#include "nets.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

constexpr double kTwoPi = 6.283185307179586;

// A point of 1 kg on a spring of 1 N/m and no length: a linear oscillator with w = 1, let go at x = 1.
NetDesc oscillator(const char* integrator) {
  NetDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(1, 0, 0)};
  d.masses = {1, 1};
  d.springs = {{0, 1, 1, 0, 0}};
  d.integrator = integrator;
  return d;
}

}  // namespace

TEST_CASE("the predicted error of a period is right within a factor of ten", "[springs][advice]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const double z = GENERATE(0.05, 0.2);
  const char* integrator = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(integrator, z);
  World w(weightless(z, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  const ObjectId net = s.add_net(oscillator(integrator));
  s.pin(net, 0);
  const NetAdvice a = s.advice(net, z, 1);
  CHECK(a.frequency == Approx(1));
  CHECK(a.h == Approx(z));
  if (a.method.adaptive) return;  // its tolerance is the error
  // the largest error of a period: that of some methods oscillates within it
  const int steps = static_cast<int>(std::lround(kTwoPi / z));
  double error = 0;
  for (int k = 1; k <= steps; ++k) {
    w.step();
    const double dx = static_cast<double>(s.point(net, 1)[0]) - std::cos(z * k);
    const double dv = static_cast<double>(s.velocity(net, 1)[0]) + std::sin(z * k);
    error = std::max(error, std::sqrt(dx * dx + dv * dv));
  }
  const double rounding = sizeof(Real) == 4 ? 2e-4 : 1e-9;
  CAPTURE(a.error, error);
  CHECK(error <= 10 * a.error + rounding);
  if (!a.method.exact_linear) CHECK(error >= a.error / 10 - rounding);
}

TEST_CASE("a net within the advised substeps stays bounded, one beyond its limit does not", "[springs][advice]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const char* integrator = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(integrator);
  // a free chain swings at 2 sqrt(k/m) = 200/s at most: its Gershgorin bound is sharp
  NetDesc d = row_net(40, 1, 1, 1e4);
  for (std::size_t i = 0; i < 40; ++i) d.velocities.push_back(Vec3(i % 2 ? Real(0.1) : Real(-0.1), 0, 0));
  d.integrator = integrator;
  const double dt = 0.1;
  WorldDesc desc = weightless(dt, 1);
  World probe(desc, kSpringsOnly);
  const ObjectId asked = probe.need<Springs>().add_net(d);
  const NetAdvice a = probe.need<Springs>().advice(asked, dt, 1);
  CHECK(a.frequency == Approx(200));
  CHECK(a.stability_number == Approx(20));
  const bool limited = !std::isinf(a.method.stability_limit) && !a.method.adaptive;
  CHECK(a.stable != limited);
  CHECK(a.never_stable == (a.method.stability_limit == 0));
  const auto energy_after = [&](int substeps) {
    desc.substeps = substeps;
    World w(desc, kSpringsOnly);
    const ObjectId net = w.need<Springs>().add_net(d);
    CHECK(w.need<Springs>().advice(net, dt, substeps).stable == (substeps > 1 || !limited));
    double most = 0;
    for (int k = 0; k < 60; ++k) {
      w.step();
      if (!w.is_finite()) return 1e300;
      const Energy e = w.energy();
      most = std::max(most, e.kinetic + e.elastic);
    }
    return most;
  };
  const double start = 0.5 * 40 * 0.01;
  if (!limited || a.never_stable) return;
  CHECK(a.substeps >= static_cast<int>(std::ceil(20 / a.method.stability_limit)));
  CHECK(energy_after(a.substeps) < 10 * start);
  CHECK(energy_after(1) > 1e3 * start);
}

TEST_CASE("damping counts for methods that take it explicitly", "[springs][advice]") {
  // h w = 0.1, but the dashpot decays at 60/s: beyond the real axis of RK4
  World w(weightless(0.1, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = oscillator("rk4");
  d.springs[0].damping = 60;
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  const NetAdvice a = s.advice(net, 0.1, 1);
  CHECK(a.decay == Approx(60));
  CHECK_FALSE(a.stable);
  CHECK(a.substeps == 3);
}
