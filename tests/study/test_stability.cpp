// Stability maps: limits against theory, verdicts that must not be, and the thresholds at work.
#include <set>

#include "feder/study.h"
#include "integrate/integrator.h"
#include "support/catch.h"

using namespace feder;

namespace {

StabilityResult run(const char* problem, std::vector<std::string> methods, bool cells, bool bisect) {
  StabilityPlan p;
  p.problem = problem, p.methods = std::move(methods), p.cells = cells, p.bisect = bisect;
  return run_stability(p);
}

}  // namespace

TEST_CASE("the oscillator's limits are found to 1e-6", "[study][stability]") {
  const StabilityResult r = run("oscillator", {}, false, true);
  CHECK(r.maps.size() == integrators().size());
  for (const StabilityMap& m : r.maps)
    for (const StabilityLimit& l : m.limits) {
      CAPTURE(m.method, l.y, l.z_predicted, l.z_observed);
      if (std::isinf(l.z_predicted) || l.z_predicted == 0)
        CHECK(l.z_observed == l.z_predicted);
      else
        CHECK(std::fabs(l.z_observed / l.z_predicted - 1) < 1e-6);
    }
}

TEST_CASE("the chain's limits are within 1 % of limit / w_max", "[study][stability]") {
  StabilityPlan p;
  p.problem = "chain", p.cells = false, p.bisect = true, p.y_values = {1, 10};
  for (const Variant<Integrator>& row : integrators()) {
    Arena arena("test");
    const IntegratorInfo info = row.make(arena, Params())->info();
    if (std::isfinite(info.stability_limit) && info.stability_limit > 0) p.methods.push_back(row.name);
  }
  REQUIRE(p.methods.size() >= 5);
  for (const StabilityMap& m : run_stability(p).maps)
    for (const StabilityLimit& l : m.limits) {
      CAPTURE(m.method, l.y, l.z_predicted, l.z_observed);
      CHECK(std::fabs(l.z_observed / l.z_predicted - 1) < 0.01);
    }
}

TEST_CASE("no verdict of an implicit method is nan, and explicit ones fail by name", "[study][stability]") {
  const char* problem = GENERATE("oscillator", "chain", "swinging_chain");
  StabilityPlan p;
  p.problem = problem;
  p.y_values = std::string(problem) == "oscillator" ? std::vector<double>{0, 0.1, 2, 5} : std::vector<double>{1, 10};
  if (std::string(problem) == "swinging_chain") p.y_values = {1, 1e3, 1e6};
  p.x_values = std::string(problem) == "swinging_chain" ? std::vector<double>{1e4, 1e8, 1e12}
                                                        : std::vector<double>{1e-2, 1, 1e2, 1e6, 1e9, 1e12};
  std::set<std::string> exempt = {"implicit_midpoint"};  // gains energy on the stiff swinging chain
  for (const StabilityMap& m : run_stability(p).maps) {
    std::size_t failures = 0;
    for (const StabilityCell& c : m.cells) {
      CAPTURE(m.problem, m.method, c.x, c.y, name_of(c.verdict), c.entity, c.t_fail, c.error, c.energy_ratio);
      CHECK(c.verdict != Verdict::nan);
      if (c.verdict == Verdict::diverged) {
        ++failures;
        CHECK(c.entity.find("point") != std::string::npos);
        CHECK(c.t_fail > 0);
      }
      const bool linear = std::string(problem) != "swinging_chain";
      if (m.implicit && linear) CHECK((c.verdict != Verdict::diverged && c.verdict != Verdict::growing));
    }
    CAPTURE(m.method, m.problem);
    if (!m.implicit && std::string(problem) != "swinging_chain") CHECK(failures > 0);
  }
}

TEST_CASE("bodies at the corners of every map: no verdict is nan, failures have a name", "[study][stability]") {
  int problems = 0;
  for (const StabilityProblemInfo& info : stability_problem_infos()) {
    if (info.family != "rigid") continue;
    ++problems;
    StabilityPlan p;
    p.problem = info.name;
    p.x_values = {info.x.values.front(), info.x.values.back()},
    p.y_values = {info.y.values.front(), info.y.values.back()};
    if (info.x.name == "h") p.x_values.front() = 1e-2;  // the shortest take long
    const StabilityResult r = run_stability(p);
    CHECK(r.maps.size() >= 2);
    for (const StabilityMap& m : r.maps)
      for (const StabilityCell& c : m.cells) {
        CAPTURE(m.problem, m.method, c.x, c.y, name_of(c.verdict), c.entity, c.error, c.constraint, c.energy_ratio);
        CHECK((c.verdict != Verdict::nan && c.verdict != Verdict::diverged && c.verdict != Verdict::growing));
        if (c.verdict == Verdict::refused) CHECK_FALSE(c.entity.empty());
        // the mild corner of each map is right
        if (c.x == p.x_values.front() && c.y == p.y_values.front()) CHECK(c.verdict == Verdict::stable);
      }
  }
  CHECK(problems >= 6);
}

TEST_CASE("cloth and fluids at the corners of every map: nothing is nan, nothing diverges in silence",
          "[study][stability]") {
  if (sizeof(Real) == 8) return;  // takes minutes there, and float is the harder one
  for (const StabilityProblemInfo& info : stability_problem_infos()) {
    if (info.family != "cloth" && info.family != "fluid") continue;
    StabilityPlan p;
    p.problem = info.name;
    p.x_values = {info.x.values.front(), info.x.values.back()},
    p.y_values = {info.y.values.front(), info.y.values.back()};
    if (info.y.name == "rate") p.y_values = {30, 60};     // the many short steps take long
    if (info.y.name == "layers") p.y_values.back() = 50;  // deeper ones: the map of tests/fluid
    for (const StabilityMap& m : run_stability(p).maps)
      for (const StabilityCell& c : m.cells) {
        CAPTURE(m.problem, m.method, c.x, c.y, name_of(c.verdict), c.entity, c.error, c.energy_ratio);
        CHECK(c.verdict != Verdict::nan);
        if (c.verdict != Verdict::diverged && c.verdict != Verdict::growing) continue;
        CHECK(c.entity.find('#') != std::string::npos);  // as objects without a name are called
      }
  }
}

TEST_CASE("a box a million times heavier presses its support in: inaccurate, not stable", "[study][stability]") {
  StabilityPlan p;
  p.problem = "heavy", p.x_values = {1.0 / 60}, p.y_values = {1, 1e6};
  for (const StabilityMap& m : run_stability(p).maps) {
    CAPTURE(m.method);
    CHECK(m.cells[0].verdict == Verdict::stable);
    CHECK(m.cells[1].verdict == Verdict::inaccurate);
    CHECK(m.cells[1].error > 0.1);
  }
}

// Places in float are 1 m apart at 1e7 m: a box that should slide stands still there.
TEST_CASE("a box that stands still where it should slide is stuck", "[study][stability]") {
  StabilityPlan p;
  p.problem = "far", p.x_values = {1.0 / 60}, p.y_values = {1, 1e7};
  for (const StabilityMap& m : run_stability(p).maps) {
    CAPTURE(m.method);
    CHECK(m.cells[0].verdict == Verdict::stable);
    CHECK(m.cells[1].verdict == (sizeof(Real) == 4 ? Verdict::stuck : Verdict::stable));
  }
}

TEST_CASE("verdicts say what is wrong", "[study][stability]") {
  StabilityPlan p;
  p.problem = "oscillator", p.y_values = {0};
  const auto verdict = [&](const char* method, double x) {
    p.methods = {method}, p.x_values = {x};
    return run_stability(p).maps.front().cells.front();
  };
  CHECK(verdict("velocity_verlet", 1e-4).verdict == Verdict::stable);
  CHECK(verdict("velocity_verlet", 1e-4).error < 1e-2);
  CHECK(verdict("velocity_verlet", 4.5).verdict == Verdict::diverged);
  CHECK(verdict("explicit_euler", 1e-3).verdict == Verdict::growing);
  CHECK(verdict("implicit_euler", 1e-3).verdict == Verdict::damped);
  CHECK(verdict("implicit_midpoint", 10).verdict == Verdict::inaccurate);
  CHECK(verdict("exponential", 10).verdict == Verdict::stable);
  CHECK_THROWS_AS(verdict("no_such_method", 1), SceneError);
  p.problem = "no_such_problem";
  CHECK_THROWS_AS(verdict("rk4", 1), SceneError);
}
