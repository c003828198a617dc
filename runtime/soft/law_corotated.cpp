// Corotated linear elasticity: the linear law of small strains in the frame of the rotation R of F = R S,
//   Psi = mu |F - R|^2 + lambda/2 (tr S - 3)^2,  stress 2 mu (F - R) + lambda (tr S - 3) R.
// R turns and does not reflect (stretches_of), so an inverted tetrahedron is led out along its shortest axis. Weak
// spot: R jumps where the two smallest stretches are opposite; the volume counts to first order only, so a tetrahedron
// that is pulled far along two axes is pushed flat along the third by a finite force.
#include <cmath>

#include "soft/elasticity.h"

namespace feder {
namespace {

constexpr double kLeastSum = 1e-6;  // of two stretches: below it their rotation counts as that soft

double corotated_energy(const SoftMaterial& m, const Mat3d& f) {
  const Stretches d = stretches_of(f);
  double sum = 0, trace = 0;
  for (const double s : d.s) sum += (s - 1) * (s - 1), trace += s - 1;
  return m.mu * sum + m.lame / 2 * trace * trace;
}

Mat3d corotated_stress(const SoftMaterial& m, const Mat3d& f) {
  const Stretches d = stretches_of(f);
  Mat3d rotation;
  rotation.noalias() = d.u * d.v.transpose();
  const double trace = d.s[0] + d.s[1] + d.s[2] - 3;
  return (2 * m.mu) * f + (m.lame * trace - 2 * m.mu) * rotation;
}

PrincipalElasticity corotated_principal(const SoftMaterial& m, const double (&s)[3]) {
  PrincipalElasticity e{};
  const double trace = m.lame * (s[0] + s[1] + s[2] - 3);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    e.stress[i] = 2 * m.mu * (s[i] - 1) + trace;
    e.stiffness[i][i] = 2 * m.mu + m.lame;
    e.stiffness[i][j] = e.stiffness[j][i] = m.lame;
    e.flip[i] = 2 * m.mu;
    e.twist[i] = 2 * m.mu + 2 * (trace - 2 * m.mu) / std::fmax(s[j] + s[k], kLeastSum);
  }
  return e;
}

}  // namespace

ElasticLaw soft_corotated() {
  return {"corotated",
          "corotated linear elasticity: stress linear in the stretches, inverted tetrahedra are led out",
          &corotated_energy,
          &corotated_stress,
          &corotated_principal,
          true};
}

}  // namespace feder
