// CULLIDE: views of all boxes along three axes take out those that nothing hides and that hide nothing
// (bounds/depth_views.h); what is left is swept along the axis on which its middles vary most. Views have as many
// pixels as there are boxes, four times as many along a side, up to 256. Source: Govindaraju et al. 2003 (there for
// triangles of whole models, on graphics hardware). Kept between calls: memory. Weak spot: crowds, in which something
// hides everything; views cost as much where nothing moves.
#include <limits>

#include "bounds/depth_views.h"
#include "broad/rebuilt.h"

namespace feder {
namespace {

class CullideIndex {
 public:
  explicit CullideIndex(Arena& a)
      : views_(a), left_(&a), meets_(&a), sorted_(&a), sorted_boxes_(&a), rest_(&a), rest_boxes_(&a) {}

  void build(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed, JobPool& jobs) {
    left_.assign(listed.begin(), listed.end());
    drawn_ = views_.cull(boxes, DepthViews::pixels_for(listed.size()), left_, jobs);
    meets_.assign(boxes.size(), 0);
    for (const std::uint32_t i : left_) meets_[i] = 1;
    choose_axis(boxes, listed);
    sort(boxes, listed, sorted_, sorted_boxes_), sort(boxes, left_, rest_, rest_boxes_);
    widest_ = 0;
    for (const Aabb& b : sorted_boxes_) widest_ = std::max(widest_, b.hi[axis_] - b.lo[axis_]);
  }

  // Drops those that meet nothing.
  void keep(Array<std::uint32_t>& asking) const {
    std::erase_if(asking, [&](std::uint32_t i) { return meets_[i] == 0; });
  }

  template <class F, class W>
  void query(const Aabb& box, F&& visit, W& work) const {
    const Real rounding =
        4 * std::numeric_limits<Real>::epsilon() * (widest_ + std::fabs(box.lo[axis_]) + std::fabs(box.hi[axis_]));
    const auto from = std::partition_point(sorted_boxes_.begin(), sorted_boxes_.end(), [&](const Aabb& b) {
      return b.lo[axis_] < box.lo[axis_] - widest_ - rounding;
    });
    for (auto k = static_cast<std::size_t>(from - sorted_boxes_.begin()); k < sorted_.size(); ++k) {
      if (sorted_boxes_[k].lo[axis_] > box.hi[axis_]) break;
      work.test();
      if (overlaps(sorted_boxes_[k], box)) visit(sorted_[k]);
    }
  }

  // Of two that are left, the one that begins later is found by the other; both find each other where they begin
  // together.
  static constexpr bool kFinerFinds = true;
  template <class F, class W>
  void pairs_of(const Aabb& box, F&& visit, W& work) const {
    const auto from = std::partition_point(rest_boxes_.begin(), rest_boxes_.end(),
                                           [&](const Aabb& b) { return b.lo[axis_] < box.lo[axis_]; });
    for (auto k = static_cast<std::size_t>(from - rest_boxes_.begin()); k < rest_.size(); ++k) {
      if (rest_boxes_[k].lo[axis_] > box.hi[axis_]) break;
      work.test();
      if (overlaps(rest_boxes_[k], box)) visit(rest_[k], rest_boxes_[k].lo[axis_] > box.lo[axis_]);
    }
  }

  template <class F>
  void query_ray(const Vec3&, const Vec3&, F&& visit) const {
    for (const std::uint32_t i : sorted_) visit(i);
  }

  template <class F>
  bool cells_at(int level, F&& draw) const {
    if (level == 0)
      for (const Aabb& b : rest_boxes_) draw(b);
    return false;
  }

  std::uint64_t drawn() const { return drawn_; }

 private:
  void choose_axis(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed) {
    double most = -1;
    for (int k = 0; k < 3; ++k) {
      double sum = 0, square = 0;
      for (const std::uint32_t i : listed) {
        const double c = static_cast<double>(boxes[i].lo[k]) + static_cast<double>(boxes[i].hi[k]);
        sum += c, square += c * c;
      }
      const double spread = listed.empty() ? 0 : square - sum * sum / static_cast<double>(listed.size());
      if (spread > most) most = spread, axis_ = k;
    }
  }

  void sort(const Array<Aabb>& boxes, const Array<std::uint32_t>& from, Array<std::uint32_t>& items,
            Array<Aabb>& placed) const {
    items.assign(from.begin(), from.end());
    std::sort(items.begin(), items.end(), [&](std::uint32_t i, std::uint32_t j) {
      const Real a = boxes[i].lo[axis_], b = boxes[j].lo[axis_];
      return a != b ? a < b : i < j;
    });
    placed.clear();
    for (const std::uint32_t i : items) placed.push_back(boxes[i]);
  }

  DepthViews views_;
  Array<std::uint32_t> left_;    // that may meet another
  Array<unsigned char> meets_;   // by box: it is one of these
  Array<std::uint32_t> sorted_;  // by where they begin along the axis
  Array<Aabb> sorted_boxes_;     // theirs
  Array<std::uint32_t> rest_;    // those of left_ in that order
  Array<Aabb> rest_boxes_;
  Real widest_ = 0;  // m, along the axis
  int axis_ = 0;
  std::uint64_t drawn_ = 0;  // boxes, in the last call
};

}  // namespace

Variant<BroadPhase> broad_cullide() {
  return variant_of<BroadPhase, RebuiltPhase<CullideIndex>>("cullide",
                                                            "what nothing hides in views along three axes is left out");
}

}  // namespace feder
