// The table of kernels, from the generated list of the feder_kernel lines.
#include "sph/kernel.h"

namespace feder {

using Row = Kernel;
#include "sph_declare.inc"

std::span<const Kernel> kernels() {
  static const std::initializer_list<Kernel> table = {
#include "sph_rows.inc"
  };
  return {table.begin(), table.size()};
}

const Sweeps& sweeps_of(const Kernel& k) {
#ifdef __x86_64__
  if (k.sweeps_wide && __builtin_cpu_supports("avx2")) return *k.sweeps_wide;
#endif
  return *k.sweeps;
}

}  // namespace feder
