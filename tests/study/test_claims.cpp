// Published and known numbers, reproduced by sweeps: orders on the oscillator, and stiff chains.
#include <cstring>

#include "study/run.h"
#include "support/catch.h"

using namespace feder;

namespace {

constexpr bool kFloat = sizeof(Real) == 4;

StudyPoint run(const StudyProblem& problem, const MethodInfo& m, int steps) {
  StudyPoint point;
  run_point(problem, m, {m.name, steps, 0, 0, 0, {}}, RunLimits(), WorkWeights(), point, nullptr);
  return point;
}

const MethodInfo* find(const std::vector<MethodInfo>& methods, const char* name) {
  for (const MethodInfo& m : methods)
    if (m.name == name) return &m;
  return nullptr;
}

std::unique_ptr<StudyProblem> chain(const char* stiffness, const char* ratio) {
  Params p;
  set_option(p, stiffness);
  set_option(p, ratio);
  return make_study_problem("swinging_chain", p);
}

}  // namespace

TEST_CASE("equal force evaluations on the oscillator give the printed errors", "[study][claims]") {
  struct Row {
    const char* name;
    int evals;  // per step
    double errors[3];
  };
  const Row rows[] = {{"explicit_euler", 1, {5.2e-1, 4.3e-2, 4.2e-3}},
                      {"symplectic_euler", 1, {2.5e-2, 2.3e-3, 2.3e-4}},
                      {"midpoint", 2, {4.6e-2, 4.6e-4, 4.6e-6}},
                      {"heun", 2, {4.6e-2, 4.6e-4, 4.6e-6}},
                      {"rk2", 2, {4.6e-2, 4.6e-4, 4.6e-6}},
                      {"velocity_verlet", 1, {2.5e-3, 2.5e-5, 2.5e-7}},
                      {"yoshida4", 3, {2.5e-3, 2.5e-7, 2.5e-11}},
                      {"rk4", 4, {1.0e-3, 1.0e-7, 1.0e-11}}};
  const auto problem = make_study_problem("oscillator", Params());
  const std::vector<MethodInfo> methods = problem->methods();
  int found = 0;
  for (const Row& row : rows) {
    const MethodInfo* m = find(methods, row.name);
    if (!m) continue;
    ++found;
    int budget = 120;
    for (const double expected : row.errors) {
      const StudyPoint p = run(*problem, *m, budget / row.evals);
      const double state = std::hypot(p.err_end, p.err_end_v);
      CAPTURE(row.name, budget);
      if (expected > (kFloat ? 1e-4 : 0))
        CHECK(state == Approx(expected).epsilon(0.1));
      else if (kFloat)
        CHECK(state < 5e-5);
      budget *= 10;
    }
  }
  CHECK(found >= 4);
}

TEST_CASE("stiff chains: explicit methods fail and are told, implicit ones have the printed errors",
          "[study][claims]") {
  struct Row {
    const char* name;
    int steps;
    const char* ratio;
    double error;      // printed
    double tolerance;  // relative
  };
  // steps of one rounding in the table; solvers that stop early end elsewhere at 60 steps, and that is told as slow
  const Row rows[] = {
      {"implicit_euler", 600, "ratio=1", 4.3e-2, 0.05},   {"implicit_euler", 6000, "ratio=1", 6.9e-3, 0.05},
      {"implicit_euler", 600, "ratio=1000", 2.7e-2, 0.1}, {"bdf2", 600, "ratio=1", 5.1e-4, 0.2},
      {"bdf2", 600, "ratio=1000", 4.4e-4, 0.2},           {"implicit_midpoint", 600, "ratio=1", 1.9e-4, 0.2}};
  for (const Row& row : rows) {
    const auto problem = chain("stiffness=1e8", row.ratio);
    const std::vector<MethodInfo> methods = problem->methods();
    const MethodInfo* m = find(methods, row.name);
    if (!m) continue;
    const StudyPoint p = run(*problem, *m, row.steps);
    CAPTURE(row.name, row.steps, row.ratio, name_of(p.status), p.reason);
    REQUIRE(p.completed);
    // in float the links are known to 1e-6 of their length: that is what errors below 1e-3 are made of
    if (!kFloat && p.status == PointStatus::ok)
      CHECK(p.err_end == Approx(row.error).epsilon(row.tolerance));
    else
      CHECK(p.err_end < 3 * row.error + (kFloat ? 2e-3 : 0));
  }
  const auto problem = chain("stiffness=1e8", "ratio=1");
  for (const MethodInfo& m : problem->methods()) {
    if (m.implicit || m.adaptive || !(m.limit_hw < 10)) continue;
    const StudyPoint p = run(*problem, m, 6000);
    CAPTURE(m.name);
    CHECK((p.status == PointStatus::diverged || p.status == PointStatus::nan));
    CHECK_FALSE(p.reason.empty());
    CHECK(p.status_t_s > 0);
    CHECK(p.status_t_s <= 1);
  }
  const std::vector<MethodInfo> methods = problem->methods();
  const StudyPoint verlet = run(*problem, *find(methods, "velocity_verlet"), 60000);
  CHECK(verlet.status == PointStatus::ok);
  CHECK(verlet.err_end < (kFloat ? 1e-3 : 1.1e-8));
}
