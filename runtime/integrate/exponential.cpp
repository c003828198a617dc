// Exponential integrator ETD2RK (Cox & Matthews 2002) for y = (x, v), y' = F(y) = L y + N(y), L the field's K and D
// where the step starts:
//   a = y0 + h phi1(hL) F(y0),   y1 = a + h phi2(hL) (N(a) - N(y0)),   phi1, phi2 from linear_flow.
// Linear forces (springs of rest length zero, drag, weight) are integrated exactly at any h, damped or not; the rest to
// order 2, with any L. Option `max_parts`: Krylov spaces per step before the flow is taken as it is and counted as
// unconverged.
// Kept between calls: work arrays. Weak spot: forces that turn much within one period of a stiff spring resonate (h w
// near multiples of pi); large stiff nets need many substeps.
#include "integrate/linear_flow.h"
#include "integrate/pattern.h"

namespace feder {
namespace {

class Exponential final : public Integrator {
 public:
  Exponential(Arena& a, const Params& p)
      : Integrator(a), max_substeps_(p.integer({"max_parts", "", {1, 1000000}}, 256)), k_(a), d_(a), force_(&a),
        after_(&a), x_(&a), v_(&a), b_x_(&a), b_v_(&a), ramp_(&a), dx_(&a), flow_(a) {}

  IntegratorInfo info() const override {
    return {.order = 2,
            .stability_limit = static_cast<double>(kInfinity),
            .evals_per_step = 2,
            .implicit = true,
            .exact_linear = true,
            .effort_option = "max_parts",
            .damped_limit = [](double) { return static_cast<double>(kInfinity); }};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::size_t n = x.size();
    force_.resize(n), after_.resize(n), x_.resize(n), v_.resize(n);
    b_x_.resize(n), b_v_.resize(n), ramp_.resize(n);
    pattern_.update(field, n, {&k_, &d_});
    field.jacobian(x, v, t, k_, d_);
    field.eval(x, v, t, force_);
    ++stats.jacobian_evals, ++stats.force_evals;
    const std::span<const Real> inv_mass = field.inv_mass();
    for (std::size_t i = 0; i < n; ++i) {
      const bool free = inv_mass[i] != 0;
      b_x_[i] = free ? Vec3d(v[i].cast<double>()) : Vec3d(0, 0, 0);
      b_v_[i] = force_[i].cast<double>() * static_cast<double>(inv_mass[i]);
    }
    const LinearSystem system{&k_, &d_, field.mass(), inv_mass};
    const double whole = h;
    bool met = flow_.solve(system, whole, b_x_, b_v_, {}, max_substeps_);
    const std::span<Vec3> low = low_of(field);
    dx_.assign(flow_.x().begin(), flow_.x().end());
    for (std::size_t i = 0; i < n; ++i) {
      x_[i] = x[i] + (low[i] + dx_[i].cast<Real>());
      v_[i] = v[i] + flow_.v()[i].cast<Real>();
    }

    // N(a) - N(y0) = F(a) - F(y0) - L (a - y0), in v only
    field.eval(x_, v_, t + whole, after_);
    ++stats.force_evals;
    for (std::size_t i = 0; i < n; ++i)
      b_x_[i] = (x_[i] - x[i]).cast<double>(), b_v_[i] = (v_[i] - v[i]).cast<double>();
    k_.multiply<Vec3d>(b_x_, ramp_);
    d_.multiply<Vec3d>(b_v_, b_x_);
    for (std::size_t i = 0; i < n; ++i)
      ramp_[i] = ((after_[i] - force_[i]).cast<double>() - ramp_[i] - b_x_[i]) * static_cast<double>(inv_mass[i]);
    met = flow_.solve(system, whole, {}, {}, ramp_, max_substeps_) && met;
    stats.linear_solves += 2;
    if (!met) ++stats.unconverged;
    for (std::size_t i = 0; i < n; ++i) {
      add_compensated(x[i], low[i], (dx_[i] + flow_.x()[i]).cast<Real>());
      v[i] = v_[i] + flow_.v()[i].cast<Real>();
    }
  }

 private:
  int max_substeps_;
  BlockSparse k_, d_;
  Array<Vec3> force_, after_, x_, v_;
  Array<Vec3d> b_x_, b_v_, ramp_, dx_;
  LinearFlow flow_;
  FieldPattern pattern_;
};

}  // namespace

Variant<Integrator> integrate_exponential() {
  return variant_of<Integrator, Exponential>(
      "exponential", "order 2, linear forces exactly at any step and stiffness; Krylov spaces of the matrix");
}

}  // namespace feder
