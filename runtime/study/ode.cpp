// Runs of one point by an integrator, and its field: forces as the problem says, derivatives made negative
// semidefinite.
#include "study/ode.h"

#include "feder/memory.h"

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

void OdeProblem::use_extrapolation(OdeReference::Rhs rhs, std::vector<Wide> start) {
  extrapolated_ = std::make_unique<OdeReference>(std::move(rhs), std::move(start), info_.t_end, kStudySamples);
}

void OdeProblem::reference(double t, Observation& out) const {
  const std::vector<Wide>& y = extrapolated_->at(t);
  const std::size_t count = y.size() / 2;
  out = {std::vector<double>(3), std::vector<double>(3), {}};
  for (std::size_t k = 0; k < count; ++k)
    out.x[k] = static_cast<double>(y[k]), out.v[k] = static_cast<double>(y[count + k]);
}

std::unique_ptr<StudyRun> OdeProblem::start(const RunSpec& spec) const {
  return std::make_unique<OdeRun>(*equation_, x0_, v0_, info_.t_end, spec);
}

}  // namespace feder
