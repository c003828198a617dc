// Methods and ladders of problems that integrators run: tolerances for adaptive methods, steps for all others.
#include "study/integrator_problem.h"

#include "feder/memory.h"

namespace feder {

Vec3 nearby(const Vec3& x, Rng& rng) {
  Vec3 out = x;
  for (int k = 0; k < 3; ++k)
    out[k] += x[k] * kEpsilon * static_cast<Real>(rng.uniform(1, 2) * (rng.unit() < 0.5 ? -1 : 1));
  return out;
}

std::vector<int> doubling(int first, int rungs) {
  std::vector<int> steps;
  for (int r = 0; r < rungs; ++r) steps.push_back(first << r);
  return steps;
}

std::vector<MethodInfo> IntegratorProblem::methods() const {
  std::vector<MethodInfo> all;
  Arena arena("study");
  for (const Variant<Integrator>& row : integrators()) {
    const IntegratorInfo i = row.make(arena, Params())->info();
    all.push_back({row.name, row.summary, i.order, i.evals_per_step, i.stability_limit, i.implicit, i.adaptive});
  }
  return all;
}

std::unique_ptr<Integrator> make_integrator(Arena& arena, const RunSpec& spec) {
  Params options;
  if (spec.tolerance > 0) options.set("tolerance", spec.tolerance);
  if (spec.iterations > 0) options.set("iterations", static_cast<double>(spec.iterations));
  auto method = find_variant(integrators(), spec.method, "integrator").make(arena, options);
  options.check_all_read(spec.method);
  return method;
}

StudyCounters counters_of(const IntegratorStats& s, bool adaptive, std::int64_t steps) {
  const auto n = [](std::uint64_t x) { return static_cast<std::int64_t>(x); };
  StudyCounters c;
  c.steps = adaptive ? n(s.substeps) : steps;
  c.rejected = n(s.rejected);
  c.force_evals = n(s.force_evals), c.jac_evals = n(s.jacobian_evals);
  c.linear_solves = n(s.linear_solves), c.cg_iters = n(s.cg_iterations);
  c.unconverged = n(s.unconverged);
  return c;
}

std::vector<RunSpec> IntegratorProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs;
  if (method.adaptive) {
    for (double tolerance = 1e-2; tolerance > 0.5 * finest_tolerance_; tolerance /= 10)
      rungs.push_back({method.name, tolerance_steps_, tolerance, 0, 0, {}});
    return rungs;
  }
  for (const int steps : method.implicit && !implicit_steps_.empty() ? implicit_steps_ : steps_)
    rungs.push_back({method.name, steps, 0, 0, 0, {}});
  return rungs;
}

}  // namespace feder
