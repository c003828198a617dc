// Symplectic (semi-implicit) Euler, "v then x": v += h f/m, x += h v_new (de Vogelaere 1956). Default of nets.
// Damping is implicit unless `damping = "explicit"`: (M - h D) dv = h f, one conjugate-gradient solve per step and
// only where velocity-dependent forces exist. So the limit h w = 2 grows with the damping, 2(sqrt(1+z^2)+z) for the
// damping ratio z, where the explicit form's shrinks, 2(sqrt(1+z^2)-z).
// Kept between calls: nothing. Weak spot: order 1; the energy of an oscillator swings by h w / 2, without drift.
#include "integrate/damped_kick.h"

namespace feder {
namespace {

bool implicit_damping(const Params& p) {
  const std::string word = p.text("damping", "implicit");
  if (word != "implicit" && word != "explicit")
    throw SceneError("damping: expected 'implicit' or 'explicit', got '" + word + "'");
  return word == "implicit";
}

class SymplecticEuler final : public Integrator {
 public:
  SymplecticEuler(Arena& a, const Params& p) : kick_(a, implicit_damping(p)) {}

  IntegratorInfo info() const override { return {1, 2, 1, false, true}; }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    kick_.apply(field, t, h, x, v, stats);
    const std::span<const Real> inv_mass = field.inv_mass();
    for (std::size_t i = 0; i < x.size(); ++i)
      if (inv_mass[i] != 0) x[i] += h * v[i];
  }

 private:
  DampedKick kick_;
};

}  // namespace

Variant<Integrator> integrate_symplectic_euler() {
  return {"symplectic_euler", "order 1, one force evaluation, keeps energy in the mean; damping implicit",
          [](Arena& a, const Params& p) -> std::unique_ptr<Integrator> {
            return std::make_unique<SymplecticEuler>(a, p);
          }};
}

}  // namespace feder
