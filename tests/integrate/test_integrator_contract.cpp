// The contract of integrate/integrator.h for every registered method. A new one is enrolled by its line alone.
#include "feder/memory.h"
#include "integrate/integrator.h"
#include "spring_field.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

const Variant<Integrator>& any_method() {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  return integrators()[static_cast<std::size_t>(row)];
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
    s.x.push_back(
        Vec3(static_cast<Real>(std::cos(a)), static_cast<Real>(std::sin(a)), static_cast<Real>(0.1 * (i % 2))));
    s.v.push_back(Vec3(static_cast<Real>(i % 4) - 1, static_cast<Real>(i % 5) * Real(0.5), Real(0.3)));
  }
  return s;
}

}  // namespace

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
  if (m->info().symplectic)
    CHECK(static_cast<double>(length(momentum(true) - angular)) < (kFloat ? 5e-5 : 1e-9) * size);
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
  if (m->info().symplectic || m->info().exact_linear)
    CHECK(last == Approx(first).epsilon(2e-2));
  else if (!m->info().adaptive)
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

TEST_CASE("a state written from outside continues like a fresh start", "[integrate][contract]") {
  const auto& method = any_method();
  const bool other_step = GENERATE(false, true);
  CAPTURE(method.name, other_step);
  Arena arena("test");
  const auto used = method.make(arena, Params()), fresh = method.make(arena, Params());
  SpringField f = ring(8, 1);
  State a = ring_state(8);
  for (int k = 0; k < 7; ++k) used->step(f, 0, Real(0.01), a.x, a.v);
  State b = ring_state(8);
  // one velocity of the state it left is enough: a push on a single point
  if (!other_step) {
    b = a;
    b.v[5] += Vec3(Real(0.01), 0, 0);
  }
  a = b;
  for (int k = 0; k < 3; ++k) {
    used->step(f, 0, other_step ? Real(0.02) : Real(0.01), a.x, a.v);
    fresh->step(f, 0, other_step ? Real(0.02) : Real(0.01), b.x, b.v);
  }
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    CHECK(a.x[i] == b.x[i]);
    CHECK(a.v[i] == b.v[i]);
  }
}

TEST_CASE("what a method remembers is in its memory", "[integrate][contract]") {
  const auto& method = any_method();
  CAPTURE(method.name);
  Arena arena("test");
  const auto first = method.make(arena, Params()), second = method.make(arena, Params());
  SpringField f = ring(8, 1);
  State a = ring_state(8);
  for (int k = 0; k < 7; ++k) first->step(f, 0, Real(0.01), a.x, a.v);
  State b = a;
  second->memory.points = first->memory.points;
  second->memory.numbers = first->memory.numbers;
  for (int k = 0; k < 5; ++k) {
    // h may change as well
    const Real h = k < 2 ? Real(0.01) : Real(0.013);
    first->step(f, 0, h, a.x, a.v);
    second->step(f, 0, h, b.x, b.v);
  }
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
  if (m->info().implicit || m->info().adaptive)
    CHECK(evals >= m->info().evals_per_step);
  else
    CHECK(evals == m->info().evals_per_step);
  CHECK(m->stats.unconverged == 0);
}
