// The first solve of a stage is that of Baraff & Witkin 1998, linearised where the step starts: A dv = r + g K (x_past
// + g v), A = M - g D - g^2 K (linearised at the end of the step instead, stiff springs would be
// compressed there and buckle). Newton steps from the state it reaches follow until the residual is gone, because a
// stiff chain that swings far in one step overshoots along its tangents; `iterations = 1` leaves them out. The force
// field hands over negative semidefinite K and D (a compressed spring's negative part is dropped, Choi & Ko 2002), so A
// stays positive definite; then a full step may overshoot, and it is halved until the residual along it shrinks. Kept
// between calls: work arrays and the layout of the factor. Weak spot: the semidefinite K makes Newton linear, not
// quadratic, where springs are compressed.
#include "integrate/implicit_solve.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

constexpr bool kFloat = sizeof(Real) == 4;
constexpr double kNewtonTolerance = kFloat ? 1e-4 : 1e-9;  // residual against the step's first one
constexpr double kLinearTolerance = kFloat ? 1e-6 : 1e-11;
constexpr Real kNothing = Real(1e-30);  // m; float loses precision below 1e-38 / kEpsilon
// units of the largest coordinate's last place: an update that need not follow; one that is no miss after the last
// step, since the rounding of stiff springs in a row adds up and updates of 5 to 7 units go on for ever in a chain of
// ten
constexpr Real kStop = 4, kNoMiss = 8;
constexpr int kMaxHalvings = 4;
constexpr std::uint64_t kLdlFloor = 20000;  // block products that are cheap at any size
constexpr std::uint64_t kLdlPerBlock = 60;  // a hard conjugate-gradient solve multiplies each block that often
constexpr std::uint64_t kLdlNoBound = ~std::uint64_t{0};

}  // namespace

ImplicitMatrix::Solver ImplicitMatrix::solver_option(const Params& p) {
  return static_cast<Solver>(p.choice({.name = "solver", .choices = "auto, direct, cg"}));
}

ImplicitMatrix::ImplicitMatrix(Arena& a, const Params& p)
    : solver_(solver_option(p)), cg_cap_(p.integer({"cg_iterations", "", {0, 100000}}, 0)), k_(a), d_(a), a_(a),
      ldl_(a), cg_(a) {}

void ImplicitMatrix::update_pattern(const ForceField& field, std::size_t n) {
  if (!pattern_.update(field, n, {&k_, &d_, &a_})) return;
  const std::span<const BlockIndex> blocks = pattern_.blocks();
  const std::uint64_t budget = std::max(kLdlFloor, kLdlPerBlock * (n + 2 * blocks.size()));
  direct_ = solver_ != Solver::iterative && ldl_.analyze(n, blocks, solver_ == Solver::direct ? kLdlNoBound : budget);
}

void ImplicitMatrix::assemble(ForceField& field, double t, Real g, std::span<const Vec3> x, std::span<const Vec3> v,
                              IntegratorStats& stats) {
  update_pattern(field, x.size());
  field.jacobian(x, v, t, k_, d_);
  ++stats.jacobian_evals;
  const double by_d = -static_cast<double>(g), by_k = -by_d * by_d;
  for (std::size_t k = 0; k < a_.off.size(); ++k) a_.off[k] = by_k * k_.off[k] + by_d * d_.off[k];
  const std::span<const Real> mass = field.mass();
  for (std::size_t i = 0; i < a_.diagonal.size(); ++i) {
    Mat3d& m = a_.diagonal[i];
    m = by_k * k_.diagonal[i] + by_d * d_.diagonal[i];
    // rounding of very stiff blocks must not make A indefinite: a hint of mass, which only slows Newton down
    m.diagonal().array() += static_cast<double>(mass[i]) + 1e-15 * m.trace();
  }
  factored_ = direct_ && ldl_.factor(a_, field.inv_mass());
}

bool ImplicitMatrix::solve(const ForceField& field, std::span<const Vec3> r, std::span<Vec3> d,
                           IntegratorStats& stats) {
  ++stats.linear_solves;
  if (factored_) {
    ldl_.solve(r, field.inv_mass(), d);
    return true;
  }
  const int cap = cg_cap_ > 0 ? cg_cap_ : 3 * static_cast<int>(r.size()) + 50;
  const CgResult result = cg_.solve(a_, field.inv_mass(), r, {kLinearTolerance, cap}, d);
  stats.cg_iterations += static_cast<std::uint64_t>(result.iterations);
  stats.residual = result.residual;
  return result.converged;
}

ImplicitStage::ImplicitStage(Arena& a, const Params& p)
    : newton_cap_(p.integer({"iterations", "", {1, 100}}, 8)), matrix_(a, p), force_(&a), x_new_(&a), v_base_(&a),
      residual_(&a), dv_(&a), v_before_(&a), product_(&a) {}

void ImplicitStage::solve(ForceField& field, const StageProblem& p, std::span<Vec3> v, IntegratorStats& stats) {
  const std::size_t n = v.size();
  force_.resize(n), x_new_.resize(n), v_base_.resize(n), residual_.resize(n), dv_.resize(n), product_.resize(n);
  bool solved = first_direction(field, p, v, stats);
  const double first = squared_residual(field);
  if (newton_cap_ == 1) {
    for (std::size_t i = 0; i < n; ++i) v[i] += dv_[i];
    if (!solved) ++stats.unconverged;
    return;
  }
  for (int k = 1;; ++k) {
    const double now = search(field, p, v, stats);
    stats.residual = first > 0 ? std::sqrt(now / first) : 0;
    if (solved && (now <= kNewtonTolerance * kNewtonTolerance * first || update_is_rounding(p, kStop))) return;
    if (k == newton_cap_) break;
    matrix_.assemble(field, p.t, p.g, x_new_, v, stats);
    solved = matrix_.solve(field, residual_, dv_, stats);
  }
  if (!solved || !update_is_rounding(p, kNoMiss)) ++stats.unconverged;
}

// r = g f(x_new, v) - M (v - v_star) of the free points.
void ImplicitStage::set_residual(ForceField& field, const StageProblem& p, std::span<const Vec3> v) {
  const std::span<const Real> mass = field.mass(), inv_mass = field.inv_mass();
  for (std::size_t i = 0; i < v.size(); ++i)
    residual_[i] = inv_mass[i] == 0 ? Vec3(0, 0, 0) : Vec3(p.g * force_[i] - mass[i] * (v[i] - p.v_star[i]));
}

void ImplicitStage::evaluate(ForceField& field, const StageProblem& p, std::span<const Vec3> v,
                             IntegratorStats& stats) {
  const std::span<const Real> inv_mass = field.inv_mass();
  for (std::size_t i = 0; i < v.size(); ++i)
    x_new_[i] = inv_mass[i] == 0 ? p.x[i] : Vec3(p.x[i] + (p.x_past[i] + p.g * v[i]));
  field.eval(x_new_, v, p.t, force_);
  ++stats.force_evals;
  set_residual(field, p, v);
}

bool ImplicitStage::first_direction(ForceField& field, const StageProblem& p, std::span<const Vec3> v,
                                    IntegratorStats& stats) {
  field.eval(p.x, v, p.t, force_);
  ++stats.force_evals;
  set_residual(field, p, v);
  matrix_.assemble(field, p.t, p.g, p.x, v, stats);
  const std::span<const Real> inv_mass = field.inv_mass();
  for (std::size_t i = 0; i < v.size(); ++i)
    x_new_[i] = inv_mass[i] == 0 ? Vec3(0, 0, 0) : Vec3(p.x_past[i] + p.g * v[i]);
  matrix_.multiply_stiffness(x_new_, product_);
  for (std::size_t i = 0; i < v.size(); ++i)
    if (inv_mass[i] != 0) residual_[i] += p.g * product_[i].cast<Real>();
  return matrix_.solve(field, residual_, dv_, stats);
}

// r . M^-1 r
double ImplicitStage::squared_residual(const ForceField& field) const {
  const std::span<const Real> inv_mass = field.inv_mass();
  double sum = 0;
  for (std::size_t i = 0; i < residual_.size(); ++i)
    sum += residual_[i].cast<double>().squaredNorm() * static_cast<double>(inv_mass[i]);
  return sum;
}

double ImplicitStage::slope_along_direction() const {
  double sum = 0;
  for (std::size_t i = 0; i < dv_.size(); ++i) sum += residual_[i].cast<double>().dot(dv_[i].cast<double>());
  return sum;
}

// v += s dv with s = 1, 1/2 ... until the residual along dv has shrunk. Returns the squared residual there.
double ImplicitStage::search(ForceField& field, const StageProblem& p, std::span<Vec3> v, IntegratorStats& stats) {
  const double start = slope_along_direction();
  v_base_.assign(v.begin(), v.end());
  Real s = 1;
  for (int k = 0; k <= kMaxHalvings; ++k, s /= 2) {
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = v_base_[i] + s * dv_[i];
    evaluate(field, p, v, stats);
    if (std::fabs(slope_along_direction()) <= 0.9 * start) break;
  }
  return squared_residual(field);
}

// Is the last update below what the positions can resolve, or so small that float has no digits left?
bool ImplicitStage::update_is_rounding(const StageProblem& p, Real units) const {
  Real update = 0, size = 0;
  for (std::size_t i = 0; i < dv_.size(); ++i) {
    update = std::max(update, dv_[i].cwiseAbs().maxCoeff());
    size = std::max(size, p.x[i].cwiseAbs().maxCoeff());
  }
  return p.g * update <= std::max(units * kEpsilon * size, kNothing);
}

}  // namespace feder
