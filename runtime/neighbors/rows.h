// What the searches share: writing rows in parallel, thinning crowds, padding.
// A crowd (more than kMaxNeighbors neighbours somewhere) is thinned by a hash of the pair against the larger count of
// the two: both sides come to the same answer, so that forces between particles stay equal and opposite.
#pragma once
#include <algorithm>
#include <atomic>

#include "neighbors/neighbor_search.h"

namespace feder {

// Takes candidates for one row. Never writes beyond `capacity` + 1 entries.
struct RowSink {
  std::uint32_t* out;
  std::uint32_t capacity;
  std::uint32_t n = 0;
  void take(std::uint32_t j, bool near) {
    out[n < capacity ? n : capacity] = j;
    n += near;
  }
};

inline bool keep_of_crowd(std::uint32_t i, std::uint32_t j, std::uint32_t crowd) {
  const std::uint64_t lo = std::min(i, j), hi = std::max(i, j);
  std::uint64_t h = (lo << 32 | hi) * 0x9e3779b97f4a7c15ull;
  h = (h ^ h >> 29) * 0xbf58476d1ce4e5b9ull;
  return (h >> 40) * crowd < (std::uint64_t(NeighborLists::kMaxNeighbors) * 3 / 4) << 24;
}

// find(i, sink) offers the neighbours of i and must not depend on when i is asked; `sorted` says whether it
// offers them in ascending order.
template <class Find>
void fill_rows(std::uint32_t count, JobPool& jobs, NeighborLists& lists, bool sorted, Find&& find) {
  constexpr JobGrain kGrain{256, 80'000}, kPadGrain{1024, 5'000};
  constexpr std::uint32_t kMaxNeighbors = NeighborLists::kMaxNeighbors;
  if (lists.count.size() < count) lists.count.resize(count), lists.rounded.resize(count);
  std::uint32_t most = 0;
  for (;;) {
    const std::size_t room = std::size_t(count) * lists.stride + 8;
    if (lists.index.size() < room) lists.index.resize(room);
    std::atomic<std::uint32_t> longest{0};
    jobs.for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      std::uint32_t far = 0, row[kMaxNeighbors + 1];
      for (std::uint32_t i = first; i < last; ++i) {
        RowSink sink{row, kMaxNeighbors};
        find(i, sink);
        lists.count[i] = sink.n;
        far = std::max(far, sink.n);
        const std::uint32_t n = std::min({sink.n, lists.stride, kMaxNeighbors});
        if (!sorted) std::sort(row, row + std::min(sink.n, kMaxNeighbors));
        std::copy(row, row + n, lists.index.data() + std::size_t(i) * lists.stride);
      }
      std::uint32_t seen = longest.load();
      while (far > seen && !longest.compare_exchange_weak(seen, far)) {
      }
    });
    most = longest.load();
    if (most <= lists.stride || lists.stride == kMaxNeighbors) break;
    lists.stride = std::min((std::min(most, kMaxNeighbors) * 5 / 4 + 7) / 8 * 8, kMaxNeighbors);
  }
  if (most > kMaxNeighbors) {
    // counts stay those of the full rows until all rows are thinned
    jobs.for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        std::uint32_t* row = lists.index.data() + std::size_t(i) * lists.stride;
        struct Thin : RowSink {
          const std::uint32_t* counts;
          std::uint32_t i;
          void take(std::uint32_t j, bool near) {
            if (!near) return;
            const std::uint32_t crowd = std::max(counts[i], counts[j]);
            if (crowd <= kMaxNeighbors || keep_of_crowd(i, j, crowd)) RowSink::take(j, n < capacity);
          }
        };
        std::uint32_t room[kMaxNeighbors + 1];
        Thin sink{{room, kMaxNeighbors}, lists.count.data(), i};
        find(i, sink);
        if (!sorted) std::sort(room, room + sink.n);
        std::copy(room, room + sink.n, row);
        lists.rounded[i] = sink.n;
      }
    });
    for (std::uint32_t i = 0; i < count; ++i) lists.count[i] = lists.rounded[i];
  }
  jobs.for_blocks(count, kPadGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      const std::uint32_t n = lists.count[i], whole = (n + 7) / 8 * 8;
      std::fill(lists.index.data() + std::size_t(i) * lists.stride + n,
                lists.index.data() + std::size_t(i) * lists.stride + whole, count);
      lists.rounded[i] = whole;
    }
  });
}

}  // namespace feder
