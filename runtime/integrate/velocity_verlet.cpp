// Velocity Verlet, kick-drift-kick (Swope et al. 1982): order 2, symplectic. The last kick takes damping
// at the new velocity, by one correction where damping is weak and by a solve where it is stiff, so the limit h w = 2
// holds for any damping ratio and the order stays 2.
// Kept between calls: nothing. The force of the last kick could be kept for the next first kick and halve the cost,
// but contacts, scripts and snapshots change the state in between, so it is evaluated anew. Weak spot: that price.
#include "integrate/damped_kick.h"

namespace feder {
namespace {

class VelocityVerlet final : public Integrator {
 public:
  explicit VelocityVerlet(Arena& a) : Integrator(a), kick_(a) {}

  IntegratorInfo info() const override {
    return {.order = 2, .stability_limit = 2, .evals_per_step = 2, .symplectic = true, .damped_limit = [](double) {
              return 2.0;
            }};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const Real half = h / 2;
    kick_.apply(field, t, half, x, v, stats);
    drift(field, h, v, x, low_of(field));
    kick_.apply_second_order(field, t + static_cast<double>(h), half, 1, x, v, stats);
  }

 private:
  DampedKick kick_;
};

}  // namespace

Variant<Integrator> integrate_velocity_verlet() {
  return variant_of<Integrator, VelocityVerlet>(
      "velocity_verlet", "order 2, kick-drift-kick, keeps energy in the mean; stiff damping implicit");
}

}  // namespace feder
