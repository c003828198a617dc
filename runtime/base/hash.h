// Hashes that stand for what they are of: of multisets, for checks, and of sequences, to see whether they changed.
#pragma once
#include <bit>
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

// Of a sequence of records with up to eight words each: the words of one are multiplied side by side (Carter, Wegman
// 1979, multilinear), so that long lists of wide records cost little.
class SequenceHash {
 public:
  template <class... Words>
  void add(Words... words) {
    static_assert(sizeof...(Words) <= 8);
    constexpr std::uint64_t kFactors[] = {0x9e3779b97f4a7c15ull, 0xbf58476d1ce4e5b9ull, 0x94d049bb133111ebull,
                                          0xd6e8feb86659fd93ull, 0xa0761d6478bd642full, 0xe7037ed1a0b428dbull,
                                          0x8ebc6af09c88c6e3ull, 0x589965cc75374cc3ull};
    int k = 0;
    std::uint64_t sum = 0;
    ((sum += static_cast<std::uint64_t>(words) * kFactors[k++]), ...);
    value_ = (value_ ^ sum) * 0xff51afd7ed558ccdull;
    value_ ^= value_ >> 32;
  }
  friend bool operator==(const SequenceHash&, const SequenceHash&) = default;

 private:
  std::uint64_t value_ = 1;
};

// The bits of a number.
template <class T>
std::uint64_t word_of(T x) {
  if constexpr (sizeof(T) == 8)
    return std::bit_cast<std::uint64_t>(x);
  else
    return std::bit_cast<std::uint32_t>(x);
}

}  // namespace feder
