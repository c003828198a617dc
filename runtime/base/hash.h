// A hash of multisets, for checks.
#pragma once
#include <cstdint>

namespace feder {

// Of a multiset (Bellare, Micciancio 1997): equal for lists with the same members whatever their order, and else as
// good as never. Checks without memory that each member is listed once.
class MultisetHash {
 public:
  void add(std::uint64_t member, std::uint64_t times = 1) {
    member = (member + 0x9e3779b97f4a7c15ull) * 0xbf58476d1ce4e5b9ull;
    member = (member ^ (member >> 29)) * 0x94d049bb133111ebull;
    sum_ += times * (member ^ (member >> 32)), count_ += times;
  }
  friend bool operator==(const MultisetHash&, const MultisetHash&) = default;

 private:
  std::uint64_t sum_ = 0, count_ = 0;
};

}  // namespace feder
