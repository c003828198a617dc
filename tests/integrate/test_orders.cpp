// Order of convergence of every registered method on problems with known solutions.
#include <memory>

#include "feder/memory.h"
#include "fields.h"
#include "integrate/integrator.h"
#include "spring_field.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

struct Problem {
  const char* name;
  std::shared_ptr<ForceField> field;
  State start;
  double t_end;
  Vec3 x_end, v_end;
  double v_scale;   // a velocity error counts as this many metres per m/s
  int first_steps;  // of the ladder
};

Problem oscillator_problem(const char* name, double k, double c, double t, int first_steps) {
  const double w0 = std::sqrt(k), decay = c / 2, wd = std::sqrt(k - decay * decay);
  const double e = std::exp(-decay * t);
  const double x = e * (std::cos(wd * t) + decay / wd * std::sin(wd * t)), v = -e * k / wd * std::sin(wd * t);
  return {name,
          std::make_shared<SpringField>(oscillator(static_cast<Real>(k), static_cast<Real>(c))),
          {{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}},
          t,
          Vec3(static_cast<Real>(x), 0, 0),
          Vec3(static_cast<Real>(v), 0, 0),
          1 / w0,
          first_steps};
}

std::vector<Problem> problems(int order) {
  std::vector<Problem> all;
  all.push_back(oscillator_problem("oscillator", 1, 0, 30, 30));
  all.push_back(oscillator_problem("damped oscillator", 100, 1, 2, 14));
  // rest length 1, stiffness 100, released horizontally; only the position is known
  const auto spring = std::make_shared<SpringField>();
  spring->springs.push_back({spring->add_point(1), kNone, 100, 0, 1});
  spring->gravity = Vec3(0, Real(-9.81), 0);
  all.push_back({"spring pendulum",
                 spring,
                 {{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}},
                 1,
                 Vec3(Real(-0.98019693612978), Real(-0.61505532144325), 0),
                 Vec3(0, 0, 0),
                 0,
                 10});
  // released at a right angle
  all.push_back({"pendulum",
                 std::make_shared<PendulumField>(),
                 {{Vec3(kPi / 2, 0, 0)}, {Vec3(0, 0, 0)}},
                 10,
                 Vec3(Real(-0.94686245325590347), 0, 0),
                 Vec3(Real(-1.0809554582362733), 0, 0),
                 1,
                 10});
  // eccentricity 0.9, from pericentre. In 113 bits, errors of order 5 at t = 1 fall by 5 +- 0.1 below
  // 1e-14 only, which is rounding here; at t = 10 they do so from 1e-9 on.
  const State start = {{Vec3(Real(0.1), 0, 0)}, {Vec3(0, Real(4.3588989435406736), 0)}};
  if (order > 4)
    all.push_back({"Kepler", std::make_shared<KeplerField>(), start, 10,
                   Vec3(Real(-1.8538537094055792), Real(-0.13088540483992555), 0),
                   Vec3(Real(0.16156945255843134), Real(-0.22371927679189709), 0), 1, 960});
  else
    all.push_back({"Kepler", std::make_shared<KeplerField>(), start, 1,
                   Vec3(Real(-1.1871884663458634), Real(0.41752763873976423), 0),
                   Vec3(Real(-0.76114201052149136), Real(-0.099472047870273486), 0), 1, 60});
  return all;
}

}  // namespace

TEST_CASE("integrators converge with their stated order", "[integrate][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const auto& method = integrators()[static_cast<std::size_t>(row)];
  const int which = GENERATE(range(0, 5));
  Params options;
  Arena arena("test");
  if (method.make(arena, options)->info().adaptive) options.set("adaptive", false);
  const IntegratorInfo info = method.make(arena, options)->info();
  const Problem p = problems(info.order)[static_cast<std::size_t>(which)];
  CAPTURE(method.name, p.name, info.order);
  // float leaves no room between the first steps and rounding for the last two problems and for order 5
  if (kFloat && (which > 2 || info.order > 4)) return;

  // shrink the step 64-fold below an error of 0.1, or until rounding; the order is read off the last halving
  // high orders show late; what the orbit makes of the rounding of velocities by t = 10 is about 3e-12
  const double floor = kFloat ? 2e-4 : info.order <= 4 ? 1e-9 : which == 4 ? 3e-11 : 3e-12;
  std::vector<double> errors;
  double rough = 0;
  for (double steps = p.first_steps; steps < (kFloat ? 3e4 : 1e6); steps *= std::sqrt(2.0)) {
    const auto m = method.make(arena, options);
    State s = p.start;
    const int whole = static_cast<int>(steps + 0.5);
    run(*m, *p.field, s, p.t_end, whole);
    const double error =
        static_cast<double>(length(s.x[0] - p.x_end)) + p.v_scale * static_cast<double>(length(s.v[0] - p.v_end));
    rough = std::max(rough, error);
    if (!(error > floor)) break;
    if (error < 0.1) errors.push_back(error);
    if (errors.size() > (info.order > 4 ? 20 : 12)) break;
  }
  CAPTURE(errors);
  if (info.exact_linear && which < 2) {
    CHECK(rough < (kFloat ? 1e-4 : 1e-11));
    return;
  }
  REQUIRE(errors.size() >= 3);
  const std::size_t n = errors.size();
  const double slope = std::log2(errors[n - 3] / errors[n - 1]);
  CHECK(slope == Approx(info.order).margin(kFloat ? 0.5 : 0.1));
}
