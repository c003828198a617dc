// Sorting of index pairs in linear time: a counting sort by `a`, then each short run by `b`, in parallel.
#pragma once
#include "broad/broad_phase.h"

namespace feder {

class PairSort {
 public:
  explicit PairSort(Arena& arena) : start_(&arena) {}

  // Sorts `pairs`; members are below `count`. `spare`: work space. Allocates only when `count` or the pairs outnumber
  // every earlier call.
  void sort(Array<IndexPair>& pairs, std::uint32_t count, Array<IndexPair>& spare, JobPool& jobs);

 private:
  Array<std::uint32_t> start_;
};

}  // namespace feder
