// Forces inside an integrator's step: formulas are evaluated at every stage, at its time and state, so that methods
// keep their order; implicit ones see the derivative.
#include <cmath>
#include <functional>

#include "feder/force.h"
#include "integrate/integrator.h"
#include "nets.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

constexpr bool kFloat = sizeof(Real) == 4;

struct Motion {
  const char* name;
  std::vector<Vec3> points, velocities;
  std::string formula;  // along x; empty: pairwise attraction
  double t_end;
  int first_steps;
  std::function<void(long double, const long double*, long double*)> accelerate;  // written apart: x y per point
};

std::vector<Motion> motions() {
  std::vector<Motion> all;
  all.push_back(
      {"Duffing",
       {Vec3(1, 0, 0)},
       {Vec3(0, 0, 0)},
       "-x - 2*x^3",
       10,
       80,
       [](long double, const long double* y, long double* a) { a[0] = -y[0] - 2 * y[0] * y[0] * y[0], a[1] = 0; }});
  all.push_back({"driven and damped",
                 {Vec3(1, 0, 0)},
                 {Vec3(0, 0, 0)},
                 "-4*x - 0.2*vx + 0.5*cos(1.5*t)",
                 10,
                 80,
                 [](long double t, const long double* y, long double* a) {
                   a[0] = -4 * y[0] - 0.2L * y[2] + 0.5L * std::cos(1.5L * t), a[1] = 0;
                 }});
  // figure eight of three equal masses (Chenciner & Montgomery 2000), a third of its period
  const double px = 0.97000436, py = -0.24308753, vx = 0.466203685, vy = 0.43236573;
  all.push_back({"three bodies",
                 {Vec3(Real(px), Real(py), 0), Vec3(Real(-px), Real(-py), 0), Vec3(0, 0, 0)},
                 {Vec3(Real(vx), Real(vy), 0), Vec3(Real(vx), Real(vy), 0), Vec3(Real(-2 * vx), Real(-2 * vy), 0)},
                 "",
                 2,
                 40,
                 [](long double, const long double* y, long double* a) {
                   for (int i = 0; i < 6; ++i) a[i] = 0;
                   for (int i = 0; i < 3; ++i)
                     for (int j = 0; j < 3; ++j) {
                       if (i == j) continue;
                       const long double dx = y[2 * j] - y[2 * i], dy = y[2 * j + 1] - y[2 * i + 1];
                       const long double r2 = dx * dx + dy * dy, r3 = r2 * std::sqrt(r2);
                       a[2 * i] += dx / r3, a[2 * i + 1] += dy / r3;
                     }
                 }});
  return all;
}

// x y of every point at t_end, then their velocities, by the classical Runge-Kutta method with 40,000 steps in long
// double.
std::vector<double> reference(const Motion& m) {
  const std::size_t n = 2 * m.points.size();
  std::vector<long double> y(2 * n), slope(2 * n), stage(2 * n), sum(2 * n);
  for (std::size_t i = 0; i < n; ++i)
    y[i] = static_cast<long double>(m.points[i / 2][static_cast<int>(i % 2)]),
    y[n + i] = static_cast<long double>(m.velocities[i / 2][static_cast<int>(i % 2)]);
  const int steps = 40000;
  const long double h = static_cast<long double>(m.t_end) / steps;
  const long double reach[] = {0, h / 2, h / 2, h}, weight[] = {h / 6, h / 3, h / 3, h / 6};
  for (int k = 0; k < steps; ++k) {
    sum = y;
    for (std::size_t i = 0; i < 2 * n; ++i) slope[i] = 0;
    for (int s = 0; s < 4; ++s) {
      for (std::size_t i = 0; i < 2 * n; ++i) stage[i] = y[i] + reach[s] * slope[i];
      for (std::size_t i = 0; i < n; ++i) slope[i] = stage[n + i];
      // the damped motion reads its velocity where y[2] stands: one point, two coordinates
      m.accelerate(k * h + reach[s], stage.data(), slope.data() + n);
      for (std::size_t i = 0; i < 2 * n; ++i) sum[i] += weight[s] * slope[i];
    }
    y = sum;
  }
  return {y.begin(), y.end()};
}

// Root mean square distance from the reference at t_end, in positions and velocities: one alone may vanish by luck of
// the phase.
double error_of(const Motion& m, const std::string& integrator, int steps, const std::vector<double>& exact,
                std::uint64_t* evaluations = nullptr) {
  World w(weightless(m.t_end / steps, 1), kSpringsOnly);
  Springs& springs = w.need<Springs>();
  NetDesc d;
  d.points = m.points, d.velocities = m.velocities;
  d.masses.assign(m.points.size(), 1);
  d.integrator = integrator;
  if (integrator == "rk45") d.integrator_options.set("adaptive", false);
  ForceEntry target;
  target.target = springs.add_net(d);
  Params options;
  if (m.formula.empty())
    options.set("between", true);
  else
    options.set("x", m.formula);
  const ObjectId net = target.target;
  w.add_force(m.formula.empty() ? "attractor" : "expression", options, std::move(target), "", 0);
  step(w, steps);
  double sum = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const std::size_t k = i % (exact.size() / 2), point = k / 2;
    const Vec3 now = i == k ? springs.point(net, point) : springs.velocity(net, point);
    const double off = static_cast<double>(now[static_cast<int>(k % 2)]) - exact[i];
    sum += off * off;
  }
  if (evaluations) *evaluations = springs.stats(net).force_evals;
  return std::sqrt(sum / static_cast<double>(m.points.size()));
}

IntegratorInfo info_of(const std::string& name) {
  Arena arena("test");
  return find_variant(integrators(), name, "integrator").make(arena, {})->info();
}

}  // namespace

TEST_CASE("formulas and pairwise attraction keep the order of every integrator", "[springs][forces][order]") {
  if (kFloat) return;  // orders above 2 drown in its rounding
  const int which = GENERATE(0, 1, 2);
  const Motion m = motions()[static_cast<std::size_t>(which)];
  const std::vector<double> exact = reference(m);
  for (const Variant<Integrator>& method : integrators()) {
    const std::string name = method.name;
    const int order = info_of(name).order;
    CAPTURE(m.name, name, order);
    double error[4];  // log2
    // coarser for high orders, whose errors are the first at rounding
    const int finer = order == 1 ? 128 : order == 2 ? 16 : 2;
    for (int k = 0, steps = m.first_steps * finer; k < 4; ++k, steps *= 2) {
      error[k] = std::log2(error_of(m, name, steps, exact));
    }
    CAPTURE(error[0], error[1], error[2], error[3]);
    const double slope = (3 * (error[0] - error[3]) + error[1] - error[2]) / 10;  // least squares
    CHECK(slope == Approx(order).margin(0.25));
  }
}

TEST_CASE("rk4 reaches 1e-9 on a Duffing oscillator with 12,800 evaluations", "[springs][forces]") {
  const Motion m = motions()[0];
  std::uint64_t evaluations = 0;
  const double error = error_of(m, "rk4", 3200, reference(m), &evaluations);
  CHECK(evaluations == 12800);
  CHECK(error <= (kFloat ? 2e-6 : 1e-9));
}

TEST_CASE("an implicit method sees how stiff a formula is", "[springs][forces]") {
  const char* const method = GENERATE("implicit_euler", "bdf2", "tr_bdf2", "ros2", "exponential", "implicit_midpoint");
  CAPTURE(method);
  World w(weightless(1.0 / 60, 1), kSpringsOnly);
  Springs& springs = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(1, Real(0.5), 0)};
  d.masses = {1};
  d.integrator = method;
  ForceEntry target;
  target.target = springs.add_net(d);
  const ObjectId net = target.target;
  Params options;
  options.set("x", std::string("-k*x")), options.set("y", std::string("-k*y - 10*vy")), options.set("k", 1e6);
  w.add_force("expression", options, std::move(target), "", 0);
  step(w, 120);
  CHECK(length(springs.point(net, 0)) <= Real(1.5));
  CHECK(w.is_finite());
}

TEST_CASE("advice counts the stiffness of anchors and formulas", "[springs][forces]") {
  const char* const kind = GENERATE("spring", "expression");
  World w(weightless(1.0 / 60, 1), kSpringsOnly);
  Springs& springs = w.need<Springs>();
  NetDesc d = row_net(2, 1, 1, 10);
  ForceEntry target;
  target.target = springs.add_net(d);
  const ObjectId net = target.target;
  CHECK(springs.advice(net, 1.0 / 60, 1).stable);
  Params options;
  if (kind == std::string("spring"))
    options.set("stiffness", 1e6);
  else
    options.set("x", std::string("-1e6*x"));
  w.add_force(kind, options, std::move(target), "", 0);
  const NetAdvice advice = springs.advice(net, 1.0 / 60, 1);
  CHECK_FALSE(advice.stable);
  CHECK(advice.frequency >= 1000);
  CHECK(advice.frequency <= 1100);
  w.step();
  bool stiff = false;
  for (const Event& e : w.events().list())
    stiff = stiff || (e.kind == EventKind::warning && w.events().warning_code(e) == "stiff");
  CHECK(stiff);
}

// 1 kg and 1e4 to 1e6 kg/s: the exact fall ends in a millisecond or less, the substep lasts 4.
TEST_CASE("drag that would stop a point within a substep stops it and does no more", "[springs][forces]") {
  const std::size_t at = GENERATE(range(std::size_t{0}, integrators().size()));
  const double linear = GENERATE(1e4, 1e6), quadratic = GENERATE(0.0, 1e3);
  CAPTURE(integrators()[at].name, linear, quadratic);
  World w(weightless(), kSpringsOnly);
  NetDesc d = row_net(3, 1, 1, 100);
  d.integrator = integrators()[at].name;
  Springs& s = w.need<Springs>();
  const ObjectId net = s.add_net(d);
  for (std::uint32_t i = 0; i < 3; ++i) s.set_velocity(net, i, Vec3(3, Real(i) - 1, 0));
  ForceEntry all;
  all.all = true;
  Params p;
  p.set("linear", linear);
  p.set("quadratic", quadratic);
  w.add_force("drag", p, std::move(all), "", 0);
  const double before = w.energy().kinetic;
  for (int k = 0; k < 60; ++k) {
    w.step();
    REQUIRE(w.is_finite());
    CHECK(w.energy().kinetic <= before);
  }
  // implicit_midpoint does not damp modes far too fast for it: their sign alternates each step
  if (d.integrator != "implicit_midpoint") CHECK(w.energy().kinetic < 1e-3 * before);
}

TEST_CASE("a formula without a value is warned about once, by name", "[springs][forces]") {
  World w(weightless(), kSpringsOnly);
  ForceEntry target;
  target.target = w.need<Springs>().add_net(row_net(2, 1, 1, 10));
  Params options;
  options.set("x", std::string("sqrt(-1 - x^2)"));
  w.add_force("expression", options, std::move(target), "rooted", 0);
  w.step();
  REQUIRE(warning_of(w) == "force_domain");
  for (const Event& e : w.events().list()) CHECK_THAT(w.events().warning_message(e), Catch::Contains("rooted"));
  w.step();
  CHECK(warning_of(w) == "");
  CHECK(w.is_finite());
}

TEST_CASE("a force that a script holds through the step is warned about where it costs order", "[springs][forces]") {
  const auto warned = [](const char* integrator) {
    World w(weightless(), kSpringsOnly);
    NetDesc d = row_net(2, 1, 1, 10);
    d.integrator = integrator;
    ForceEntry entry;
    entry.target = w.need<Springs>().add_net(d);
    w.add_force(std::move(entry), "pushed", 0);
    w.step();
    const std::string first = warning_of(w);
    if (!first.empty()) CHECK_THAT(w.events().warning_message(w.events().list()[0]), Catch::Contains("pushed"));
    w.step();
    CHECK(warning_of(w) == "");
    return first;
  };
  CHECK(warned("rk4") == "frozen_force");
  CHECK(warned("implicit_euler") == "frozen_force");
  CHECK(warned("symplectic_euler") == "");
}

TEST_CASE("pairwise attraction keeps momentum and energy", "[springs][forces]") {
  World w(weightless(1e-3, 1), kSpringsOnly);
  Springs& springs = w.need<Springs>();
  const Motion m = motions()[2];
  NetDesc d;
  d.points = m.points, d.velocities = m.velocities, d.masses = {1, 1, 1};
  d.integrator = "velocity_verlet";
  ForceEntry target;
  target.target = springs.add_net(d);
  Params options;
  options.set("between", true);
  w.add_force("attractor", options, std::move(target), "", 0);
  const auto total = [&] {
    const Energy e = w.energy();
    return e.kinetic + e.potential + e.elastic;
  };
  const double before = total();
  CHECK(before == Approx(-1.287).margin(2e-3));  // of the figure eight
  step(w, 2000);
  CHECK(total() == Approx(before).margin(2e-5));
  for (const double p : w.momentum().linear) CHECK(std::fabs(p) < 2e-6);
}

TEST_CASE("springs with a power pull with that power of their extension", "[springs][forces]") {
  const int power = GENERATE(1, 2, 3, 5);
  const Real stretch = GENERATE(Real(0.5), Real(-0.25));
  const bool only = GENERATE(false, true);
  CAPTURE(power, stretch, only);
  WorldDesc desc = weightless(1e-4, 1);
  World w(desc, kSpringsOnly);
  Springs& springs = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(1 + stretch, 0, 0)};
  d.masses = {2, 1};
  d.springs = {{0, 1, 8, 0, 1, kInfinity, only, power}};
  const ObjectId net = springs.add_net(d);
  const double e = static_cast<double>(stretch);
  const double force = only && e < 0 ? 0 : 8 * std::pow(std::fabs(e), power) * (e < 0 ? -1 : 1);
  CHECK(w.energy().elastic == Approx(only && e < 0 ? 0 : 8 * std::pow(std::fabs(e), power + 1) / (power + 1)));
  w.step();
  CHECK(static_cast<double>(springs.velocity(net, 1)[0]) == Approx(-1e-4 * force).epsilon(1e-5).margin(1e-12));
  CHECK(static_cast<double>(springs.velocity(net, 0)[0]) == Approx(0.5e-4 * force).epsilon(1e-5).margin(1e-12));
  CHECK(springs.spring(net, 0).power == power);
}
