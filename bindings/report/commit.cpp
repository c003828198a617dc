namespace feder::report {

const char* build_commit();
const char* build_commit() {
  return
#include "commit.inc"
      ;
}

}  // namespace feder::report
