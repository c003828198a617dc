// ROS2 (Verwer et al. 1999), a Rosenbrock method of two stages with gamma = 1 - 1/sqrt 2, linearly implicit: each stage
// is one linear solve and nothing is iterated, so the cost of a step is known. For y = (x, v):
//   (1 - gamma h J) k1 = F(y0),  (1 - gamma h J) k2 = F(y0 + h k1, t + h) - 2 k1,  y1 = y0 + h (3/2 k1 + 1/2 k2).
// Order 2 with any J, so the semidefinite K of the force field will do; L-stable with the true one. The x rows are
// eliminated: (M - g D - g^2 K) kv = r + g K kx's right side, g = gamma h, and both stages share the factor.
// Kept between calls: work arrays. Weak spot: the second stage evaluates forces at an Euler step; where a stiff chain
// swings far in one step those are huge and it gains energy, as every method that stops after one linear solve.
#include "integrate/implicit_solve.h"

namespace feder {
namespace {

constexpr double kGamma = 1 - 0.70710678118654752440;

class Ros2 final : public Integrator {
 public:
  Ros2(Arena& a, const Params& p)
      : Integrator(a), force_(&a), x_(&a), v_(&a), kx1_(&a), kv1_(&a), kv2_(&a), right_x_(&a), right_v_(&a),
        product_(&a), matrix_(a, p) {}

  IntegratorInfo info() const override {
    IntegratorInfo i = unlimited_info(2, 2);
    i.l_stable = true;
    return i;
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::size_t n = x.size();
    const std::span<const Real> mass = field.mass(), inv_mass = field.inv_mass();
    for (auto* a : {&force_, &x_, &v_, &kx1_, &kv1_, &kv2_, &right_x_, &right_v_}) a->resize(n);
    product_.resize(n);
    const Real g = static_cast<Real>(kGamma) * h;
    matrix_.assemble(field, t, g, x, v, stats);

    field.eval(x, v, t, force_);
    ++stats.force_evals;
    for (std::size_t i = 0; i < n; ++i) {
      right_x_[i] = inv_mass[i] != 0 ? Vec3(v[i]) : Vec3(0, 0, 0);
      right_v_[i] = force_[i];
    }
    bool solved = solve_stage(field, g, kv1_);
    for (std::size_t i = 0; i < n; ++i) {
      kx1_[i] = right_x_[i] + g * kv1_[i];
      x_[i] = x[i] + h * kx1_[i];
      v_[i] = v[i] + h * kv1_[i];
    }

    field.eval(x_, v_, t + static_cast<double>(h), force_);
    ++stats.force_evals;
    for (std::size_t i = 0; i < n; ++i) {
      right_x_[i] = inv_mass[i] != 0 ? Vec3(v_[i] - 2 * kx1_[i]) : Vec3(0, 0, 0);
      right_v_[i] = force_[i] - 2 * mass[i] * kv1_[i];
    }
    solved = solve_stage(field, g, kv2_) && solved;
    if (!solved) ++stats.unconverged;
    const std::span<Vec3> low = low_of(field);
    for (std::size_t i = 0; i < n; ++i) {
      add_compensated(x[i], low[i], h * (Real(1.5) * kx1_[i] + Real(0.5) * (right_x_[i] + g * kv2_[i])));
      v[i] += h * (Real(1.5) * kv1_[i] + Real(0.5) * kv2_[i]);
    }
  }

 private:
  // kv from (M - g D - g^2 K) kv = right_v + g K right_x; then kx = right_x + g kv.
  bool solve_stage(ForceField& field, Real g, std::span<Vec3> kv) {
    matrix_.multiply_stiffness(right_x_, product_);
    for (std::size_t i = 0; i < kv.size(); ++i) right_v_[i] += g * product_[i].cast<Real>();
    return matrix_.solve(field, right_v_, kv, stats);
  }

  Array<Vec3> force_, x_, v_, kx1_, kv1_, kv2_, right_x_, right_v_;
  Array<Vec3d> product_;
  ImplicitMatrix matrix_;
};

}  // namespace

Variant<Integrator> integrate_ros2() {
  return variant_of<Integrator, Ros2>(
      "ros2", "order 2, two linear solves and no iteration: known cost; stiff linear systems at any step");
}

}  // namespace feder
