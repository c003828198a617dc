// Items in the order of the Morton codes of their middles: 21 bits of each axis, interleaved.
#pragma once
#include <algorithm>
#include <vector>

#include "bounds/tree_build.h"

namespace feder {

struct MortonItem {
  std::uint64_t code;
  std::uint32_t item;
  bool operator<(const MortonItem& o) const { return code != o.code ? code < o.code : item < o.item; }
};

inline std::uint64_t spread_bits(std::uint64_t x) {  // two zeros after each of 21 bits
  x = (x | x << 32) & 0x1f00000000ffffull;
  x = (x | x << 16) & 0x1f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

inline std::vector<MortonItem> morton_order(std::span<const Aabb> boxes) {
  Aabb all;
  for (const Aabb& b : boxes) all.include(middle_of(b));
  std::vector<MortonItem> list;
  list.reserve(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const Vec3 m = middle_of(boxes[i]);
    std::uint64_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const double size = static_cast<double>(all.hi[k]) - static_cast<double>(all.lo[k]);
      const double at = size > 0 ? (static_cast<double>(m[k]) - static_cast<double>(all.lo[k])) / size : 0;
      code |= spread_bits(static_cast<std::uint64_t>(std::clamp(at, 0.0, 1.0) * 2097151)) << (2 - k);
    }
    list.push_back({code, i});
  }
  std::sort(list.begin(), list.end());
  return list;
}

}  // namespace feder
