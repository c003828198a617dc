// The contract of feder/study.h for every registered problem. A new one is enrolled by its line alone.
#include <algorithm>

#include "feder/study.h"
#include "study/run.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::unique_ptr<StudyProblem> any_problem() {
  const int row = GENERATE(range(0, static_cast<int>(study_problems().size())));
  return make_study_problem(study_problems()[static_cast<std::size_t>(row)].name, Params());
}

// Its reference alone takes seconds.
bool too_long(const StudyProblem& p) { return p.info().frequency * p.info().t_end > 2e6; }

StudyPoint run(const StudyProblem& p, const MethodInfo& m, const RunSpec& spec, StudySeries* series = nullptr) {
  StudyPoint point;
  RunLimits limits;
  // an evaluation is cheap for the few, and wide, of a fluid
  limits.budget_work = p.info().own_measure ? 1e7 : 1.5e6;
  run_point(p, m, spec, limits, WorkWeights(), point, series);
  return point;
}

}  // namespace

TEST_CASE("each method starts where the reference does", "[study][contract]") {
  const auto p = any_problem();
  const ProblemInfo& info = p->info();
  CAPTURE(info.name);
  CHECK(info.t_end > 0);
  CHECK(info.dof > 0);
  CHECK(info.x_scale > 0);
  CHECK(info.v_scale > 0);
  CHECK(info.reference.floor() > 0);
  CHECK_FALSE(info.reference.source.empty());
  CHECK_FALSE(info.family.empty());
  Observation exact, now;
  p->reference(0, exact);
  REQUIRE(!p->methods().empty());
  for (const MethodInfo& m : p->methods()) {
    CAPTURE(m.name);
    const std::vector<RunSpec> ladder = p->ladder(m);
    REQUIRE(!ladder.empty());
    const auto started = p->start(ladder.front());
    started->observe(now);
    REQUIRE(now.x.size() == exact.x.size());
    REQUIRE(now.v.size() == exact.v.size());
    const double rounding = 4 * static_cast<double>(kEpsilon);
    for (std::size_t i = 0; i < now.x.size(); ++i)
      CHECK(now.x[i] == Approx(exact.x[i]).margin(rounding * (1 + std::fabs(exact.x[i]))));
    for (std::size_t i = 0; i < now.v.size(); ++i)
      CHECK(now.v[i] == Approx(exact.v[i]).margin(rounding * info.v_scale));
    const double energy = started->invariants().energy;
    if (std::isfinite(energy))
      CHECK(energy == Approx(p->reference_energy(0)).margin(1e3 * rounding * info.energy_scale));
  }
}

TEST_CASE("equal specs give equal errors and counts", "[study][contract]") {
  const auto p = any_problem();
  CAPTURE(p->info().name);
  if (too_long(*p)) return;
  const MethodInfo m = p->methods().back();
  const RunSpec spec = p->ladder(m).front();
  StudySeries a_series, b_series;
  const StudyPoint a = run(*p, m, spec, &a_series), b = run(*p, m, spec, &b_series);
  CHECK(a.status == b.status);
  CHECK((a.err_end == b.err_end || std::isnan(a.err_end)));
  CHECK((a.err_traj_rms == b.err_traj_rms || std::isnan(a.err_traj_rms)));
  CHECK((a.err_energy_max == b.err_energy_max || std::isnan(a.err_energy_max)));
  CHECK(a.count.force_evals == b.count.force_evals);
  CHECK(a.completed == std::isfinite(a.err_end));
  CHECK(a_series.t.size() == b_series.t.size());
  CHECK(a_series.err == b_series.err);
  if (a.completed) {
    CHECK(a_series.t.size() == static_cast<std::size_t>(kStudySamples));
    CHECK(a_series.energy.size() == a_series.t.size());
  }
}

TEST_CASE("some method comes close to the reference, and closer with work", "[study][contract]") {
  const auto p = any_problem();
  CAPTURE(p->info().name);
  if (too_long(*p)) return;
  double coarse = 1e300, fine = 1e300, rounded = 0;
  for (const MethodInfo& m : p->methods()) {
    std::vector<RunSpec> ladder = p->ladder(m);
    // of several axes of refinement the first
    std::erase_if(ladder,
                  [axis = ladder.front().refinement_axis](const RunSpec& r) { return r.refinement_axis != axis; });
    // one rung of each half: the finest take long. What the budget cuts off in the second half cannot count in the
    // first
    const auto error_of = [&](std::size_t rung) {
      const StudyPoint point = run(*p, m, ladder[rung]);
      return point.status == PointStatus::ok ? point.err_end : 1e300;
    };
    const RunSpec& last = ladder[ladder.size() * 4 / 5];
    const double late = error_of(ladder.size() * 4 / 5);
    if (late < 1e300) coarse = std::min(coarse, error_of(ladder.size() / 3));
    fine = std::min(fine, late);
    // each step rounds the state, and in the worst case always to the same side
    rounded = std::max(rounded, static_cast<double>(kEpsilon) * last.steps * std::max(1, last.substeps));
  }
  CAPTURE(coarse, fine);
  const ReferenceInfo& reference = p->info().reference;
  CHECK(fine < std::max({0.02, reference.floor(), reference.resolution}));
  CHECK(fine <= std::max({coarse, reference.floor(), reference.resolution, rounded}));
}

TEST_CASE("parameters are listed with their range and refuse what is outside", "[study][contract]") {
  const auto p = any_problem();
  CAPTURE(p->info().name);
  for (const ProblemParam& param : p->info().params) {
    CAPTURE(param.name);
    CHECK(param.value == param.fallback);
    CHECK_FALSE(param.help.empty());
    Params bad;
    if (std::isfinite(param.hi))
      bad.set(param.name, param.hi * 2 + 1);
    else
      bad.set(param.name, std::string("no such choice"));
    CHECK_THROWS_AS(make_study_problem(p->info().name, bad), SceneError);
  }
}
