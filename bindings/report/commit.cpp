// Compiled again at each commit (build_info.h): nothing else stands here.
namespace feder::report {

const char* build_commit();
const char* build_commit() {
  return
#include "commit.inc"
      ;
}

}  // namespace feder::report
