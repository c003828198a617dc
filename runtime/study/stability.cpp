// The table of problems, verdicts of traces, and maps.
#include "study/stability.h"

#include <algorithm>

#include "base/registry.h"
#include "study/stability_problem.h"

namespace feder {
namespace {

double largest(const std::vector<double>& e, std::size_t first, std::size_t last) {
  return *std::max_element(e.begin() + static_cast<std::ptrdiff_t>(first),
                           e.begin() + static_cast<std::ptrdiff_t>(last));
}

}  // namespace

Verdict judge(const StabilityTrace& j, double length, double energy, const StabilityThresholds& limits,
              const StabilityCell& c) {
  const std::size_t n = j.energy.size();
  if (n >= 8) {
    const double second = largest(j.energy, n / 4, n / 2), last = largest(j.energy, 3 * n / 4, n);
    if (last > limits.growth * second && last > limits.growth_start * j.energy.front()) return Verdict::growing;
  }
  if (j.reference_moved > limits.moves * length && j.moved < limits.stuck * j.reference_moved) return Verdict::stuck;
  // quarters, because the energy of symplectic methods swings
  for (std::size_t q = 0; q < 4 && n >= 8 && j.exact_energy.size() == n; ++q) {
    const std::size_t first = q * n / 4, last = (q + 1) * n / 4;
    if (largest(j.exact_energy, first, last) - largest(j.energy, first, last) > limits.damped * energy)
      return Verdict::damped;
  }
  if (c.error > limits.inaccurate || c.constraint > limits.constraint) return Verdict::inaccurate;
  return c.missed > limits.slow ? Verdict::slow : Verdict::stable;
}

namespace {

std::unique_ptr<StabilityProblem> make_problem(const std::string& name) {
  for (const auto& rows : {stability_problems(), rigid_stability_problems()})
    for (const StabilityProblemRow& row : rows)
      if (name == row.name) return row.make();
  std::string known;
  for (const StabilityProblemInfo& info : stability_problem_infos()) known += (known.empty() ? "" : ", ") + info.name;
  throw SceneError("unknown stability problem '" + name + "'; known: " + known);
}

StabilityMethod find_method(const StabilityProblem& problem, const std::string& name) {
  std::string known;
  for (const StabilityMethod& m : problem.methods()) {
    if (m.name == name) return m;
    known += (known.empty() ? "" : ", ") + m.name;
  }
  throw SceneError("unknown method '" + name + "' of " + problem.info().name + "; known: " + known);
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
        m.cells.push_back(problem.cell(method.name, x, y, plan.thresholds));
        stable += m.cells.back().verdict == Verdict::stable;
      }
    m.stable_share = static_cast<double>(stable) / static_cast<double>(std::max<std::size_t>(1, m.cells.size()));
  }
  if (plan.bisect && info.bisects) {
    for (const double y : m.y.values) m.limits.push_back(problem.limit(method.name, y));
    m.limit_how = problem.limit_how();
  }
  return m;
}

}  // namespace

const char* name_of(Verdict v) {
  static const char* const names[] = {"nan",        "diverged", "growing", "stuck", "damped",
                                      "inaccurate", "slow",     "refused", "stable"};
  return names[static_cast<std::size_t>(v)];
}

StabilityResult run_stability(const StabilityPlan& plan) {
#ifdef FEDER_HAS_CLOTH
  if (is_cloth_stability(plan.problem)) return run_cloth_stability(plan);
#endif
#ifdef FEDER_HAS_FLUID
  if (is_fluid_stability(plan.problem)) return run_fluid_stability(plan);
#endif
  const auto problem = make_problem(plan.problem);
  std::vector<StabilityMethod> methods;
  for (const std::string& name : plan.methods) methods.push_back(find_method(*problem, name));
  if (methods.empty()) methods = problem->methods();
  StabilityResult result;
  result.thresholds = plan.thresholds;
  result.real = kRealName;
  for (const StabilityMethod& m : methods) result.maps.push_back(run_map(*problem, m, plan));
  return result;
}

std::vector<StabilityProblemInfo> stability_problem_infos() {
  std::vector<StabilityProblemInfo> out;
  for (const auto& rows : {stability_problems(), rigid_stability_problems()})
    for (const StabilityProblemRow& row : rows) out.push_back(row.make()->info());
#ifdef FEDER_HAS_CLOTH
  for (const StabilityProblemInfo& info : cloth_stability_infos()) out.push_back(info);
#endif
#ifdef FEDER_HAS_FLUID
  for (const StabilityProblemInfo& info : fluid_stability_infos()) out.push_back(info);
#endif
  return out;
}

}  // namespace feder
