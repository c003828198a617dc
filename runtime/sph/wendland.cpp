// Wendland C2 (Wendland 1995): its Fourier transform is nowhere negative, so particles do not pair however many
// neighbours they have.
#include "sph/sweeps.h"
#ifndef FEDER_SPH_WIDE
#include "sph/make_kernel.h"
#endif

namespace feder {

extern const Sweeps kSweepsWendland, kSweepsWendlandWide;

#ifdef FEDER_SPH_WIDE
constexpr Sweeps kSweepsWendlandWide = SweepsOf<WendlandShape, WendlandShape, RadialViscosity<WendlandShape>>::table();
#else
constexpr Sweeps kSweepsWendland = SweepsOf<WendlandShape, WendlandShape, RadialViscosity<WendlandShape>>::table();

Kernel sph_wendland() {
  Kernel k = single_kernel<WendlandShape>("wendland", "Wendland C2: particles do not pair, for all terms", 3.4, 2.4);
  k.sweeps = &kSweepsWendland;
#ifdef __x86_64__
  k.sweeps_wide = &kSweepsWendlandWide;
#endif
  return k;
}
#endif

}  // namespace feder
