// Leapfrog, drift-kick-drift: x += h/2 v, v += h f(x, v)/m, x += h/2 v. Order 2, symplectic, one force evaluation.
// Damping is taken at the mean of the old and the new velocity, by one correction where it is weak and by a solve
// where it is stiff, so the order stays 2 and the limit h w = 2 holds for any damping ratio.
// Kept between calls: nothing. Weak spot: the force acts in the middle of the step, so a spring's end state is seen
// only after the last drift.
// Source: Verlet 1967; Hockney & Eastwood, "Computer Simulation Using Particles" (1981).
#include "integrate/damped_kick.h"

namespace feder {
namespace {

class Leapfrog final : public Integrator {
 public:
  explicit Leapfrog(Arena& a) : Integrator(a), kick_(a) {}

  IntegratorInfo info() const override {
    return {.order = 2, .stability_limit = 2, .evals_per_step = 1, .symplectic = true, .damped_limit = [](double) {
              return 2.0;
            }};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::span<Vec3> low = low_of(field);
    drift(field, h / 2, v, x, low);
    kick_.apply_second_order(field, t + static_cast<double>(h) / 2, h, Real(0.5), x, v, stats);
    drift(field, h / 2, v, x, low);
  }

 private:
  DampedKick kick_;
};

}  // namespace

Variant<Integrator> integrate_leapfrog() {
  return variant_of<Integrator, Leapfrog>(
      "leapfrog", "order 2, drift-kick-drift, keeps energy in the mean; stiff damping implicit");
}

}  // namespace feder
