// A uniform grid over the middles of the boxes: a box meets those whose middles lie in the cells within its own reach
// and that of the largest box. Source: Ericson, "Real-Time Collision Detection" (2005), 7.1; a counting sort by cells
// (bounds/cell_grid.h), which the searches of particles share, so that a row of cells is one run.
// Boxes over kLarge times the mean size are no part of the grid and are compared with all.
// Kept between calls: memory. Weak spot: boxes of very different sizes; a stray box far away spoils nothing, as the
// cells at the rim take what lies beyond.
#include "bounds/box_query.h"
#include "bounds/cell_grid.h"
#include "broad/ray_pieces.h"
#include "broad/rebuilt.h"

namespace feder {
namespace {

constexpr double kLarge = 3;

class GridIndex {
 public:
  explicit GridIndex(Arena& a)
      : cells_(a), points_(&a), small_(&a), order_(&a), item_(&a), sorted_(&a), large_(&a), large_box_(&a) {}

  void build(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed, JobPool& jobs) {
    double sum = 0;
    for (const std::uint32_t i : listed) sum += side(boxes[i]);
    const double most = listed.empty() ? 0 : kLarge * sum / static_cast<double>(listed.size());
    points_.clear(), small_.clear(), large_.clear(), large_box_.clear();
    bounds_ = Aabb();
    double widest = 0;
    reach_ = Vec3::Zero();
    for (const std::uint32_t i : listed) {
      const Aabb& b = boxes[i];
      if (!(side(b) <= most)) {
        large_.push_back(i), large_box_.push_back(b);
        continue;
      }
      const Vec3 c = middle(b);
      for (int k = 0; k < 3; ++k) points_.push_back(c[k]);
      points_.push_back(0), small_.push_back(i), bounds_.include(b);
      widest = std::max(widest, side(b)), reach_ = reach_.cwiseMax(Real(0.5) * (b.hi - b.lo));
    }
    width_ = widest > 0 ? widest : 1.0;
    cells_.reserve(static_cast<std::uint32_t>(listed.size()));
    cells_.sort({points_.data(), points_.size()}, static_cast<Real>(width_), jobs, order_);
    item_.resize(order_.size()), sorted_.resize(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) item_[k] = small_[order_[k]], sorted_[k] = boxes[item_[k]];
  }

  template <class F, class W>
  void query(const Aabb& box, F&& visit, W& work) const {
    const BoxQuery wanted(box);
    each_near(
        box,
        [&](std::uint32_t k) {
          work.test();
          if (wanted.meets(sorted_[k])) visit(item_[k]);
        },
        work);
    work.test(large_.size());
    for (std::size_t k = 0; k < large_.size(); ++k)
      if (wanted.meets(large_box_[k])) visit(large_[k]);
  }

  template <class F>
  void query_ray(const Vec3& origin, const Vec3& ray, F&& visit) const {
    if (!item_.empty()) {
      Uncounted none;
      const bool done =
          each_ray_piece(bounds_, origin, ray, width_, static_cast<double>(item_.size()), [&](const Aabb& piece) {
            each_near(
                piece, [&](std::uint32_t k) { visit(item_[k]); }, none);
          });
      if (!done)
        for (const std::uint32_t i : item_) visit(i);
    }
    for (const std::uint32_t i : large_) visit(i);
  }

  template <class F>
  bool cells_at(int level, F&& draw) const {
    if (level > 0 || item_.empty()) return false;
    for (int z = 0; z < cells_.cells(2); ++z)
      for (int y = 0; y < cells_.cells(1); ++y)
        for (int x = 0; x < cells_.cells(0); ++x)
          if (cells_.first(x, y, z) < cells_.last(x, y, z)) draw(cells_.cell(x, y, z));
    return false;
  }

 private:
  static double side(const Aabb& b) { return static_cast<double>(Vec3(b.hi - b.lo).maxCoeff()); }
  static Vec3 middle(const Aabb& b) { return Real(0.5) * (b.lo + b.hi); }

  // Places whose boxes may overlap `box`.
  template <class F, class W>
  void each_near(const Aabb& box, F&& f, W& work) const {
    if (item_.empty()) return;
    int from[3], to[3];
    for (int k = 0; k < 3; ++k) {
      // middles and halves are rounded
      const Real rounding = 4 * std::numeric_limits<Real>::epsilon();
      const Real slack = reach_[k] + rounding * (std::fabs(box.lo[k]) + std::fabs(box.hi[k]) + reach_[k]);
      from[k] = cells_.coordinate(k, box.lo[k] - slack), to[k] = cells_.coordinate(k, box.hi[k] + slack);
    }
    for (int z = from[2]; z <= to[2]; ++z)
      for (int y = from[1]; y <= to[1]; ++y, work.visit())  // a row of cells
        for (std::uint32_t k = cells_.first(from[0], y, z), end = cells_.last(to[0], y, z); k < end; ++k) f(k);
  }

  CellGrid cells_;
  Array<Real> points_;  // four numbers each
  Array<std::uint32_t> small_, order_;
  Array<std::uint32_t> item_;  // in the order of the cells
  Array<Aabb> sorted_;         // their boxes
  Array<std::uint32_t> large_;
  Array<Aabb> large_box_;
  Aabb bounds_;                // of those in the grid
  Vec3 reach_ = Vec3::Zero();  // m, half of the largest of them
  double width_ = 1;           // m, of a cell
};

}  // namespace

Variant<BroadPhase> broad_grid() {
  return variant_of<BroadPhase, RebuiltPhase<GridIndex>>("grid", "a uniform grid, for boxes of about one size");
}

}  // namespace feder
