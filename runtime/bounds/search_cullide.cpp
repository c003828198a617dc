// Search by views along three axes (depth_views.h): boxes that nothing hides and that hide nothing are left out, the
// rest is swept along the axis on which it spreads most. Kept between calls: memory. Weak spot: features of one
// connected mesh, which always meet those beside them: only what has torn off is left out.
#include <algorithm>

#include "bounds/box_search.h"
#include "bounds/depth_views.h"

namespace feder {
namespace {

class CullideSearch final : public BoxSearch {
 public:
  explicit CullideSearch(Arena& arena) : views_(arena), boxes_(&arena), set_(&arena), endless_(&arena) {}

  void between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out) override {
    const auto count = static_cast<std::uint32_t>(a.size());
    find(a, b, out, [&](std::uint32_t i, std::uint32_t j) {  // i < j
      if (i < count && j >= count) out.push_back({i, j - count});
    });
  }
  void within(std::span<const Aabb> boxes, Array<BoxPair>& out) override {
    find(boxes, {}, out, [&](std::uint32_t i, std::uint32_t j) { out.push_back({i, j}); });
  }

 private:
  // Calls report(i, j), i < j, for overlapping boxes of both lists in one.
  template <class F>
  void find(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out, F&& report) {
    out.clear(), set_.clear(), endless_.clear();
    boxes_.assign(a.begin(), a.end());
    boxes_.insert(boxes_.end(), b.begin(), b.end());
    Aabb all;
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
      if (boxes_[i].empty()) continue;
      const bool finite = boxes_[i].lo.allFinite() && boxes_[i].hi.allFinite();
      (finite ? set_ : endless_).push_back(i);
      if (finite) all.include(boxes_[i]);
    }
    const auto meet = [&](std::uint32_t i, std::uint32_t j) {
      if (overlaps(boxes_[i], boxes_[j])) report(std::min(i, j), std::max(i, j));
    };
    for (const std::uint32_t i : endless_) {  // of two, once
      for (const std::uint32_t j : set_) meet(i, j);
      for (const std::uint32_t j : endless_)
        if (i < j) meet(i, j);
    }
    views_.cull(boxes_, DepthViews::pixels_for(set_.size()), set_, jobs_);
    sweep(all, meet);
    std::sort(out.begin(), out.end());
  }

  template <class F>
  void sweep(const Aabb& all, F&& meet) {
    if (set_.empty()) return;
    int axis = 0;
    Vec3(all.hi - all.lo).maxCoeff(&axis);
    std::sort(set_.begin(), set_.end(), [&](std::uint32_t i, std::uint32_t j) {
      const Real x = boxes_[i].lo[axis], y = boxes_[j].lo[axis];
      return x != y ? x < y : i < j;
    });
    for (std::size_t n = 0; n < set_.size(); ++n)
      for (std::size_t m = n + 1; m < set_.size() && boxes_[set_[m]].lo[axis] <= boxes_[set_[n]].hi[axis]; ++m)
        meet(set_[n], set_[m]);
  }

  DepthViews views_;
  JobPool jobs_{1};
  Array<Aabb> boxes_;
  Array<std::uint32_t> set_, endless_;
};

}  // namespace

Variant<BoxSearch> bounds_cullide() {
  return variant_of<BoxSearch, CullideSearch>("cullide", "views along three axes, then a sweep of what they leave");
}

}  // namespace feder
