// What a failed assert prints before it aborts.
#include <cstdio>
#include <cstdlib>

#include "feder/error.h"

namespace feder {

void assert_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: assertion failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace feder
