// Sweep and prune on one axis: boxes sorted by their lower bound; each is tested against those that begin before it
// ends. Source: Baraff, "Dynamic Simulation of Non-Penetrating Rigid Bodies" (1992), chapter on bounding boxes;
// Cohen et al., "I-COLLIDE", I3D 1995.
// Kept between calls: the sorted order. Boxes move little from step to step, so an insertion sort is nearly linear.
// The axis is the one along which the centres vary most; it changes only when another is clearly better.
// Unbounded boxes need nothing special: a lower bound of -infinity sorts first and such a box meets all others.
// Weak spot: scenes that are dense along every axis (a pile), and many still boxes, which are swept along.
#include <algorithm>
#include <cmath>

#include "bounds/segment_box.h"
#include "broad/pair_sort.h"

namespace feder {
namespace {

class SweepPrune final : public BroadPhase {
 public:
  explicit SweepPrune(Arena& arena) : boxes_(&arena), order_(&arena), listed_(&arena), sorter_(arena) {}

  void find_pairs(std::span<const Aabb> boxes, std::span<const BoxMotion> motion, std::span<const std::uint32_t>,
                  Array<IndexPair>& pairs, JobPool& jobs) override {
    boxes_.assign(boxes.begin(), boxes.end());
    enlist(motion);
    choose_axis();
    sort_order();
    sweep(motion, pairs);
    sorter_.sort(pairs, static_cast<std::uint32_t>(boxes.size()), jobs);
  }

  void query(const Aabb& box, Array<std::uint32_t>& found) const override {
    found.clear();
    for (const std::uint32_t i : order_) {
      if (boxes_[i].lo[axis_] > box.hi[axis_]) break;
      if (overlaps(boxes_[i], box)) found.push_back(i);
    }
    std::sort(found.begin(), found.end());
  }

  void query_ray(const Vec3& origin, const Vec3& ray, Array<std::uint32_t>& found) const override {
    found.clear();
    for (const std::uint32_t i : order_)
      if (segment_hits(boxes_[i], origin, ray)) found.push_back(i);
    std::sort(found.begin(), found.end());
  }

 private:
  // A box with NaN overlaps nothing and would spoil the order.
  bool all_ordered(std::uint32_t i) const {
    for (int k = 0; k < 3; ++k)
      if (std::isnan(boxes_[i].lo[k]) || std::isnan(boxes_[i].hi[k])) return false;
    return true;
  }
  bool before(std::uint32_t i, std::uint32_t j) const {
    const Real a = boxes_[i].lo[axis_], b = boxes_[j].lo[axis_];
    return a < b || (a == b && i < j);
  }

  // Drops from the order what is gone and appends what is new.
  void enlist(std::span<const BoxMotion> motion) {
    const auto wanted = [&](std::uint32_t i) {
      return i < motion.size() && motion[i] != BoxMotion::absent && all_ordered(i);
    };
    listed_.assign(motion.size(), 0);
    std::size_t kept = 0;
    for (const std::uint32_t i : order_) {
      if (!wanted(i)) continue;
      listed_[i] = 1;
      order_[kept++] = i;
    }
    order_.resize(kept);
    for (std::uint32_t i = 0; i < motion.size(); ++i)
      if (!listed_[i] && wanted(i)) order_.push_back(i);
  }

  void choose_axis() {
    double sum[3] = {0, 0, 0}, square[3] = {0, 0, 0}, count = 0;
    for (const std::uint32_t i : order_) {
      const Vec3 center = (boxes_[i].lo + boxes_[i].hi) * Real(0.5);
      if (!is_finite(center)) continue;
      for (int k = 0; k < 3; ++k) sum[k] += center[k], square[k] += double(center[k]) * center[k];
      count += 1;
    }
    if (count == 0) return;
    double spread[3];
    for (int k = 0; k < 3; ++k) spread[k] = square[k] - sum[k] * sum[k] / count;
    // 1.5: a new axis costs a full sort, so a small gain is not worth it
    for (int k = 0; k < 3; ++k)
      if (spread[k] > 1.5 * spread[axis_]) axis_ = k;
  }

  void sort_order() {
    // insertion sort; gives up in favour of a full sort when the order has little to do with the last one
    std::size_t shifts = 0;
    const std::size_t budget = 8 * order_.size() + 64;
    for (std::size_t n = 1; n < order_.size(); ++n) {
      const std::uint32_t i = order_[n];
      std::size_t at = n;
      for (; at > 0 && before(i, order_[at - 1]); --at) order_[at] = order_[at - 1];
      order_[at] = i;
      shifts += n - at;
      if (shifts <= budget) continue;
      std::sort(order_.begin(), order_.end(), [this](std::uint32_t x, std::uint32_t y) { return before(x, y); });
      return;
    }
  }

  void sweep(std::span<const BoxMotion> motion, Array<IndexPair>& pairs) const {
    pairs.clear();
    for (std::size_t n = 0; n < order_.size(); ++n) {
      const std::uint32_t i = order_[n];
      const Aabb& box = boxes_[i];
      const bool still = motion[i] == BoxMotion::still;
      for (std::size_t m = n + 1; m < order_.size(); ++m) {
        const std::uint32_t j = order_[m];
        if (boxes_[j].lo[axis_] > box.hi[axis_]) break;
        if (still && motion[j] == BoxMotion::still) continue;
        if (overlaps(box, boxes_[j])) pairs.push_back({std::min(i, j), std::max(i, j)});
      }
    }
  }

  Array<Aabb> boxes_;
  Array<std::uint32_t> order_;
  Array<std::uint8_t> listed_;
  PairSort sorter_;
  int axis_ = 0;
};

}  // namespace

Variant<BroadPhase> broad_sweep_prune() {
  return variant_of<BroadPhase, SweepPrune>("sweep_prune", "boxes sorted along one axis, the order kept between steps");
}

}  // namespace feder
