// Counting sort by `a` in place, by cycles, then each short run by `b`.
// Source: McIlroy, Bostic, McIlroy, "Engineering Radix Sort" (1993), American flag sort. Kept between calls: work
// arrays. Weak spot: the counting walks all indices, so few pairs among many boxes are sorted by comparison.
#include "broad/pair_sort.h"

#include <algorithm>

namespace feder {

void PairSort::sort(Array<IndexPair>& pairs, std::uint32_t count, JobPool& jobs) {
  // the counting sort walks all indices once: not worth it for a handful of pairs
  if (pairs.size() < count / 8 + 32) {
    std::sort(pairs.begin(), pairs.end());
    return;
  }
  end_.assign(count, 0), next_.resize(count);
  for (const IndexPair& p : pairs) ++end_[p.a];
  std::uint32_t sum = 0;
  for (std::uint32_t a = 0; a < count; ++a) next_[a] = sum, sum = end_[a] += sum;
  // every swap brings a pair into its run
  for (std::uint32_t a = 0; a < count; ++a) {
    while (next_[a] < end_[a]) {
      IndexPair& p = pairs[next_[a]];
      if (p.a == a)
        ++next_[a];
      else
        std::swap(p, pairs[next_[p.a]++]);
    }
  }
  constexpr JobGrain kGrain{256, 10'000};  // runs
  jobs.for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t a = first; a < last; ++a) {
      const std::uint32_t begin = a > 0 ? end_[a - 1] : 0;
      if (end_[a] - begin > 1) std::sort(pairs.begin() + begin, pairs.begin() + end_[a]);
    }
  });
}

}  // namespace feder
