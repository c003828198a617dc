// Spiky: its slope does not vanish at short distance; used by poly6_spiky. (Its own sum over a lattice is 17
// % off one with the usual number of neighbours: no kernel for densities.)
#ifndef FEDER_SPH_WIDE
#include "sph/make_kernel.h"

namespace feder {

Kernel sph_spiky() { return single_kernel<SpikyShape>("spiky", "spiky: pressure only", 2.8, 2.2); }

}  // namespace feder
#endif
