// rk45 (step control), the exponential method on linear systems, BDF2 with a varying step.
#include <cmath>

#include "feder/memory.h"
#include "fields.h"
#include "integrate/integrator.h"
#include "integrate/limits.h"
#include "spring_field.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

constexpr double kYear = 6.283185307179586;  // period of the orbits

State pericentre() { return {{Vec3(Real(0.1), 0, 0)}, {Vec3(0, Real(4.3588989435406736), 0)}}; }

std::unique_ptr<Integrator> rk45(Arena& a, double tolerance) {
  Params p;
  p.set("tolerance", tolerance);
  return find_variant(integrators(), "rk45", "integrator").make(a, p);
}

}  // namespace

TEST_CASE("rk45 spends its steps where the orbit is fast", "[integrate]") {
  // error 8e-4 with about 524 evaluations, 4e-7 with 1484
  const auto error = [](double tolerance, std::uint64_t& evals, std::uint64_t& rejected) {
    Arena arena("test");
    const auto m = rk45(arena, tolerance);
    KeplerField f;
    State s = pericentre();
    m->step(f, 0, static_cast<Real>(kYear), s.x, s.v);
    evals = m->stats.force_evals, rejected = m->stats.rejected;
    CHECK(m->stats.unconverged == 0);
    CHECK(m->stats.substeps > 20);
    return static_cast<double>(length(s.x[0] - Vec3(Real(0.1), 0, 0)));
  };
  std::uint64_t evals = 0, rejected = 0;
  CHECK(error(kFloat ? 1e-5 : 3e-6, evals, rejected) < 3e-2);
  CHECK(evals < 700);
  CHECK(rejected > 0);
  if (kFloat) return;
  CHECK(error(1e-9, evals, rejected) < 1e-5);
  CHECK(evals < 2500);
  CHECK(error(1e-12, evals, rejected) < 1e-8);
}

TEST_CASE("rk45 says when it ran out of steps", "[integrate]") {
  Arena arena("test");
  Params p;
  p.set("max_steps", 5.0);
  const auto m = find_variant(integrators(), "rk45", "integrator").make(arena, p);
  KeplerField f;
  State s = pericentre();
  m->step(f, 0, static_cast<Real>(kYear), s.x, s.v);
  CHECK(m->stats.unconverged == 1);
  CHECK(m->stats.substeps <= 6);
}

TEST_CASE("the exponential method is exact on oscillators at any step", "[integrate]") {
  struct Row {
    double frequency, zeta, h;
  };
  const Row r = GENERATE(Row{1, 0, 0.1}, Row{1, 0, 10}, Row{10, 0.1, 1}, Row{10, 0.999, 0.5}, Row{10, 5.05, 1},
                         Row{1e3, 0, 1}, Row{1e3, 0.01, 0.1}, Row{1e6, 0, 1}, Row{1e6, 2, 1e-3});
  CAPTURE(r.frequency, r.zeta, r.h);
  Arena arena("test");
  const auto m = find_variant(integrators(), "exponential", "integrator").make(arena, Params());
  Oscillator f(r.frequency, r.zeta);
  Vec3 x(1, 0, 0), v(0, 0, 0);
  m->step(f, 0, static_cast<Real>(r.h), {&x, 1}, {&v, 1});
  const double k = r.frequency * r.frequency, c = 2 * r.zeta * r.frequency;
  const double t = static_cast<double>(static_cast<Real>(r.h)), decay = c / 2;
  double want_x, want_v;
  if (k > decay * decay) {
    const double w = std::sqrt(k - decay * decay), e = std::exp(-decay * t);
    want_x = e * (std::cos(w * t) + decay / w * std::sin(w * t));
    want_v = -e * k / w * std::sin(w * t);
  } else {
    const double root = std::sqrt(decay * decay - k), slow = k / (decay + root), fast = decay + root;
    want_x = (fast * std::exp(-slow * t) - slow * std::exp(-fast * t)) / (fast - slow);
    want_v = slow * fast * (std::exp(-fast * t) - std::exp(-slow * t)) / (fast - slow);
  }
  // the phase h w itself is known to one rounding; forces and states are Real
  const double rounding = 1e-15 * (10 + 4 * r.frequency * t) + (kFloat ? 1e-6 : 0);
  CHECK(static_cast<double>(x[0]) == Approx(want_x).margin(rounding));
  CHECK(static_cast<double>(v[0]) / r.frequency == Approx(want_v / r.frequency).margin(rounding));
  CHECK(m->stats.unconverged == 0);
}

TEST_CASE("the exponential method is exact on a damped linear net with many modes", "[integrate]") {
  // springs of rest length 0 are linear; against the same run in small steps
  const auto run_net = [](const char* method, int steps) {
    Arena arena("test");
    SpringField f;
    State s;
    for (int i = 0; i < 12; ++i) {
      f.add_point(Real(0.5) + Real(0.25) * static_cast<Real>(i % 3), i == 0);
      s.x.push_back(vec3(static_cast<Real>(i), static_cast<Real>(i % 2), Real(0.1) * static_cast<Real>(i * i % 7)));
      s.v.push_back(i == 0 ? Vec3(0, 0, 0) : vec3(0, static_cast<Real>(i % 3), 0));
    }
    for (std::uint32_t i = 0; i + 1 < 12; ++i) f.springs.push_back({i, i + 1, 40, 0, 0});
    f.gravity = Vec3(0, -2, 0);
    const auto m = find_variant(integrators(), method, "integrator").make(arena, Params());
    run(*m, f, s, 2, steps);
    CHECK(m->stats.unconverged == 0);
    return s;
  };
  const State exact = run_net("exponential", 1), fine = run_net("rk4", kFloat ? 500 : 20000);
  for (std::size_t i = 0; i < 12; ++i) {
    CHECK(static_cast<double>(length(exact.x[i] - fine.x[i])) < (kFloat ? 5e-4 : 1e-10));
    CHECK(static_cast<double>(length(exact.v[i] - fine.v[i])) < (kFloat ? 5e-3 : 1e-9));
  }
}

TEST_CASE("BDF2 keeps its order while the step varies, and restarts when it grows too fast", "[integrate]") {
  const auto error = [](int steps, double ratio) {
    Arena arena("test");
    const auto m = find_variant(integrators(), "bdf2", "integrator").make(arena, Params());
    Oscillator f(1, 0);
    Vec3 x(1, 0, 0), v(0, 0, 0);
    // steps alternate between h and ratio h; they add up to 5
    const double h = 5 / (steps / 2 * (1 + ratio));
    double t = 0;
    for (int k = 0; k < steps; ++k) {
      const Real now = static_cast<Real>(k % 2 ? h * ratio : h);
      m->step(f, t, now, {&x, 1}, {&v, 1});
      t += static_cast<double>(now);
    }
    return std::hypot(static_cast<double>(x[0]) - std::cos(t), static_cast<double>(v[0]) + std::sin(t));
  };
  const int fine = kFloat ? 400 : 4000;
  CHECK(std::log2(error(fine, 1.5) / error(2 * fine, 1.5)) == Approx(2).margin(kFloat ? 0.3 : 0.1));
  // steps of 3 h after h start afresh: implicit Euler every other step, order 1
  CHECK(std::log2(error(fine, 3) / error(2 * fine, 3)) == Approx(1).margin(0.2));
}
