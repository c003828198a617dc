// The contract of integrate/integrator.h for every registered method. A new one is enrolled by its line alone.
#include "base/arena.h"
#include "spring_field.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

constexpr bool kFloat = sizeof(Real) == 4;

const Variant<Integrator>& any_method() {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  return integrators()[static_cast<std::size_t>(row)];
}

struct Problem {
  const char* name;
  SpringField field;
  State start;
  double t_end;
  Vec3 x_end, v_end;
  double v_scale;   // a velocity error counts as this many metres per m/s
  int first_steps;  // of the ladder
};

Problem oscillator_problem(const char* name, double k, double c, double t, int first_steps) {
  const double w0 = std::sqrt(k), decay = c / 2, wd = std::sqrt(k - decay * decay);  // numerics 2.1
  const double e = std::exp(-decay * t);
  const double x = e * (std::cos(wd * t) + decay / wd * std::sin(wd * t)), v = -e * k / wd * std::sin(wd * t);
  return {name, oscillator(static_cast<Real>(k), static_cast<Real>(c)), {{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}}, t,
          Vec3(static_cast<Real>(x), 0, 0), Vec3(static_cast<Real>(v), 0, 0), 1 / w0, first_steps};
}

std::vector<Problem> problems() {
  std::vector<Problem> all;
  all.push_back(oscillator_problem("oscillator", 1, 0, 30, 30));
  all.push_back(oscillator_problem("damped oscillator", 100, 1, 2, 14));
  // numerics 2.3: rest length 1, stiffness 100, released horizontally; only the position is known
  SpringField pendulum;
  pendulum.springs.push_back({pendulum.add_point(1), kNone, 100, 0, 1});
  pendulum.gravity = Vec3(0, Real(-9.81), 0);
  all.push_back({"spring pendulum", pendulum, {{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}}, 1,
                 Vec3(Real(-0.98019693612978), Real(-0.61505532144325), 0), Vec3(0, 0, 0), 0, 10});
  return all;
}

SpringField ring(int n, Real damping) {
  SpringField f;
  for (int i = 0; i < n; ++i) f.add_point(Real(0.5) + Real(0.25) * static_cast<Real>(i % 3));
  for (int i = 0; i < n; ++i)
    f.springs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>((i + 1) % n), 50, damping, 1});
  return f;
}

State ring_state(int n) {
  State s;
  for (int i = 0; i < n; ++i) {
    const double a = 6.283185307179586 * i / n;
    s.x.push_back(Vec3(static_cast<Real>(std::cos(a)), static_cast<Real>(std::sin(a)), static_cast<Real>(0.1 * (i % 2))));
    s.v.push_back(Vec3(static_cast<Real>(i % 4) - 1, static_cast<Real>(i % 5) * Real(0.5), Real(0.3)));
  }
  return s;
}

// Largest amplitude reached on x'' = -x with step z.
bool bounded(const Variant<Integrator>& method, double z, int steps) {
  Arena arena("test");
  const auto m = method.make(arena, Params());
  SpringField f = oscillator(1);
  State s{{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}};
  for (int k = 0; k < steps; ++k) {
    m->step(f, 0, static_cast<Real>(z), s.x, s.v);
    if (!(std::fabs(s.x[0][0]) < 1e4)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("integrators converge with their stated order", "[integrate][contract]") {
  const auto& method = any_method();
  const int which = GENERATE(range(0, 3));
  Problem p = problems()[static_cast<std::size_t>(which)];
  Arena arena("test");
  const int order = method.make(arena, Params())->info().order;
  CAPTURE(method.name, p.name, order);

  // shrink the step until the error reaches rounding; the order is read off the last two halvings above it
  const double floor = kFloat ? 3e-5 : 1e-9;
  std::vector<double> errors;
  for (double steps = p.first_steps; steps < (kFloat ? 3e4 : 3e5); steps *= std::sqrt(2.0)) {
    const auto m = method.make(arena, Params());
    State s = p.start;
    const int whole = static_cast<int>(steps + 0.5);
    run(*m, p.field, s, p.t_end, whole);
    const double error = static_cast<double>(length(s.x[0] - p.x_end)) +
                         p.v_scale * static_cast<double>(length(s.v[0] - p.v_end));
    if (!(error > floor)) break;
    if (error < 0.3) errors.push_back(error);
  }
  CAPTURE(errors);
  REQUIRE(errors.size() >= 3);
  const double slope = std::log2(errors[errors.size() - 3] / errors.back());
  CHECK(slope == Approx(order).margin(kFloat ? 0.5 : 0.1));
}

TEST_CASE("integrators have their stated stability limit", "[integrate][contract]") {
  const auto& method = any_method();
  Arena arena("test");
  const double limit = method.make(arena, Params())->info().stability_limit;
  CAPTURE(method.name, limit);
  if (limit == 0) {
    CHECK_FALSE(bounded(method, 0.05, 20000));
  } else if (std::isinf(limit)) {
    CHECK(bounded(method, 1e3, 2000));
    CHECK(bounded(method, 3, 20000));
  } else {
    double lo = 0.1, hi = 10;
    while (hi - lo > 1e-4) {
      const double mid = (lo + hi) / 2;
      (bounded(method, mid, 20000) ? lo : hi) = mid;
    }
    CHECK(lo == Approx(limit).epsilon(2e-3));
  }
}

TEST_CASE("integrators keep the momentum of a free system", "[integrate][contract]") {
  const auto& method = any_method();
  const Real damping = GENERATE(Real(0), Real(2));
  CAPTURE(method.name, damping);
  Arena arena("test");
  const auto m = method.make(arena, Params());
  SpringField f = ring(8, damping);
  State s = ring_state(8);
  const auto momentum = [&](bool angular) {
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < s.x.size(); ++i) p += f.masses[i] * (angular ? cross(s.x[i], s.v[i]) : s.v[i]);
    return p;
  };
  const Vec3 linear = momentum(false), angular = momentum(true);
  const double size = 8.0;  // sum of m |v| is about that
  for (int k = 0; k < 200; ++k) m->step(f, 0, Real(0.01), s.x, s.v);
  CHECK(static_cast<double>(length(momentum(false) - linear)) < (kFloat ? 2e-5 : 1e-9) * size);
  if (m->info().symplectic) CHECK(static_cast<double>(length(momentum(true) - angular)) < (kFloat ? 5e-5 : 1e-9) * size);
}

TEST_CASE("pinned points do not move", "[integrate][contract]") {
  const auto& method = any_method();
  CAPTURE(method.name);
  Arena arena("test");
  const auto m = method.make(arena, Params());
  SpringField f = ring(8, 1);
  f.gravity = Vec3(0, Real(-9.81), 0);
  State s = ring_state(8);
  for (const std::size_t i : {0u, 3u}) f.inv_masses[i] = 0, s.v[i] = Vec3::Zero();
  const State start = s;
  for (int k = 0; k < 50; ++k) m->step(f, 0, Real(0.01), s.x, s.v);
  for (const std::size_t i : {0u, 3u}) {
    CHECK(s.x[i] == start.x[i]);
    CHECK(s.v[i] == Vec3(0, 0, 0));
  }
  CHECK(length(s.x[1] - start.x[1]) > Real(0.01));
}

TEST_CASE("symplectic integrators keep energy in the mean", "[integrate][contract]") {
  const auto& method = any_method();
  Arena arena("test");
  const auto m = method.make(arena, Params());
  CAPTURE(method.name);
  SpringField f = oscillator(1);
  State s{{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}};
  const auto mean_over_periods = [&](int periods) {
    double sum = 0;
    const int steps = periods * 21;  // h = 0.3: 20.94 steps per period
    for (int k = 0; k < steps; ++k) {
      m->step(f, 0, Real(0.3), s.x, s.v);
      sum += 0.5 * static_cast<double>(dot(s.x[0], s.x[0]) + dot(s.v[0], s.v[0]));
    }
    return sum / steps;
  };
  const double first = mean_over_periods(20);
  mean_over_periods(1000);
  const double last = mean_over_periods(20);
  if (m->info().symplectic)
    CHECK(last == Approx(first).epsilon(2e-2));
  else
    CHECK_FALSE(std::fabs(last / first - 1) < 0.05);  // else it should say so in info()
}

TEST_CASE("integrators allocate only in the first step", "[integrate][contract]") {
  const auto& method = any_method();
  CAPTURE(method.name);
  Arena arena("test");
  const auto m = method.make(arena, Params());
  SpringField f = ring(12, 1);
  State s = ring_state(12);
  m->step(f, 0, Real(0.01), s.x, s.v);
  const std::uint64_t before = arena.allocations();
  REQUIRE(before > 0);
  for (int k = 0; k < 20; ++k) m->step(f, 0, Real(0.01), s.x, s.v);
  CHECK(arena.allocations() == before);
}

TEST_CASE("integrators remember nothing between steps", "[integrate][contract]") {
  const auto& method = any_method();
  CAPTURE(method.name);
  Arena arena("test");
  const auto used = method.make(arena, Params()), fresh = method.make(arena, Params());
  SpringField f = ring(8, 1);
  State a = ring_state(8);
  for (int k = 0; k < 7; ++k) used->step(f, 0, Real(0.01), a.x, a.v);
  a = ring_state(8);
  State b = ring_state(8);
  used->step(f, 0, Real(0.02), a.x, a.v);
  fresh->step(f, 0, Real(0.02), b.x, b.v);
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    CHECK(a.x[i] == b.x[i]);
    CHECK(a.v[i] == b.v[i]);
  }
}

TEST_CASE("integrators count their work as they say", "[integrate][contract]") {
  const auto& method = any_method();
  CAPTURE(method.name);
  Arena arena("test");
  const auto m = method.make(arena, Params());
  SpringField f = oscillator(1);
  State s{{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}};
  for (int k = 0; k < 100; ++k) m->step(f, 0, Real(0.1), s.x, s.v);
  const double evals = static_cast<double>(m->stats.force_evals) / 100;
  if (m->info().implicit)
    CHECK(evals >= m->info().evals_per_step);
  else
    CHECK(evals == m->info().evals_per_step);
  CHECK(m->stats.unconverged == 0);
}
