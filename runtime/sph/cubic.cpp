// Cubic spline (Monaghan & Lattanzio 1985): the classical kernel, for all terms.
#include "sph/sweeps.h"
#ifndef FEDER_SPH_WIDE
#include "sph/make_kernel.h"
#endif

namespace feder {

extern const Sweeps kSweepsCubic, kSweepsCubicWide;

#ifdef FEDER_SPH_WIDE
constexpr Sweeps kSweepsCubicWide = SweepsOf<CubicShape, CubicShape, RadialViscosity<CubicShape>>::table();
#else
constexpr Sweeps kSweepsCubic = SweepsOf<CubicShape, CubicShape, RadialViscosity<CubicShape>>::table();

Kernel sph_cubic() {
  Kernel k = single_kernel<CubicShape>("cubic", "cubic spline: smooth, for all terms", 3.0, 2.0);
  k.sweeps = &kSweepsCubic;
#ifdef __x86_64__
  k.sweeps_wide = &kSweepsCubicWide;
#endif
  return k;
}
#endif

}  // namespace feder
