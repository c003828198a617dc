// Viscosity kernel: its Laplacian is positive everywhere; used by poly6_spiky.
// 3D: W'' + 2 W'/u = 1 - u with W = W' = 0 at u = 1 gives W = -u^3/12 + u^2/6 + 1/(12 u) - 1/6.
// 2D: W'' + W'/u = 1 - u likewise gives W = u^2/4 - u^3/9 - ln(u)/6 - 5/36.
#ifndef FEDER_SPH_WIDE
#include <cmath>

#include "sph/make_kernel.h"

namespace feder {
namespace {

double value(int d, double u) {
  if (!(u < 1)) return 0;
  const double w = d == 3 ? -u * u * u / 12 + u * u / 6 + 1 / (12 * u) - 1.0 / 6
                          : u * u / 4 - u * u * u / 9 - std::log(u) / 6 - 5.0 / 36;
  return ViscosityShape::kNorm[d - 2] * w;
}
double slope(int d, double u) {
  if (!(u < 1)) return 0;
  const double w = d == 3 ? -u * u / 4 + u / 3 - 1 / (12 * u * u) : u / 2 - u * u / 3 - 1 / (6 * u);
  return ViscosityShape::kNorm[d - 2] * w / u;
}

}  // namespace

Kernel sph_viscosity() {
  Kernel k;
  k.name = k.density_name = k.pressure_name = k.viscosity_name = "viscosity", k.summary = "viscosity: Laplacian only";
  k.density.value = value, k.density.slope = slope;
  k.density.laplacian = [](int d, double u) { return ViscosityShape::kNorm[d - 2] * ViscosityShape::laplacian(u); };
  k.gradient = k.viscosity = k.density;
  for (auto* norm : {&k.norm_density, &k.norm_gradient, &k.norm_viscosity}) set_norms<ViscosityShape>(*norm);
  return k;
}

}  // namespace feder
#endif
