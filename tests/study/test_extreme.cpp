// Every extreme input ends as expected. The slow ones are a case of their own.
#include "study/extreme.h"
#include "support/catch.h"

using namespace feder;

namespace {

void run_all(bool slow) {
  int ran = 0;
  for (const ExtremeCase& c : extreme_cases()) {
    if (c.slow != slow) continue;
    const ExtremeOutcome out = c.run();
    CAPTURE(c.system, c.name, c.expected, name_of(out.verdict), out.detail);
    CHECK(out.as_expected);
    ++ran;
  }
  CHECK(ran >= 3);
}

}  // namespace

TEST_CASE("extreme inputs end as expected", "[study][extreme]") { run_all(false); }
TEST_CASE("long extreme runs end as expected", "[study][extreme]") { run_all(true); }
