// Implicit midpoint: v1 = v0 + h a(x_m, v_m) with x_m, v_m the means of both ends; solved as half a step of implicit
// Euler to the middle, which is then doubled. Order 2, symplectic, stable on linear systems at any step, and it loses
// nothing there: |R| = 1.
// Kept between calls: work arrays. Weak spot: nothing is damped at any stiffness either; a stiff chain that swings far
// in a step gains energy without bound, so A-stable is not safe: study/swinging_chain.
#include "integrate/implicit_solve.h"

namespace feder {
namespace {

class ImplicitMidpoint final : public Integrator {
 public:
  ImplicitMidpoint(Arena& a, const Params& p) : Integrator(a), stage_(a, p) {}

  IntegratorInfo info() const override {
    IntegratorInfo i = unlimited_info(2, 2);
    i.symplectic = true;
    return i;
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::span<Vec3> low = low_of(field);
    const auto before = stage_.solve_from(field, t + static_cast<double>(h) / 2, h / 2, x, low, v, stats);
    drift(field, h, v, x, low);
    for (std::size_t i = 0; i < x.size(); ++i) v[i] += v[i] - before[i];
  }

 private:
  ImplicitStage stage_;
};

}  // namespace

Variant<Integrator> integrate_implicit_midpoint() {
  return variant_of<Integrator, ImplicitMidpoint>(
      "implicit_midpoint", "order 2, stable on linear systems at any step, keeps energy; not safe on stiff chains");
}

}  // namespace feder
