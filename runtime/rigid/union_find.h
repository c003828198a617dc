// Union-find with path halving (Tarjan, van Leeuwen 1984). The smaller index is the root, so that the names of sets do
// not depend on the order of joins. Allocates only when there are more members than ever before.
#pragma once
#include <numeric>

#include "feder/error.h"
#include "feder/memory.h"

namespace feder {

class UnionFind {
 public:
  explicit UnionFind(Arena& a) : parent_(&a) {}

  void resize(std::size_t count) { parent_.resize(count); }  // new members: whatever isolate() makes of them
  void isolate(std::uint32_t i) { parent_[i] = i; }
  void reset(std::size_t count) {  // each member alone
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::size_t size() const { return parent_.size(); }
  std::uint32_t root(std::uint32_t i) {
    FEDER_ASSERT(i < parent_.size() && parent_[i] <= i);
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // Returns the root of both.
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    return a < b ? parent_[b] = a : parent_[a] = b;
  }

 private:
  Array<std::uint32_t> parent_;
};

}  // namespace feder
