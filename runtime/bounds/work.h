// Counting what a search looks at, where someone asks: with Uncounted nothing is left of it.
#pragma once
#include <cstdint>

namespace feder {

struct Uncounted {
  void visit(std::uint64_t = 1) const {}
  void test(std::uint64_t = 1) const {}
};

struct Counted {
  std::uint64_t visits = 0, tests = 0;  // nodes and cells; boxes
  void visit(std::uint64_t n = 1) { visits += n; }
  void test(std::uint64_t n = 1) { tests += n; }
};

}  // namespace feder
