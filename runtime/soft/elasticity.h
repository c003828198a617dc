// Laws of elasticity of tetrahedra: the energy density of a deformation gradient F, its gradient, and its Hessian made
// positive semidefinite. What every solver of soft bodies, and every question about their energy, is made of. One file
// law_<name>.cpp each, one feder_variant(soft <name> TABLE laws FILE law_<name>.cpp) line. All in double whatever Real
// is. Contract, checked for every row by tests/soft/test_elasticity.cpp:
//  - no energy and no stress at rest, nor where the body is only turned; Lame's constants for small strains;
//  - the stress is the gradient of the energy, the Hessian its second derivative where that is convex, by finite
//    differences; with the projection no eigenvalue is below 0;
//  - defined for every F, inverted or flat.
#pragma once
#include <span>
#include <string>

#include "feder/types.h"

namespace feder {

// Lame's constants, and those of the stable neo-Hookean energy (Smith, de Goes and Kim, "Stable Neo-Hookean Flesh
// Simulation", TOG 2018, eq. 14), which agree with them for small strains:
//   Psi = mu'/2 (|F|^2 - 3) - mu'/2 log(|F|^2 + 1) + lambda'/2 (J - gamma)^2,  gamma = 1 + 3/4 mu'/lambda'
// Without the logarithm a tetrahedron that is squeezed to a point would stay there.
struct SoftMaterial {
  double mu = 0, lame = 0;                  // Pa
  double shear = 0, lambda = 0, gamma = 1;  // mu', lambda', Pa
  double bulk() const { return lame + mu * 2 / 3; }
};
SoftMaterial soft_material(double young, double poisson);

// Derivatives of an isotropic energy density by the principal stretches s, Pa. With `flip` and `twist` they are the
// Hessian by F: of the two ways to shear the plane of axes i and j, across axis k, the symmetric one has the stiffness
// (d_i - d_j)/(s_i - s_j), the antisymmetric one (d_i + d_j)/(s_i + s_j), where d are the derivatives (Smith, de Goes
// and Kim, "Analytic Eigensystems for Isotropic Distortion Energies", TOG 2019).
struct PrincipalElasticity {
  double stress[3];
  double stiffness[3][3];
  double flip[3], twist[3];  // by k
};

struct ElasticLaw {
  const char* name;                                         // in Lua
  const char* summary;                                      // one line for help texts
  double (*energy)(const SoftMaterial& m, const Mat3d& f);  // J/m^3
  Mat3d (*stress)(const SoftMaterial& m, const Mat3d& f);   // first Piola-Kirchhoff, Pa
  PrincipalElasticity (*principal)(const SoftMaterial& m, const double (&s)[3]);
  bool turns_back;  // an inverted tetrahedron is not at rest
};

std::span<const ElasticLaw> elastic_laws();

double determinant(const Mat3d& f);
Mat3d cofactor(const Mat3d& f);  // gradient of the determinant

// F = U diag(s) V^T with rotations U and V: s[0] >= s[1] >= |s[2]|, and s[2] < 0 where F is inverted (Irving, Teran and
// Fedkiw 2004).
struct Stretches {
  double s[3];
  Mat3d u, v;
};
Stretches stretches_of(const Mat3d& f);

// Pairs of corners, in the order of `off` below.
inline constexpr int kCornerPairs[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

// Second derivatives of the energy density by the places of the corners, Pa/m^2; g: gradients of their barycentric
// weights at rest, 1/m. The whole is positive semidefinite if `project`.
struct CornerStiffness {
  Mat3d diagonal[4], off[6];
};
void corner_stiffness(const ElasticLaw& law, const SoftMaterial& m, const Mat3d& f, const Vec3d (&g)[4], bool project,
                      CornerStiffness& out);

}  // namespace feder
