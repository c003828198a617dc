// Blocks of state are arrays side by side, one entry per index. A block lists its arrays once (`each_array`), and its
// saved members once (`each_saved`); what grows, removes, saves, loads and checks them goes by these lists.
#pragma once
#include <span>

#include "base/hash.h"
#include "feder/memory.h"
#include "feder/snapshot.h"

namespace feder {

// Calls f(member) for each of them, in this order.
template <class F, class... Members>
void for_each_of(F&& f, Members&... members) {
  (f(members), ...);
}

// Members that snapshots hold with their length, such as arrays and texts; all others are plain bytes.
template <class T>
inline constexpr bool kIsList = requires(const T& x) {
  x.capacity();
};

// What writes a member, and what reads it back.
inline auto saved_to(Writer& w) {
  return [&w](const auto& x) {
    if constexpr (kIsList<decltype(x)>)
      w.list(x);
    else
      w.add(x);
  };
}
inline auto loaded_from(Reader& r) {
  return [&r](auto& x) {
    if constexpr (kIsList<decltype(x)>)
      r.list(x);
    else
      r.get(x);
  };
}

// Zero, also of vectors and matrices, whose own default leaves them as they are.
template <class T>
void set_blank(T& x) {
  if constexpr (requires { x.setZero(); })
    x.setZero();
  else
    x = T{};
}

// The index of a new entry: a free one, or, after `grow()`, the one behind the last.
template <class Grow>
std::uint32_t take_index(Array<std::uint32_t>& free_list, std::size_t size, Grow&& grow) {
  if (free_list.empty()) {
    grow();
    return static_cast<std::uint32_t>(size);
  }
  const std::uint32_t i = free_list.back();
  free_list.pop_back();
  return i;
}

// Whether a list names each free index below `size`, once and no other: for checks.
template <class IsFree>
bool lists_free(std::span<const std::uint32_t> listed, std::size_t size, IsFree&& is_free) {
  MultisetHash expected, found;
  for (std::uint32_t i = 0; i < size; ++i)
    if (is_free(i)) expected.add(i);
  for (const std::uint32_t i : listed) found.add(i);
  return expected == found;
}

// The same of a block that lists its arrays: the entry is blank.
template <class Block>
std::uint32_t add_blank(Block& b) {
  const std::uint32_t i =
      take_index(b.free_list, b.size(), [&] { Block::each_array(b, [](auto& array) { array.emplace_back(); }); });
  Block::each_array(b, [i](auto& array) { set_blank(array[i]); });
  return i;
}

}  // namespace feder
