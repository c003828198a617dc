// The table of problems, verdicts of traces, and maps.
#include <algorithm>

#include "feder/study.h"
#include "study/stability_problem.h"

namespace feder {

#include "study_stability_declare.inc"

namespace {

double largest(const std::vector<double>& e, std::size_t first, std::size_t last) {
  return *std::max_element(e.begin() + static_cast<std::ptrdiff_t>(first),
                           e.begin() + static_cast<std::ptrdiff_t>(last));
}

}  // namespace

Verdict verdict_of(const StabilityTrace& j, double length, double energy, const StabilityThresholds& limits,
                   const StabilityCell& c) {
  const std::size_t n = j.energy.size();
  if (n >= 8) {
    const double second = largest(j.energy, n / 4, n / 2), last = largest(j.energy, 3 * n / 4, n);
    if (last > limits.growth * second && last > limits.growth_start * j.energy.front()) return Verdict::growing;
  }
  if (j.reference_displacement > limits.moves * length && j.displacement < limits.stuck * j.reference_displacement)
    return Verdict::stuck;
  // quarters, because the energy of symplectic methods swings
  for (std::size_t q = 0; q < 4 && n >= 8 && j.exact_energy.size() == n; ++q) {
    const std::size_t first = q * n / 4, last = (q + 1) * n / 4;
    if (largest(j.exact_energy, first, last) - largest(j.energy, first, last) > limits.damped * energy)
      return Verdict::damped;
  }
  if (c.error > limits.inaccurate || c.constraint > limits.constraint) return Verdict::inaccurate;
  return c.missed > limits.slow ? Verdict::slow : Verdict::stable;
}

StabilityCell run_cell(const StabilityRun& run, double x, double y, const StabilityThresholds& limits) {
  StabilityCell cell;
  cell.x = x, cell.y = y;
  World& w = run.world;
  WarningRecord warned;
  const double start = total_energy(w);
  const int steps = static_cast<int>(std::lround(run.seconds / w.desc().dt));
  double most = 0, late = 0, second = 0;
  for (int k = 0; k < steps; ++k) {
    w.step();
    run.record();
    warned.read(w);
    cell.entity = warned.last;
    const double gained = total_energy(w) - start;
    most = std::max(most, gained);
    if (4 * k >= 3 * steps)
      late = std::max(late, gained);
    else if (4 * k >= steps && 2 * k < steps)
      second = std::max(second, gained);
    const bool finite = w.is_finite();
    if (finite && std::isfinite(gained) && gained < limits.energy * run.energy && !run.left()) continue;
    cell.verdict = finite || run.overflows ? Verdict::diverged : Verdict::nan;
    cell.t_fail = w.time();
    break;
  }
  cell.energy_ratio = most / run.energy;
  if (cell.verdict != Verdict::stable) return cell;
  cell.error = run.error();
  if (late > limits.growth * second && late > (limits.growth_start - 1) * run.energy)
    cell.verdict = Verdict::growing;
  else if (cell.error > limits.inaccurate)
    cell.verdict = Verdict::inaccurate;
  return cell;
}

namespace {

StabilityProblems all_problems() {
  StabilityProblems all;
  for (StabilityProblems (*const make)() : {
#include "study_stability_rows.inc"
       })
    for (auto& problem : make()) all.push_back(std::move(problem));
  return all;
}

class StabilityTable final : public StabilityProblem {
 public:
  StabilityTable(StabilityProblemInfo info, std::vector<StabilityMethod> methods, StabilityCells cells)
      : info_(std::move(info)), methods_(std::move(methods)), cells_(std::move(cells)) {}
  StabilityProblemInfo info() const override { return info_; }
  std::vector<StabilityMethod> methods() const override { return methods_; }
  StabilityCell cell(const std::string& method, double x, double y, const StabilityThresholds& limits) const override {
    return cells_(method, x, y, limits);
  }

 private:
  StabilityProblemInfo info_;
  std::vector<StabilityMethod> methods_;
  StabilityCells cells_;
};

std::unique_ptr<StabilityProblem> find_problem(const std::string& name) {
  const std::vector<StabilityProblemInfo> infos = stability_problem_infos();
  const auto& row = find_variant(std::span<const StabilityProblemInfo>(infos), name, "stability problem");
  return std::move(all_problems()[static_cast<std::size_t>(&row - infos.data())]);
}

StabilityMethod find_method(const StabilityProblem& problem, const std::string& name) {
  const std::vector<StabilityMethod> methods = problem.methods();
  for (const StabilityMethod& m : methods)
    if (m.name == name) return m;
  throw SceneError("unknown method '" + name + "' of " + problem.info().name +
                   "; known: " + variant_names(std::span<const StabilityMethod>(methods)));
}

StabilityMap run_map(const StabilityProblem& problem, const StabilityMethod& method, const StabilityPlan& plan) {
  const StabilityProblemInfo info = problem.info();
  StabilityMap m;
  m.problem = info.name, m.method = method.name, m.x = info.x, m.y = info.y;
  m.order = method.order, m.implicit = method.implicit;
  if (!plan.x_values.empty()) m.x.values = plan.x_values;
  if (!plan.y_values.empty()) m.y.values = plan.y_values;
  if (plan.cells) {
    std::size_t stable = 0;
    for (const double y : m.y.values)
      for (const double x : m.x.values) {
        if (plan.stopped()) break;
        m.cells.push_back(problem.cell(method.name, x, y, plan.thresholds));
        stable += m.cells.back().verdict == Verdict::stable;
      }
    m.stable_share = static_cast<double>(stable) / static_cast<double>(std::max<std::size_t>(1, m.cells.size()));
  }
  if (plan.bisect && info.bisects) {
    for (const double y : m.y.values)
      if (!plan.stopped()) m.limits.push_back(problem.limit(method.name, y));
    m.limit_how = problem.limit_how();
  }
  return m;
}

}  // namespace

std::unique_ptr<StabilityProblem> stability_table(const char* family, StabilityProblemInfo info,
                                                  std::vector<StabilityMethod> methods, StabilityCells cells) {
  info.family = family;
  return std::make_unique<StabilityTable>(std::move(info), std::move(methods), std::move(cells));
}

std::string failed_entity(World& w, std::string object) {
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning && w.events().warning_code(e) == "non_finite")
      return w.events().warning_message(e);
  return object;
}

std::vector<double> decades(double lo, double hi, int per_decade) {
  std::vector<double> out;
  const int count = static_cast<int>(std::lround((hi - lo) * per_decade));
  for (int k = 0; k <= count; ++k) out.push_back(std::pow(10.0, lo + static_cast<double>(k) / per_decade));
  return out;
}

const char* name_of(Verdict v) {
  static const char* const names[] = {"nan",        "diverged", "growing", "stuck", "damped",
                                      "inaccurate", "slow",     "refused", "stable"};
  return names[static_cast<std::size_t>(v)];
}

StabilityResult run_stability(const StabilityPlan& plan) {
  const auto problem = find_problem(plan.problem);
  std::vector<StabilityMethod> methods;
  for (const std::string& name : plan.methods) methods.push_back(find_method(*problem, name));
  if (methods.empty()) methods = problem->methods();
  StabilityResult result;
  result.thresholds = plan.thresholds;
  result.real = kRealName;
  for (const StabilityMethod& m : methods) {
    StabilityMap map = run_map(*problem, m, plan);
    result.interrupted = plan.stopped();
    if (!result.interrupted || !map.cells.empty()) result.maps.push_back(std::move(map));
    if (result.interrupted) break;
  }
  return result;
}

std::vector<StabilityProblemInfo> stability_problem_infos() {
  std::vector<StabilityProblemInfo> out;
  for (const auto& problem : all_problems()) out.push_back(problem->info());
  return out;
}

}  // namespace feder
