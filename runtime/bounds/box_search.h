// Searches for overlapping boxes of two lists: candidate pairs of features that may meet. One file per search, one
// feder_variant(bounds <search> TABLE searches) line. Contract, checked for every search by
// tests/bounds/test_box_search.cpp: each overlapping pair (closed boxes) once, no other, ascending: all searches give
// the same pairs in the same order, whatever was asked before. Allocates only when boxes or pairs outnumber every
// earlier call.
#pragma once
#include <memory>
#include <span>
#include <string>

#include "feder/memory.h"
#include "feder/params.h"

namespace feder {

struct BoxPair {
  std::uint32_t a = 0, b = 0;
  friend auto operator<=>(const BoxPair&, const BoxPair&) = default;
};

class BoxSearch {
 public:
  virtual ~BoxSearch() = default;
  // A box of `a` and one of `b`; replaces the content of `out`.
  virtual void between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out) = 0;
  // Two of the same list, a < b; replaces the content of `out`.
  virtual void within(std::span<const Aabb> boxes, Array<BoxPair>& out) = 0;
};

std::span<const Variant<BoxSearch>> box_searches();
std::string default_box_search();  // swept_boxes, or the first of this build

}  // namespace feder
