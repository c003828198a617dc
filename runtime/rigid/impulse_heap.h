// Indexed binary heap: the node with the largest key on top; the key of any node can change. Ties go to the lower
// index, so that the order of work depends on the keys alone. O(log n) per update.
#pragma once
#include <utility>

#include "feder/error.h"
#include "feder/memory.h"

namespace feder {

class WorstFirst {
 public:
  explicit WorstFirst(Arena& a) : key_(&a), position_(&a), heap_(&a) {}

  void reserve(std::size_t nodes) {
    if (key_.size() < nodes) key_.resize(nodes), position_.resize(nodes), heap_.resize(nodes);
  }
  // Nodes [first, last) with the keys given by key_of(node).
  template <class KeyOf>
  void build(std::uint32_t first, std::uint32_t last, KeyOf&& key_of) {
    FEDER_ASSERT(first < last && last <= key_.size());
    count_ = last - first;
    for (std::uint32_t i = 0; i < count_; ++i) {
      heap_[i] = first + i;
      position_[first + i] = i;
      key_[first + i] = key_of(first + i);
    }
    for (std::uint32_t i = count_ / 2; i-- > 0;) sink(i);
  }
  std::uint32_t top() const { return heap_[0]; }
  Real top_key() const { return key_[heap_[0]]; }
  void update(std::uint32_t node, Real key) {
    FEDER_ASSERT(position_[node] < count_ && heap_[position_[node]] == node);  // one of those it was built of
    key_[node] = key;
    rise(position_[node]);
    sink(position_[node]);
  }

 private:
  bool before(std::uint32_t a, std::uint32_t b) const { return key_[a] > key_[b] || (key_[a] == key_[b] && a < b); }
  void exchange(std::uint32_t i, std::uint32_t j) {
    std::swap(heap_[i], heap_[j]);
    position_[heap_[i]] = i;
    position_[heap_[j]] = j;
  }
  void rise(std::uint32_t i) {
    while (i > 0 && before(heap_[i], heap_[(i - 1) / 2])) {
      exchange(i, (i - 1) / 2);
      i = (i - 1) / 2;
    }
  }
  void sink(std::uint32_t i) {
    for (;;) {
      std::uint32_t child = 2 * i + 1;
      if (child >= count_) return;
      if (child + 1 < count_ && before(heap_[child + 1], heap_[child])) ++child;
      if (!before(heap_[child], heap_[i])) return;
      exchange(i, child);
      i = child;
    }
  }

  Array<Real> key_;                // by node
  Array<std::uint32_t> position_;  // by node: its index in the heap
  Array<std::uint32_t> heap_;
  std::uint32_t count_ = 0;
};

}  // namespace feder
