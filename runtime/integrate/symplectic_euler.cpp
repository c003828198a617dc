// Symplectic (semi-implicit) Euler, "v then x": v += h f/m, x += h v_new (de Vogelaere 1956). Default of nets.
// Damping is explicit where that is stable for certain and implicit, (M - h D) dv = h f with one conjugate-gradient
// solve, where it may not be; `damping` = "explicit" or "implicit" forces one. So the limit h w = 2 grows with the
// damping, 2(sqrt(1+z^2)+z) for the damping ratio z, where the explicit form's alone shrinks, 2(sqrt(1+z^2)-z).
// Kept between calls: nothing. Weak spot: order 1; the energy of an oscillator swings by h w / 2, without drift.
#include "integrate/damped_kick.h"

namespace feder {
namespace {

enum class Damping { automatic, implicit, plain };

Damping damping_option(const Params& p) {
  return static_cast<Damping>(p.choice({.name = "damping", .choices = "auto, implicit, explicit"}));
}

class SymplecticEuler final : public Integrator {
 public:
  SymplecticEuler(Arena& a, const Params& p) : Integrator(a), damping_(damping_option(p)), kick_(a) {}

  IntegratorInfo info() const override {
    return {.order = 1,
            .stability_limit = 2,
            .evals_per_step = 1,
            .symplectic = true,
            .damped_limit = damping_ == Damping::plain ? explicit_limit : implicit_limit};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const bool solve = damping_ == Damping::implicit || (damping_ == Damping::automatic && field.stiff_damping(h));
    if (solve && field.damped())
      kick_.apply_implicit(field, t, h, 1, x, v, stats);
    else
      kick_.apply(field, t, h, x, v, stats);
    drift(field, h, v, x, low_of(field));
  }

 private:
  static double explicit_limit(double z) { return 2 * (std::sqrt(z * z + 1) - z); }
  static double implicit_limit(double z) { return 2 * (std::sqrt(z * z + 1) + z); }

  Damping damping_;
  DampedKick kick_;
};

}  // namespace

Variant<Integrator> integrate_symplectic_euler() {
  return variant_of<Integrator, SymplecticEuler>(
      "symplectic_euler", "order 1, one force evaluation, keeps energy in the mean; stiff damping implicit");
}

}  // namespace feder
