// Implicit Euler: M (v1 - v0) = h f(x0 + h v1, v1), x1 = x0 + h v1. Unconditionally stable, order 1, damps.
// Kept between calls: work arrays. Weak spot: numerical damping, 28 % of a 1 Hz swing per period at 60 steps/s; bdf2
// and tr_bdf2 lose 0.2 and 0.003 % for the same one or two solves.
#include "integrate/implicit_solve.h"

namespace feder {
namespace {

class ImplicitEuler final : public Integrator {
 public:
  ImplicitEuler(Arena& a, const Params& p) : Integrator(a), stage_(a, p) {}

  IntegratorInfo info() const override {
    IntegratorInfo i = unlimited_info(1, 2);
    i.l_stable = true;
    return i;
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::span<Vec3> low = low_of(field);
    stage_.solve_from(field, t + static_cast<double>(h), h, x, low, v, stats);
    drift(field, h, v, x, low);
  }

 private:
  ImplicitStage stage_;
};

}  // namespace

Variant<Integrator> integrate_implicit_euler() {
  return variant_of<Integrator, ImplicitEuler>(
      "implicit_euler", "order 1, stable at any step and stiffness; damps; Newton with a sparse solve");
}

}  // namespace feder
