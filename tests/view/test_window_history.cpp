// The ring of moments: how far back it reaches, how it keeps to its memory.
#include "support/catch.h"
#include "view/history.h"

using namespace feder::view;

namespace {
Moment moment(std::uint64_t step, std::size_t bytes = 10) {
  return {step, static_cast<double>(step) / 60, std::string(bytes, 'x')};
}
}  // namespace

TEST_CASE("the last seconds are kept, and not much more", "[view][history]") {
  History h(2, 1 << 20);
  for (std::uint64_t i = 0; i <= 1000; ++i) h.add(moment(i));
  CHECK(h.last().step == 1000);
  CHECK(h.first().step <= 880);
  CHECK(h.first().step >= 878);
  CHECK(h.bytes() == 10 * h.size());
}

TEST_CASE("moments are found by step", "[view][history]") {
  History h(100, 1 << 20);
  for (std::uint64_t i = 0; i <= 20; i += 2) h.add(moment(i));
  CHECK(h.at(7).step == 6);
  CHECK(h.at(8).step == 8);
  CHECK(h.at(99).step == 20);
  CHECK(h.before(8)->step == 6);
  CHECK(h.before(0) == nullptr);
  CHECK(h.after(7)->step == 8);
  CHECK(h.after(8)->step == 10);
  CHECK(h.after(20) == nullptr);
  h.cut_after(9);
  CHECK(h.last().step == 8);
  CHECK(h.bytes() == 50);
}

TEST_CASE("above its memory the past is thinned out, the newest moments stay", "[view][history]") {
  History h(1000, 100 * 1000);
  for (std::uint64_t i = 0; i <= 3000; ++i) {
    h.add(moment(i, 1000));
    REQUIRE(h.bytes() <= 101 * 1000);
    REQUIRE(h.first().step == 0);
    for (std::uint64_t back = 0; back < std::min<std::uint64_t>(i, 29); ++back)
      REQUIRE(h.at(i - back).step == i - back);
  }
  // even when not even those fit, some past is left
  History small(1000, 5000);
  for (std::uint64_t i = 0; i <= 300; ++i) small.add(moment(i, 1000));
  CHECK(small.size() == 30);
  CHECK(small.last().step == 300);
}

TEST_CASE("marks of one kind in one step are counted", "[view][history]") {
  History h(1, 1 << 20);
  h.add(moment(0));
  h.mark(3, 0.05, "hit", "crate1");
  h.mark(3, 0.05, "warning", "mass ratio");
  h.mark(3, 0.05, "hit", "crate2");
  REQUIRE(h.marks().size() == 2);
  CHECK(h.marks()[0].count == 2);
  CHECK(h.marks()[0].label == "crate1");
  for (std::uint64_t i = 1; i < 200; ++i) h.add(moment(i));
  CHECK(h.marks().empty());
}
