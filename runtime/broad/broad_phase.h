// Broad phase: from world-space boxes to pairs that may touch. Knows no bodies, shapes or world.
#pragma once
#include <compare>
#include <span>

#include "base/jobs.h"
#include "base/registry.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

// Indices into the box array; a < b.
struct IndexPair {
  std::uint32_t a, b;
  friend auto operator<=>(const IndexPair&, const IndexPair&) = default;
};

enum class BoxMotion : std::uint8_t { absent, still, moving };  // absent: skipped; two still boxes make no pair

// Nodes and cells looked at, boxes compared with boxes, and ends of boxes that changed places.
struct BroadWork {
  std::uint64_t visits = 0, tests = 0, swaps = 0;
};

// Contract, checked for every registered variant by tests/broad/test_broad_contract.cpp:
//  - the pairs are exactly the overlapping ones (closed boxes) with at least one moving member, sorted;
//  - so equal boxes give equal pairs in equal order, whatever was asked before;
//  - boxes may be unbounded (planes).
// Allocates only when boxes or pairs outnumber every call of late.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  // Replaces the content of `pairs`. The one virtual call of a step; loops inside stay concrete. `touched`: ascending,
  // the boxes that may differ from the last call in place or motion, and all that move; the others are as they were.
  // The same pairs for any number of threads.
  virtual void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion,
                          std::span<const std::uint32_t> touched, Array<IndexPair>& pairs, JobPool& jobs) = 0;

  // Boxes of the last find_pairs() that overlap `box` / are hit by the segment, ascending; replaces `found`.
  // query_still(): all still ones that do, and perhaps some that move.
  virtual void query(const Aabb& box, Array<std::uint32_t>& found) const = 0;
  virtual void query_still(const Aabb& box, Array<std::uint32_t>& found) const { query(box, found); }
  virtual void query_ray(const Vec3& origin, const Vec3& ray, Array<std::uint32_t>& found) const = 0;

  // For pictures: calls take(to, box) for what the last find_pairs() searched by. Of a tree the nodes `level` steps
  // below its root and the leaves above them; of grids the cells in use, a grid a level, the widest first; of `cullide`
  // the boxes that its views left. Is there a level below? Others have none.
  virtual bool cells_at(int, void (*)(void* to, const Aabb&), void*) const { return false; }

  // Of the last find_pairs(), without what building takes. For studies: searches are repeated to be counted.
  virtual BroadWork work() const = 0;
};

std::span<const Variant<BroadPhase>> broad_phases();

}  // namespace feder
