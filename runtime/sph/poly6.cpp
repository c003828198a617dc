// Poly6: smooth density, but no push at short distance; used by poly6_spiky.
#ifndef FEDER_SPH_WIDE
#include "sph/make_kernel.h"

namespace feder {

Kernel sph_poly6() { return single_kernel<Poly6Shape>("poly6", "poly6: density only", 2.8, 2.2); }

}  // namespace feder
#endif
