// Explicit Runge-Kutta stages for (x, v), shared by the methods that differ in their coefficients only.
#pragma once
#include "integrate/integrator.h"

namespace feder {

// Butcher tableau c | A / b. Row s of A (stages x stages, row-major) weighs the slopes of the stages before s.
struct Tableau {
  int stages;
  const double* nodes;     // c: stage s is evaluated at t + nodes[s] h
  const double* coupling;  // A
  const double* weights;   // b
};

class RungeKutta {
 public:
  static constexpr int kMaxStages = 8;
  RungeKutta(Arena& a, const Tableau& t)
      : tableau_(t), force_(&a), x_(&a), low_(&a), v_(&a), slope_x_(&a), slope_v_(&a) {}

  // The slopes of stages first .. last-1 from (x + low, v); those before `first` are there already. The state at which
  // the last one was evaluated stays readable below. Pinned points have no slope.
  void evaluate(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<const Vec3> low,
                std::span<const Vec3> v, int first, int last, IntegratorStats& stats);
  // x + low += h sum w_s slope_s, v likewise.
  void advance(Real h, const double* weights, std::span<Vec3> x, std::span<Vec3> low, std::span<Vec3> v) const;
  // One step with the tableau's weights.
  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> low, std::span<Vec3> v,
            IntegratorStats& stats) {
    evaluate(field, t, h, x, low, v, 0, tableau_.stages, stats);
    advance(h, tableau_.weights, x, low, v);
  }

  std::span<const Vec3> last_x() const { return x_; }
  std::span<const Vec3> last_low() const { return low_; }
  std::span<const Vec3> last_v() const { return v_; }
  std::span<Vec3> slope_x(int s) { return {slope_x_.data() + static_cast<std::size_t>(s) * x_.size(), x_.size()}; }
  std::span<Vec3> slope_v(int s) { return {slope_v_.data() + static_cast<std::size_t>(s) * x_.size(), x_.size()}; }

 private:
  void add(Real h, const double* weights, int stages, std::span<Vec3> x, std::span<Vec3> low, std::span<Vec3> v) const;

  Tableau tableau_;
  Array<Vec3> force_, x_, low_, v_;
  Array<Vec3> slope_x_, slope_v_;  // by stage, then point
};

// An explicit method that is nothing but its tableau.
class TableauMethod final : public Integrator {
 public:
  TableauMethod(Arena& a, const Tableau& t, const IntegratorInfo& info) : Integrator(a), stages_(a, t), info_(info) {}

  IntegratorInfo info() const override { return info_; }
  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    stages_.step(field, t, h, x, low_of(field), v, stats);
  }

 private:
  RungeKutta stages_;
  IntegratorInfo info_;
};

// The row of a method of two stages and order 2: its tableau is 0 | , c | c / 1 - b, b with b c = 1/2.
template <const double (&kNodes)[2], const double (&kWeights)[2]>
Variant<Integrator> two_stage_variant(const char* name, const char* summary) {
  return {name, summary, [](Arena& a, const Params&) -> std::unique_ptr<Integrator> {
            static constexpr double kCoupling[] = {0, 0, kNodes[1], 0}, kPolynomial[] = {1, 1, 0.5};
            return std::make_unique<TableauMethod>(
                a, Tableau{2, kNodes, kCoupling, kWeights},
                IntegratorInfo{.order = 2, .evals_per_step = 2, .stability_polynomial = kPolynomial});
          }};
}

}  // namespace feder
