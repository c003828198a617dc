// Implicit Euler: M (v1 - v0) = h f(x0 + h v1, v1), x1 = x0 + h v1. Unconditionally stable, order 1, damps.
// The first solve is that of Baraff & Witkin 1998, linearised where the step starts: A dv = h f + h^2 K v0 with
// A = M - h D - h^2 K (linearised at x0 + h v0 instead, stiff springs would look compressed there and buckle). Newton
// steps from the state it reaches follow until the residual is gone, because a stiff chain that swings far in one step
// overshoots along its tangents; `iterations = 1` leaves them out. All solves are block-Jacobi conjugate gradient.
// The force field hands over negative semidefinite K and D (a compressed spring's negative part is dropped, Choi & Ko
// 2002), so A stays positive definite; then a full step may overshoot, and it is halved until the residual along it
// shrinks.
// Kept between calls: work arrays. Weak spot: numerical damping, 28 % of a 1 Hz swing per period at 60 steps/s.
#include <cmath>

#include "integrate/integrator.h"
#include "linear/cg.h"

namespace feder {
namespace {

constexpr bool kFloat = sizeof(Real) == 4;
constexpr double kNewtonTolerance = kFloat ? 1e-4 : 1e-9;  // residual against the step's first one
constexpr double kLinearTolerance = kFloat ? 1e-5 : 1e-10;
constexpr int kMaxHalvings = 4;

class ImplicitEuler final : public Integrator {
 public:
  ImplicitEuler(Arena& a, const Params& p)
      : Integrator(a), newton_cap_(p.integer("iterations", 8, 1, 100)), cg_cap_(p.integer("cg_iterations", 0, 0, 100000)),
        force_(&a), x_new_(&a), v_start_(&a), v_base_(&a), residual_(&a), dv_(&a), a_(a), d_(a), cg_(a) {}

  IntegratorInfo info() const override { return {1, static_cast<double>(kInfinity), 2, true, false}; }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    prepare(field, x.size());
    v_start_.assign(v.begin(), v.end());
    const double t_new = t + static_cast<double>(h);
    evaluate(field, t_new, h, 0, x, v);
    double first = 0;
    bool converged = false;
    for (int k = 0; k < newton_cap_ && !converged; ++k) {
      const bool solved = solve_direction(field, t_new, h, k == 0, v);
      if (k == 0) first = squared_residual(field);
      if (newton_cap_ == 1) {
        for (std::size_t i = 0; i < v.size(); ++i) v[i] += dv_[i];
        converged = solved;
        break;
      }
      const double now = search(field, t_new, h, x, v);
      converged = solved && (now <= kNewtonTolerance * kNewtonTolerance * first || direction_is_rounding(x, h));
    }
    if (!converged) ++stats.unconverged;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += h * v[i];  // pinned points have v = 0 and dv = 0
  }

 private:
  void prepare(ForceField& field, std::size_t n) {
    force_.resize(n), x_new_.resize(n), residual_.resize(n), dv_.resize(n);
    if (pattern_version_ == field.pattern_version() && a_.diagonal.size() == n) return;
    pattern_.clear();
    field.pattern(pattern_);
    a_.set_pattern(n, pattern_);
    d_.set_pattern(n, pattern_);
    pattern_version_ = field.pattern_version();
  }

  // r = h f(x + reach v, v) - M (v - v0) of the free points.
  void evaluate(ForceField& field, double t, Real h, Real reach, std::span<const Vec3> x, std::span<const Vec3> v) {
    const std::span<const Real> mass = field.mass(), inv_mass = field.inv_mass();
    for (std::size_t i = 0; i < v.size(); ++i) x_new_[i] = x[i] + reach * v[i];
    field.eval(x_new_, v, t, force_);
    ++stats.force_evals;
    for (std::size_t i = 0; i < v.size(); ++i)
      residual_[i] = inv_mass[i] == 0 ? Vec3(0, 0, 0) : Vec3(h * force_[i] - mass[i] * (v[i] - v_start_[i]));
  }

  // r . M^-1 r
  double squared_residual(const ForceField& field) const {
    const std::span<const Real> inv_mass = field.inv_mass();
    double sum = 0;
    for (std::size_t i = 0; i < residual_.size(); ++i)
      sum += static_cast<double>(dot(residual_[i], residual_[i])) * static_cast<double>(inv_mass[i]);
    return sum;
  }

  // dv = A^-1 r at the state of the last evaluate(). The first time that was at x0: h^2 K v0 leads r on to x0 + h v0.
  bool solve_direction(ForceField& field, double t, Real h, bool at_start, std::span<const Vec3> v) {
    field.jacobian(x_new_, v, t, a_, d_);
    ++stats.jacobian_evals;
    const std::span<const Real> mass = field.mass(), inv_mass = field.inv_mass();
    const Real hh = h * h;
    if (at_start) {
      a_.multiply(v, dv_);
      for (std::size_t i = 0; i < v.size(); ++i)
        if (inv_mass[i] != 0) residual_[i] += hh * dv_[i];
    }
    for (std::size_t k = 0; k < a_.off.size(); ++k) a_.off[k] = -hh * a_.off[k] - h * d_.off[k];
    for (std::size_t i = 0; i < a_.diagonal.size(); ++i) {
      Mat3& m = a_.diagonal[i];
      m = -hh * m - h * d_.diagonal[i];
      // rounding of very stiff blocks must not make A indefinite: a hint of mass, which only slows Newton down
      const Real hint = mass[i] + Real(2) * kEpsilon * m.trace();
      m.diagonal().array() += hint;
    }
    const int cap = cg_cap_ > 0 ? cg_cap_ : 3 * static_cast<int>(v.size()) + 50;
    const CgResult r = cg_.solve(a_, inv_mass, residual_, {kLinearTolerance, cap}, dv_);
    ++stats.linear_solves;
    stats.cg_iterations += static_cast<std::uint64_t>(r.iterations);
    stats.residual = r.residual;
    return r.converged;
  }

  double slope_along_direction() const {
    double sum = 0;
    for (std::size_t i = 0; i < dv_.size(); ++i) sum += static_cast<double>(dot(residual_[i], dv_[i]));
    return sum;
  }

  // v += s dv with s = 1, 1/2 ... until the residual along dv has shrunk. Returns the residual there.
  double search(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<Vec3> v) {
    const double start = slope_along_direction();
    v_base_.assign(v.begin(), v.end());
    Real s = 1;
    for (int k = 0; k <= kMaxHalvings; ++k, s /= 2) {
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = v_base_[i] + s * dv_[i];
      evaluate(field, t, h, h, x, v);
      if (std::fabs(slope_along_direction()) <= 0.9 * start) break;
    }
    return squared_residual(field);
  }

  // Is the last update below what the positions can resolve?
  bool direction_is_rounding(std::span<const Vec3> x, Real h) const {
    Real update = 0, size = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        update = std::max(update, std::fabs(dv_[i][k]));
        size = std::max(size, std::fabs(x[i][k]));
      }
    return h * update <= Real(4) * kEpsilon * size;
  }

  int newton_cap_, cg_cap_;
  Array<Vec3> force_, x_new_, v_start_, v_base_, residual_, dv_;
  BlockSparse a_, d_;
  ConjugateGradient cg_;
  std::vector<BlockIndex> pattern_;
  std::uint64_t pattern_version_ = ~std::uint64_t{0};
};

}  // namespace

Variant<Integrator> integrate_implicit_euler() {
  return {"implicit_euler", "order 1, stable at any step and stiffness; damps; Newton and conjugate gradient",
          [](Arena& a, const Params& p) -> std::unique_ptr<Integrator> {
            return std::make_unique<ImplicitEuler>(a, p);
          }};
}

}  // namespace feder
