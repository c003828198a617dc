#include "report/build_info.h"

#include "base/wide.h"

namespace feder::report {

std::string build_compiler() {
#if defined(__clang__)
  return "clang " + std::to_string(__clang_major__) + "." + std::to_string(__clang_minor__);
#elif defined(__GNUC__)
  return "gcc " + std::to_string(__GNUC__) + "." + std::to_string(__GNUC_MINOR__);
#else
  return "unknown";
#endif
}

std::string build_flags() { return FEDER_FLAGS; }

std::string simd_path() { return runs_avx2() ? "avx2" : "plain"; }

}  // namespace feder::report
