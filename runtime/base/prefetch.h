// Asks for all cache lines of a thing that will be read soon. Inline always: files compiled with -mavx2 include it, and
// a copy of theirs must not run where there is no AVX2.
#pragma once
#include <cstddef>

namespace feder {

template <class T>
[[gnu::always_inline]] inline void prefetch([[maybe_unused]] const T& thing) {
#if defined(__GNUC__)
  const char* at = reinterpret_cast<const char*>(&thing);
  for (std::size_t k = 0; k < sizeof(T); k += 64) __builtin_prefetch(at + k);
  __builtin_prefetch(at + sizeof(T) - 1);
#endif
}

}  // namespace feder
