#include "study/ode.h"

#include "base/rng.h"
#include "feder/memory.h"
#include "integrate/integrator.h"

namespace feder {
namespace {

// The symmetric, negative semidefinite part of m: what the integrators are promised.
Mat3 negative_part(const Mat3& m) {
  const Mat3 symmetric = Real(0.5) * (m + m.transpose());
  Vec3 values;
  Mat3 vectors;
  eigen_symmetric(symmetric, values, vectors);
  Mat3 out = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (values[k] < 0) {
      const Vec3 n = vectors.col(k);
      out += n * (values[k] * n.transpose());
    }
  return out;
}

class OdeRun final : public StudyRun {
 public:
  OdeRun(const PointEquation& e, const Vec3& x, const Vec3& v, double t_end, const RunSpec& spec)
      : equation_(e), field_(e), arena_("study"), method_(make_integrator(arena_, spec)), x_(x), v_(v),
        h_(t_end / spec.steps), adaptive_(method_->info().adaptive) {
    if (!spec.twin) return;
    Rng rng(1);
    x_ = nearby(x, rng), v_ = nearby(v, rng);
  }

  void step() override {
    method_->step(field_, time(), static_cast<Real>(h_), {&x_, 1}, {&v_, 1});
    ++steps_;
  }
  void observe(Observation& out) override { equation_.observe(x_, v_, time(), out); }
  Invariants invariants() override { return equation_.invariants(x_, v_); }
  StudyCounters counters() const override { return counters_of(method_->stats, adaptive_, steps_); }
  std::size_t bytes() const override { return arena_.bytes(); }

 private:
  double time() const { return static_cast<double>(steps_) * h_; }

  const PointEquation& equation_;
  PointField field_;
  Arena arena_;
  std::unique_ptr<Integrator> method_;
  Vec3 x_, v_;
  double h_;
  bool adaptive_;
  std::int64_t steps_ = 0;
};

}  // namespace

void PointEquation::observe(const Vec3& x, const Vec3& v, double, Observation& out) const {
  out.x.assign(x.data(), x.data() + 3);
  out.v.assign(v.data(), v.data() + 3);
  out.q.clear();
}

bool PointField::stiff_damping(Real h) const {
  const double hw = static_cast<double>(h) * equation_.rate;
  return hw * hw + 2 * static_cast<double>(h) * equation_.decay > 4;
}

void PointField::damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) {
  d.set_zero();
  d.diagonal[0] = negative_part(equation_.damping(x[0], v[0], t)).cast<double>();
}

void PointField::jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) {
  damping(x, v, t, d);
  k.set_zero();
  k.diagonal[0] = negative_part(equation_.stiffness(x[0], v[0], t)).cast<double>();
}

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

std::vector<MethodInfo> integrator_methods() {
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

std::vector<MethodInfo> OdeProblem::methods() const { return integrator_methods(); }

std::vector<RunSpec> OdeProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs;
  if (method.adaptive) {
    const double finest = sizeof(Real) == 4 ? 1e-6 : 1e-12;
    for (double tolerance = 1e-2; tolerance > 0.5 * finest; tolerance /= 10)
      rungs.push_back({method.name, tolerance_steps_, tolerance, 0, 0, {}});
    return rungs;
  }
  for (const int steps : steps_) rungs.push_back({method.name, steps, 0, 0, 0, {}});
  return rungs;
}

std::unique_ptr<StudyRun> OdeProblem::start(const RunSpec& spec) const {
  return std::make_unique<OdeRun>(*equation_, x0_, v0_, info_.t_end, spec);
}

}  // namespace feder
