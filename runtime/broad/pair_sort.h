// Sorting of index pairs in linear time: a counting sort by `a`, then each short run by `b`, in parallel.
#pragma once
#include "broad/broad_phase.h"

namespace feder {

class PairSort {
 public:
  explicit PairSort(Arena& arena) : start_(&arena), spare_(&arena) {}

  // Sorts `pairs`; members are below `count`. Allocates only when `count` or the pairs outnumber every earlier call.
  void sort(Array<IndexPair>& pairs, std::uint32_t count, JobPool& jobs);

  // Once per step: gives memory back that has not been needed for long.
  void trim() { start_slack_.clear(start_), spare_slack_.clear(spare_); }

 private:
  Array<std::uint32_t> start_;
  Array<IndexPair> spare_;
  Slack start_slack_, spare_slack_;
};

}  // namespace feder
