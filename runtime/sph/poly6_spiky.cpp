// Kernels of Mueller, Charypar & Gross 2003: density by poly6, pressure by the slope of spiky, viscosity by the
// Laplacian of its own kernel. Pressure is no gradient of an energy here, and viscosity does not keep angular momentum:
// for pictures, not for measurements.
#include "sph/sweeps.h"
#ifndef FEDER_SPH_WIDE
#include "sph/make_kernel.h"
#endif

namespace feder {

extern const Sweeps kSweepsPoly6Spiky, kSweepsPoly6SpikyWide;

#ifdef FEDER_SPH_WIDE
constexpr Sweeps kSweepsPoly6SpikyWide = SweepsOf<Poly6Shape, SpikyShape, PlainViscosity<ViscosityShape>>::table();
#else
constexpr Sweeps kSweepsPoly6Spiky = SweepsOf<Poly6Shape, SpikyShape, PlainViscosity<ViscosityShape>>::table();

Kernel sph_poly6_spiky() {
  Kernel k;
  k.name = "poly6_spiky", k.summary = "poly6 for density, spiky for pressure, viscosity for viscosity";
  k.density_name = "poly6", k.pressure_name = "spiky", k.viscosity_name = "viscosity";
  k.density = plain_shape<Poly6Shape>(), k.gradient = plain_shape<SpikyShape>();
  k.viscosity.laplacian = [](int d, double u) { return ViscosityShape::kNorm[d - 2] * ViscosityShape::laplacian(u); };
  set_norms<Poly6Shape>(k.norm_density), set_norms<SpikyShape>(k.norm_gradient);
  set_norms<ViscosityShape>(k.norm_viscosity);
  k.radial_viscosity = false;
  k.support[0] = 2.8, k.support[1] = 2.2;
  k.sweeps = &kSweepsPoly6Spiky;
#ifdef __x86_64__
  k.sweeps_wide = &kSweepsPoly6SpikyWide;
#endif
  return k;
}
#endif

}  // namespace feder
