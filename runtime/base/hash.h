// 64-bit FNV-1a over bytes: the state hash. Same bytes, same hash, on every machine of the same byte order.
#pragma once
#include <cstring>
#include <span>

#include "base/types.h"

namespace feder {

class Hash {
 public:
  void bytes(const void* data, std::size_t count) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < count; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ull;
  }
  template <class T>
  void add(const T& x) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes(&x, sizeof x);
  }
  void add(const Vec3& v) { add(v[0]), add(v[1]), add(v[2]); }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

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
