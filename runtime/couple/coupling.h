// What couplings share: the systems that a coupling joins, and its descriptor. A coupling is a system that exists as
// soon as both of its systems do; where its state follows from theirs, it has none of its own to hash or save.
#pragma once
#include "feder/system.h"

namespace feder {

// A system that is there, because the coupling joins it or one of them needs it.
template <class S>
S& system_of(SystemSetup& setup) {
  return static_cast<S&>(*setup.systems.find_system(S::kName));
}

// Of coupling C between A and B; `units`: what its count() counts.
template <class C, class A, class B>
const SystemDescriptor& coupling_descriptor(const char* units) {
  static const char* const joins[] = {A::kName, B::kName};
  static const SystemDescriptor d = {.name = C::kName, .units = units, .joins = joins, .make = &make_system<C>};
  return d;
}

}  // namespace feder
