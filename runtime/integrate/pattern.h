// The pattern of a force field's matrices, fetched again only when it changed.
#pragma once
#include <initializer_list>
#include <vector>

#include "integrate/integrator.h"

namespace feder {

class FieldPattern {
 public:
  // True when the matrices got a new pattern (and became zero).
  bool update(const ForceField& field, std::size_t n, std::initializer_list<BlockSparse*> matrices) {
    if (version_ == field.pattern_version() && points_ == n) return false;
    blocks_.clear();
    field.pattern(blocks_);
    for (BlockSparse* m : matrices) m->set_pattern(n, blocks_);
    version_ = field.pattern_version();
    points_ = n;
    return true;
  }
  std::span<const BlockIndex> blocks() const { return blocks_; }

 private:
  std::vector<BlockIndex> blocks_;
  std::size_t points_ = ~std::size_t{0};
  std::uint64_t version_ = ~std::uint64_t{0};
};

}  // namespace feder
