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

// find(i, sink, worker) offers the neighbours of i and must not depend on when i is asked, or by which worker; `sorted`
// says whether it offers them in ascending order.
template <class Find>
void fill_rows(std::uint32_t count, JobPool& jobs, NeighborLists& lists, bool sorted, Find&& find) {
  constexpr JobGrain kGrain{256, 60'000};
  constexpr std::uint32_t kMaxNeighbors = NeighborLists::kMaxNeighbors, kLane = 8, kRowRoom = kMaxNeighbors + kLane;
  if (lists.count.size() < count) lists.count.resize(count), lists.rounded.resize(count);
  // what follows the last neighbour up to whole lanes is the index of nobody
  const auto write_row = [&](std::uint32_t i, std::uint32_t* row, std::uint32_t n) {
    std::fill(row + n, row + n + kLane, count);
    const std::uint32_t whole = (n + kLane - 1) / kLane * kLane;
    std::uint32_t* out = lists.index.data() + std::size_t(i) * lists.stride;
    for (std::uint32_t k = 0; k < whole; k += kLane) std::copy(row + k, row + k + kLane, out + k);
    lists.rounded[i] = whole;
  };
  std::uint32_t most = 0;
  for (;;) {
    const std::size_t room = std::size_t(count) * lists.stride + kLane;
    if (lists.index.size() < room) lists.index.resize(room);
    std::atomic<std::uint32_t> longest{0};
    jobs.for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int worker) {
      std::uint32_t far = 0, row[kRowRoom];
      for (std::uint32_t i = first; i < last; ++i) {
        RowSink sink{row, kMaxNeighbors};
        find(i, sink, worker);
        lists.count[i] = sink.n;
        far = std::max(far, sink.n);
        if (!sorted) std::sort(row, row + std::min(sink.n, kMaxNeighbors));
        write_row(i, row, std::min({sink.n, lists.stride, kMaxNeighbors}));
      }
      std::uint32_t seen = longest.load();
      while (far > seen && !longest.compare_exchange_weak(seen, far)) {
      }
    });
    most = longest.load();
    if (most <= lists.stride || lists.stride == kMaxNeighbors) break;
    lists.stride = std::min((std::min(most, kMaxNeighbors) * 5 / 4 + 7) / 8 * 8, kMaxNeighbors);
  }
  if (most <= kMaxNeighbors) return;
  // counts stay those of the full rows until all rows are thinned
  jobs.for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int worker) {
    for (std::uint32_t i = first; i < last; ++i) {
      struct Thin : RowSink {
        const std::uint32_t* counts;
        std::uint32_t i;
        void take(std::uint32_t j, bool near) {
          if (!near) return;
          const std::uint32_t crowd = std::max(counts[i], counts[j]);
          if (crowd <= kMaxNeighbors || keep_of_crowd(i, j, crowd)) RowSink::take(j, n < capacity);
        }
      };
      std::uint32_t row[kRowRoom];
      Thin sink{{row, kMaxNeighbors}, lists.count.data(), i};
      find(i, sink, worker);
      if (!sorted) std::sort(row, row + sink.n);
      write_row(i, row, sink.n);
    }
  });
  jobs.for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      const std::uint32_t* row = lists.index.data() + std::size_t(i) * lists.stride;
      std::uint32_t n = lists.rounded[i];
      while (n > 0 && row[n - 1] == count) --n;
      lists.count[i] = n;
    }
  });
}

}  // namespace feder
