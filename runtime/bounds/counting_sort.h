// Counting sort of points by a key below `keys`, ties by index: order[k] is the point at position k, and those of key c
// lie from start[c] to start[c + 1].
#pragma once
#include <utility>

#include "feder/memory.h"

namespace feder {

template <class Key>
void counting_sort(std::uint32_t count, std::size_t keys, Key&& key, Array<std::uint32_t>& start,
                   Array<std::uint32_t>& order) {
  start.assign(keys + 1, 0);
  order.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) ++start[key(i)];
  std::uint32_t total = 0;
  for (std::uint32_t& s : start) total += std::exchange(s, total);
  for (std::uint32_t i = 0; i < count; ++i) order[start[key(i)]++] = i;
  // start[c] is now where key c ends: shift by one
  for (std::size_t c = keys; c > 0; --c) start[c] = start[c - 1];
  start[0] = 0;
}

}  // namespace feder
