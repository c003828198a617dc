// Stable neo-Hookean elasticity (Smith, de Goes and Kim 2018, eq. 14; constants in elasticity.h). Inverted tetrahedra,
// flat ones and those squeezed to a point feel a force that leads out: the only rest is a rotation. Weak spot: it
// hardens less under compression than laws with a logarithm of J, as it has to stay finite there.
#include <cmath>

#include "base/functions.h"
#include "soft/elasticity.h"

namespace feder {
namespace {

double neo_hookean_energy(const SoftMaterial& m, const Mat3d& f) {
  const double size = f.squaredNorm(), beyond = determinant(f) - m.gamma, rest = 1 - m.gamma;
  return m.shear / 2 * (size - 3 - natural_log((size + 1) / 4)) + m.lambda / 2 * (beyond * beyond - rest * rest);
}

Mat3d neo_hookean_stress(const SoftMaterial& m, const Mat3d& f) {
  const double size = f.squaredNorm();
  return (m.shear * (size / (size + 1))) * f + (m.lambda * (determinant(f) - m.gamma)) * cofactor(f);
}

PrincipalElasticity neo_hookean_principal(const SoftMaterial& m, const double (&s)[3]) {
  PrincipalElasticity e{};
  const double size = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
  const double shear = m.shear * (size / (size + 1)), bend = 2 * m.shear / ((size + 1) * (size + 1));
  const double pressure = m.lambda * (s[0] * s[1] * s[2] - m.gamma);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double area = s[j] * s[k];  // derivative of J by s_i
    e.stress[i] = shear * s[i] + pressure * area;
    e.stiffness[i][i] = shear + bend * s[i] * s[i] + m.lambda * area * area;
    e.stiffness[i][j] = e.stiffness[j][i] = bend * s[i] * s[j] + m.lambda * area * (s[k] * s[i]) + pressure * s[k];
    e.flip[i] = shear - pressure * s[i];
    e.twist[i] = shear + pressure * s[i];
  }
  return e;
}

}  // namespace

ElasticLaw soft_neo_hookean() {
  return {"neo_hookean",          "stable neo-Hookean: comes back from any state, hardens where the volume changes",
          &neo_hookean_energy,    &neo_hookean_stress,
          &neo_hookean_principal, true};
}

}  // namespace feder
