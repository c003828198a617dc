// Counting sort by `a`, then each short run by `b`.
// Source: Knuth, "The Art of Computer Programming" vol. 3 (1973), 5.2. Kept between calls: a work array. Weak spot: the
// counting walks all indices, so few pairs among many boxes are sorted by comparison.
#include "broad/pair_sort.h"

#include <algorithm>

namespace feder {

void PairSort::sort(Array<IndexPair>& pairs, std::uint32_t count, Array<IndexPair>& spare, JobPool& jobs) {
  // the counting sort walks all indices once: not worth it for a handful of pairs
  if (pairs.size() < count / 8 + 32) {
    std::sort(pairs.begin(), pairs.end());
    return;
  }
  start_.assign(count + 1, 0);
  for (const IndexPair& p : pairs) ++start_[p.a + 1];
  for (std::uint32_t i = 0; i < count; ++i) start_[i + 1] += start_[i];
  spare.resize(pairs.size());
  for (const IndexPair& p : pairs) spare[start_[p.a]++] = p;
  // start_[a] is now the end of run a
  constexpr JobGrain kGrain{256, 10'000};  // runs
  jobs.for_blocks(count, kGrain, [&](std::uint32_t from, std::uint32_t last, int) {
    std::uint32_t first = from > 0 ? start_[from - 1] : 0;
    const std::uint32_t begin = first;
    for (std::uint32_t a = from; a < last; ++a) {
      if (start_[a] - first > 1) std::sort(spare.begin() + first, spare.begin() + start_[a]);
      first = start_[a];
    }
    std::copy(spare.begin() + begin, spare.begin() + first, pairs.begin() + begin);
  });
}

}  // namespace feder
