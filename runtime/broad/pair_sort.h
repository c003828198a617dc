// Sorting of index pairs in linear time: a counting sort by `a`, then each short run by `b`, in parallel.
#pragma once
#include "broad/broad_phase.h"

namespace feder {

class PairSort {
 public:
  explicit PairSort(Arena& arena) : end_(&arena), next_(&arena) {}

  // Sorts `pairs`; members are below `count`. Allocates only when `count` outnumbers every earlier call.
  void sort(Array<IndexPair>& pairs, std::uint32_t count, JobPool& jobs);

 private:
  Array<std::uint32_t> end_, next_;  // of the run of each `a`
};

}  // namespace feder
