// What the broad phases share that are built anew in each call: the boxes of the call, those beside the index, pairs
// by a query for each box that moves, and queries.
#pragma once
#include <algorithm>
#include <vector>

#include "bounds/segment_box.h"
#include "bounds/work.h"
#include "broad/pair_sort.h"

namespace feder {

// `Index` answers over those boxes that are bounded:
//  - build(boxes, listed, jobs): of the boxes with the numbers `listed`;
//  - query(box, visit, work): visit(i) once for each that overlaps `box`; tells `work` (bounds/work.h) what it looks
//  at;
//  - kFinerFinds, if it has it: pairs_of(box, visit, work) takes the place of query for pairs: visit(i, once) where
//    `once` says that the query of i does not find this box;
//  - keep(asking), if it has it: drops those that are in no pair;
//  - drawn(), if it has it: what else it looked at while it was built;
//  - cells_at(level, draw), if it has it: as that of BroadPhase, with draw(box);
//  - query_ray(origin, ray, visit): visit(i) at least once for each that the segment hits, and for others.
template <class Index>
class RebuiltPhase final : public BroadPhase {
 public:
  explicit RebuiltPhase(Arena& arena)
      : arena_(&arena), boxes_(&arena), motion_(&arena), listed_(&arena), side_(&arena), asking_(&arena), index_(arena),
        sorter_(arena) {}

  void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion, std::span<const std::uint32_t>,
                  Array<IndexPair>& pairs, JobPool& jobs) override {
    boxes_.assign(boxes.begin(), boxes.end());
    motion_.assign(motion.begin(), motion.end());
    list_boxes();
    index_.build(boxes_, listed_, jobs);
    if constexpr (requires { index_.keep(asking_); }) index_.keep(asking_);
    query_pairs(pairs, jobs);
    pair_side(pairs);
    sorter_.sort(pairs, static_cast<std::uint32_t>(boxes.size()), jobs);
  }

  void query(const Aabb& box, Array<std::uint32_t>& found) const override {
    found.clear();
    Uncounted none;
    index_.query(
        box, [&](std::uint32_t i) { found.push_back(i); }, none);
    for (const std::uint32_t i : side_)
      if (overlaps(boxes_[i], box)) found.push_back(i);
    std::sort(found.begin(), found.end());
  }

  void query_ray(const Vec3& origin, const Vec3& ray, Array<std::uint32_t>& found) const override {
    found.clear();
    const auto visit = [&](std::uint32_t i) {
      if (segment_hits(boxes_[i], origin, ray)) found.push_back(i);
    };
    if (is_finite(origin) && is_finite(ray))
      index_.query_ray(origin, ray, visit);
    else
      for (const std::uint32_t i : listed_) visit(i);
    for (const std::uint32_t i : side_) visit(i);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
  }

  bool cells_at(int level, void (*take)(void*, const Aabb&), void* to) const override {
    const auto draw = [&](const Aabb& box) { take(to, box); };
    if constexpr (requires { index_.cells_at(level, draw); })
      return index_.cells_at(level, draw);
    else
      return false;
  }

  BroadWork work() const override {
    Counted all;
    for (const std::uint32_t i : asking_)
      pairs_of(
          i, [](std::uint32_t) {}, all);
    if constexpr (requires { index_.drawn(); }) all.visit(index_.drawn());
    all.test(side_.size() * (listed_.size() + side_.size()));
    return {all.visits, all.tests, 0};
  }

 private:
  static constexpr JobGrain kQueryGrain{64, 15'000};  // boxes

  static bool regular(const Aabb& b) {
    const Real big = Real(1e15);  // m; beyond it squares overflow in single precision
    for (int k = 0; k < 3; ++k)
      if (!(b.lo[k] <= b.hi[k] && b.lo[k] >= -big && b.hi[k] <= big)) return false;
    return true;
  }

  void list_boxes() {
    listed_.clear(), side_.clear(), asking_.clear();
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
      if (motion_[i] == BoxMotion::absent) continue;
      if (!regular(boxes_[i])) {
        side_.push_back(i);
        continue;
      }
      listed_.push_back(i);
      if (motion_[i] == BoxMotion::moving || requires { Index::kFinerFinds; }) asking_.push_back(i);
    }
  }

  template <class F, class W>
  void pairs_of(std::uint32_t i, F&& report, W& work) const {
    if constexpr (requires { Index::kFinerFinds; })
      index_.pairs_of(
          boxes_[i],
          [&](std::uint32_t j, bool once) {
            if (j != i && (once || j > i) && (motion_[i] == BoxMotion::moving || motion_[j] == BoxMotion::moving))
              report(j);
          },
          work);
    else
      index_.query(
          boxes_[i],
          [&](std::uint32_t j) {
            if (j > i || (j < i && motion_[j] == BoxMotion::still)) report(j);
          },
          work);
  }

  // Of two that move the lower number reports.
  void query_pairs(Array<IndexPair>& pairs, JobPool& jobs) {
    while (found_by_.size() < static_cast<std::size_t>(jobs.threads())) found_by_.emplace_back(arena_);
    for (Array<IndexPair>& found : found_by_) found.clear(), found.reserve(pairs.capacity());
    jobs.for_blocks(static_cast<std::uint32_t>(asking_.size()), kQueryGrain,
                    [&](std::uint32_t first, std::uint32_t last, int worker) {
                      Array<IndexPair>& found = found_by_[static_cast<std::size_t>(worker)];
                      for (std::uint32_t n = first; n < last; ++n) {
                        const std::uint32_t i = asking_[n];
                        Uncounted none;
                        pairs_of(
                            i,
                            [&](std::uint32_t j) {
                              found.push_back({std::min(i, j), std::max(i, j)});
                            },
                            none);
                      }
                    });
    pairs.clear();
    for (const Array<IndexPair>& found : found_by_) pairs.insert(pairs.end(), found.begin(), found.end());
  }

  void pair_side(Array<IndexPair>& pairs) const {
    for (const std::uint32_t i : side_) {
      const bool still = motion_[i] == BoxMotion::still;
      const auto meet = [&](std::uint32_t j) {
        if (still && motion_[j] == BoxMotion::still) return;
        if (overlaps(boxes_[i], boxes_[j])) pairs.push_back({std::min(i, j), std::max(i, j)});
      };
      for (const std::uint32_t j : listed_) meet(j);
      for (const std::uint32_t j : side_)
        if (j > i) meet(j);
    }
  }

  Arena* arena_;
  Array<Aabb> boxes_;
  Array<BoxMotion> motion_;
  Array<std::uint32_t> listed_, side_;  // bounded ones and others, both ascending
  Array<std::uint32_t> asking_;         // those of listed_ whose queries give pairs
  Index index_;
  std::vector<Array<IndexPair>> found_by_;  // by worker
  PairSort sorter_;
};

}  // namespace feder
