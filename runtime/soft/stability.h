// Frequencies of tetrahedra and of a body made of them, at rest. Private to the module.
#pragma once
#include <vector>

#include "soft/solver.h"

namespace feder {

// h^2 w^2 of the fastest mode that solver substeps are chosen for; explicit steps are stable below 4. Beside it what
// strain may add before a push carries less than all.
inline constexpr double kResolved = 2, kCarried = 2.5;

// Largest eigenvalue of the stiffness of stress against strain at rest, Pa.
inline double rest_stiffness(const SoftMaterial& m) { return std::fmax(3 * m.lame + 2 * m.mu, 2 * m.mu); }
// Largest eigenvalue of sum g g^T over the four gradients g of barycentric weights, 1/m^2.
double gradient_bound(const Corners& gradients);
// Largest w^2, 1/s^2, of the free body, of which tetrahedron k has scale[k] of the stiffness: by `iterations` of the
// power method, from below.
double fastest_mode(const SoftMesh& mesh, std::uint32_t points, const SoftMaterial& material, double density,
                    std::span<const double> scale, int iterations);

}  // namespace feder
