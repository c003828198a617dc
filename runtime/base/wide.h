// Which of the two builds of a wide kernel (base/simd.h) this machine runs.
#pragma once

namespace feder {

inline bool runs_avx2() {
#if defined(__x86_64__) || defined(__i386__)
  return __builtin_cpu_supports("avx2");
#else
  return false;
#endif
}

}  // namespace feder
