// Grids of cells of 2^n m in one hash table: a box lies in one cell, that of its middle, of the grid whose cells
// are 1.5 to 3 times as wide as it; it meets boxes of that grid and of coarser ones, where it covers few cells. Source:
// Ericson, "Real-Time Collision Detection" (2005), 7.2.1; the hash of cells is that of the searches of particles
// (bounds/cells.h). Kept between calls: memory. Weak spot: boxes of many different sizes, as each size is a grid to
// look into.
#include "bounds/box_query.h"
#include "bounds/cells.h"
#include "bounds/counting_sort.h"
#include "broad/ray_pieces.h"
#include "broad/rebuilt.h"

namespace feder {
namespace {

class HashGridIndex {
 public:
  explicit HashGridIndex(Arena& a) : entry_(&a), start_(&a), order_(&a), sorted_(&a), boxes_(&a), levels_(&a) {
    levels_.reserve(64);  // rarely more: 2^64 lie between the smallest and the largest
  }

  void build(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed, JobPool&) {
    entry_.clear(), levels_.clear();
    double farthest = 0;
    for (const std::uint32_t i : listed)
      farthest =
          std::fmax(farthest, static_cast<double>(boxes[i].lo.cwiseAbs().cwiseMax(boxes[i].hi.cwiseAbs()).maxCoeff()));
    least_ = exponent(farthest) - kBits;  // cells whose numbers a double counts without rounding
    for (const std::uint32_t i : listed) {
      const Aabb& b = boxes[i];
      const std::uint32_t n = level_number(exponent_of(b));
      entry_.push_back({cell_of(b, levels_[n].inv), i, n}), levels_[n].bounds.include(b), ++levels_[n].count;
      levels_[n].reach = std::fmax(levels_[n].reach, 0.5 * side(b));
    }
    std::size_t buckets = 64;
    while (buckets < 2 * entry_.size()) buckets *= 2;
    mask_ = buckets - 1;
    counting_sort(
        static_cast<std::uint32_t>(entry_.size()), buckets,
        [&](std::uint32_t n) { return bucket(entry_[n].level, entry_[n].cell); }, start_, order_);
    sorted_.resize(entry_.size()), boxes_.resize(entry_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) sorted_[k] = entry_[order_[k]], boxes_[k] = boxes[sorted_[k].item];
  }

  template <class F, class W>
  void query(const Aabb& box, F&& visit, W& work) const {
    const BoxQuery wanted(box);
    for (std::uint32_t n = 0; n < levels_.size(); ++n)
      if (overlaps(levels_[n].bounds, box))
        each_near(
            n, box,
            [&](std::size_t k) {
              work.test();
              if (wanted.meets(boxes_[k])) visit(sorted_[k].item);
            },
            work);
  }

  // In its own grid a box looks at the cells from its own on: those before look at it.
  static constexpr bool kFinerFinds = true;
  template <class F, class W>
  void pairs_of(const Aabb& box, F&& visit, W& work) const {
    const BoxQuery wanted(box);
    const int own = exponent_of(box);
    for (std::uint32_t n = 0; n < levels_.size(); ++n) {
      if (levels_[n].exponent < own || !overlaps(levels_[n].bounds, box)) continue;
      const Cell cell = cell_of(box, levels_[n].inv);
      const bool coarser = levels_[n].exponent > own;
      each_near(
          n, box,
          [&](std::size_t k) {
            work.test();
            if (wanted.meets(boxes_[k]) && (coarser || !(sorted_[k].cell < cell)))
              visit(sorted_[k].item, coarser || cell < sorted_[k].cell);
          },
          work, coarser ? nullptr : &cell);
    }
  }

  template <class F>
  void query_ray(const Vec3& origin, const Vec3& ray, F&& visit) const {
    Uncounted none;
    for (std::uint32_t n = 0; n < levels_.size(); ++n) {
      const auto found = [&](std::size_t k) { visit(sorted_[k].item); };
      const bool done =
          each_ray_piece(levels_[n].bounds, origin, ray, 1 / levels_[n].inv, static_cast<double>(levels_[n].count),
                         [&](const Aabb& piece) { each_near(n, piece, found, none); });
      if (!done) each_of(n, found);
    }
  }

  template <class F>
  bool cells_at(int level, F&& draw) const {
    std::vector<int> exponents;
    for (const Level& l : levels_) exponents.push_back(l.exponent);
    std::sort(exponents.rbegin(), exponents.rend());
    if (level >= static_cast<int>(exponents.size())) return false;
    const double width = std::ldexp(1.0, exponents[static_cast<std::size_t>(level)]);
    for (std::size_t k = 0; k < sorted_.size(); ++k) {
      const Entry& e = sorted_[k];
      if (levels_[e.level].exponent != exponents[static_cast<std::size_t>(level)]) continue;
      bool drawn = false;  // with an earlier one of its bucket
      for (std::size_t j = start_[bucket(e.level, e.cell)]; j < k; ++j)
        drawn = drawn || (sorted_[j].level == e.level && sorted_[j].cell == e.cell);
      const auto corner = [&](int more) {
        const auto along = [&](CellNumber n) { return static_cast<Real>(width * static_cast<double>(n + more)); };
        return Vec3(along(e.cell.x), along(e.cell.y), along(e.cell.z));
      };
      if (!drawn) draw(Aabb{corner(0), corner(1)});
    }
    return level + 1 < static_cast<int>(exponents.size());
  }

 private:
  static constexpr int kBits = 40;
  static constexpr double kWider = 1.5;
  struct Cell {
    CellNumber x, y, z;
    bool operator==(const Cell&) const = default;
    bool operator<(const Cell& o) const {  // in the order in which they are looked at
      return z != o.z ? z < o.z : y != o.y ? y < o.y : x < o.x;
    }
  };
  struct Entry {
    Cell cell;
    std::uint32_t item, level;  // level: in levels_
  };
  struct Level {
    int exponent = 0;
    double inv = 1;  // 1/m, of the width of its cells
    std::uint32_t count = 0;
    double reach = 0;  // m, half of its largest box
    Aabb bounds;
  };

  // Of the least power of two that is not below `size`; of 0 the least of all.
  static int exponent(double size) {
    if (!(size > 0)) return -200;
    const int n = std::ilogb(size);
    return std::ldexp(1.0, n) < size ? n + 1 : n;
  }
  static double side(const Aabb& b) { return static_cast<double>(Vec3(b.hi - b.lo).maxCoeff()); }
  int exponent_of(const Aabb& b) const { return std::max(exponent(kWider * side(b)), least_); }
  std::uint32_t level_number(int wanted) {
    for (std::uint32_t n = 0; n < levels_.size(); ++n)
      if (levels_[n].exponent == wanted) return n;
    levels_.push_back({wanted, std::ldexp(1.0, -wanted), 0, 0, Aabb()});
    return static_cast<std::uint32_t>(levels_.size() - 1);
  }
  // Of the middle of a box.
  static Cell cell_of(const Aabb& b, double inv) {
    const auto along = [&](int k) {
      return cell_number(0.5 * (static_cast<double>(b.lo[k]) + static_cast<double>(b.hi[k])), inv);
    };
    return {along(0), along(1), along(2)};
  }
  std::size_t bucket(std::uint32_t level, const Cell& c) const {
    return static_cast<std::size_t>(cell_hash(c.x, c.y, c.z) + level * 0x9e3779b9u) & mask_;
  }

  template <class F>
  void each_of(std::uint32_t level, F&& f) const {
    for (std::size_t k = 0; k < sorted_.size(); ++k)
      if (sorted_[k].level == level) f(k);
  }

  // Places of a level whose boxes may overlap `box`: middles lie at most half a cell outside it. `first`: of the cells
  // that are looked at, those before it are left out; boxes of such cells may be met all the same.
  template <class F, class W>
  void each_near(std::uint32_t level, const Aabb& box, F&& f, W& work, const Cell* first = nullptr) const {
    const Level& of = levels_[level];
    CellNumber from[3], to[3];
    double count = 1;
    for (int k = 0; k < 3; ++k) {
      const double half = of.reach + 1e-3 / of.inv;
      const double lo = std::fmax(static_cast<double>(box.lo[k]), static_cast<double>(of.bounds.lo[k])),
                   hi = std::fmin(static_cast<double>(box.hi[k]), static_cast<double>(of.bounds.hi[k]));
      from[k] = cell_number(lo - half, of.inv), to[k] = cell_number(hi + half, of.inv);
      count *= static_cast<double>(to[k] - from[k] + 1);
    }
    if (!(count <= static_cast<double>(of.count))) return each_of(level, f);
    Cell c;
    for (c.z = first ? first->z : from[2]; c.z <= to[2]; ++c.z) {
      const bool layer = first && c.z == first->z;
      for (c.y = layer ? first->y : from[1]; c.y <= to[1]; ++c.y)
        for (c.x = layer && c.y == first->y ? first->x : from[0]; c.x <= to[0]; ++c.x) {
          const std::size_t b = bucket(level, c);
          work.visit();
          for (std::size_t k = start_[b]; k < start_[b + 1]; ++k)
            if (sorted_[k].level == level && sorted_[k].cell == c) f(k);
        }
    }
  }

  Array<Entry> entry_;
  Array<std::uint32_t> start_, order_;
  Array<Entry> sorted_;  // by bucket
  Array<Aabb> boxes_;    // theirs
  Array<Level> levels_;
  std::size_t mask_ = 63;
  int least_ = 0;  // exponent of the finest cells
};

}  // namespace

Variant<BroadPhase> broad_hash_grid() {
  return variant_of<BroadPhase, RebuiltPhase<HashGridIndex>>("hash_grid", "grids of all sizes in one hash table");
}

}  // namespace feder
