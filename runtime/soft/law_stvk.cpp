// St. Venant and Kirchhoff's law: the linear law of small strains with Green's strain E = (F^T F - 1)/2,
//   Psi = mu |E|^2 + lambda/2 (tr E)^2,  stress F (2 mu E + lambda tr E 1).
// Weak spot: E does not see a reflection, so a tetrahedron that is turned inside out is at rest as well; and pushed to
// less than 1/sqrt(3) of its length a bar gives way: there is a least force, and none at all at length 0.
#include <cmath>

#include "soft/elasticity.h"

namespace feder {
namespace {

Mat3d green_strain(const Mat3d& f) {
  Mat3d e;
  e.noalias() = f.transpose() * f;
  e.diagonal().array() -= 1;
  return 0.5 * e;
}

double stvk_energy(const SoftMaterial& m, const Mat3d& f) {
  const Mat3d e = green_strain(f);
  const double trace = e(0, 0) + e(1, 1) + e(2, 2);
  return m.mu * e.squaredNorm() + m.lame / 2 * trace * trace;
}

Mat3d stvk_stress(const SoftMaterial& m, const Mat3d& f) {
  Mat3d s = green_strain(f);
  const double trace = s(0, 0) + s(1, 1) + s(2, 2);
  s *= 2 * m.mu;
  s.diagonal().array() += m.lame * trace;
  Mat3d out;
  out.noalias() = f * s;
  return out;
}

PrincipalElasticity stvk_principal(const SoftMaterial& m, const double (&s)[3]) {
  PrincipalElasticity e{};
  const double trace = m.lame * 0.5 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] - 3);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double own = m.mu * (s[i] * s[i] - 1) + trace;
    e.stress[i] = own * s[i];
    e.stiffness[i][i] = own + (2 * m.mu + m.lame) * s[i] * s[i];
    e.stiffness[i][j] = e.stiffness[j][i] = m.lame * s[i] * s[j];
    const double squares = s[j] * s[j] + s[k] * s[k] - 1;
    e.flip[i] = m.mu * (squares + s[j] * s[k]) + trace;
    e.twist[i] = m.mu * (squares - s[j] * s[k]) + trace;
  }
  return e;
}

}  // namespace

ElasticLaw soft_stvk() {
  return {"stvk",
          "St. Venant-Kirchhoff: linear in Green's strain; gives way under pressure, stays turned inside out",
          &stvk_energy,
          &stvk_stress,
          &stvk_principal,
          false};
}

}  // namespace feder
