// Search by a uniform grid, hashed (Teschner et al., "Optimized spatial hashing for collision detection of deformable
// objects", 2003). Cells are as wide as the boxes are in the mean; a box is entered in each cell that it meets, and a
// pair is reported in the cell of the lowest corner of what both share, so once. Boxes that meet more than kMostCells
// cells are kept apart and compared with all. Kept between calls: memory. Weak spot: boxes of very different sizes.
#include <algorithm>
#include <cmath>

#include "bounds/box_query.h"
#include "bounds/box_search.h"

namespace feder {
namespace {

constexpr double kMostCells = 64;
constexpr double kFarCell = 1e9;  // cells from the origin, beyond which a box is kept apart

class HashSearch final : public BoxSearch {
 public:
  explicit HashSearch(Arena& arena) : first_(&arena), item_(&arena), box_(&arena), large_(&arena), entry_(&arena) {}

  void between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out) override {
    out.clear();
    enter(b, a);
    for (std::uint32_t i = 0; i < a.size(); ++i) {
      const auto begin = static_cast<std::ptrdiff_t>(out.size());
      find(a[i], b, [&](std::uint32_t j) { out.push_back({i, j}); });
      std::sort(out.begin() + begin, out.end());
    }
  }
  void within(std::span<const Aabb> boxes, Array<BoxPair>& out) override {
    out.clear();
    enter(boxes, {});
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      const auto begin = static_cast<std::ptrdiff_t>(out.size());
      find(boxes[i], boxes, [&](std::uint32_t j) {
        if (i < j) out.push_back({i, j});
      });
      std::sort(out.begin() + begin, out.end());
    }
  }

 private:
  struct Entry {
    std::uint32_t slot, item;
  };
  struct Cells {
    std::int64_t lo[3], hi[3];
    bool few = true;
  };

  std::int64_t cell_of(Real x) const { return static_cast<std::int64_t>(std::floor(static_cast<double>(x) / width_)); }
  Cells cells_of(const Aabb& box) const {
    Cells c{};
    double count = 1;
    for (int k = 0; k < 3; ++k) {
      const double from = std::floor(static_cast<double>(box.lo[k]) / width_),
                   to = std::floor(static_cast<double>(box.hi[k]) / width_);
      count *= to - from + 1;
      if (!(std::fabs(from) < kFarCell && std::fabs(to) < kFarCell && count <= kMostCells)) return c.few = false, c;
      c.lo[k] = static_cast<std::int64_t>(from), c.hi[k] = static_cast<std::int64_t>(to);
    }
    return c;
  }
  std::uint32_t slot_of(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const std::uint64_t mixed = static_cast<std::uint64_t>(x) * 73856093u ^ static_cast<std::uint64_t>(y) * 19349663u ^
                                static_cast<std::uint64_t>(z) * 83492791u;
    return static_cast<std::uint32_t>(mixed ^ mixed >> 17) & mask_;
  }
  template <class F>
  static void each_cell(const Cells& c, F&& f) {
    for (std::int64_t x = c.lo[0]; x <= c.hi[0]; ++x)
      for (std::int64_t y = c.lo[1]; y <= c.hi[1]; ++y)
        for (std::int64_t z = c.lo[2]; z <= c.hi[2]; ++z) f(x, y, z);
  }

  // Enters the boxes by slot, ascending; `others` have a say in the width of the cells.
  void enter(std::span<const Aabb> boxes, std::span<const Aabb> others) {
    double sum = 0;
    std::size_t count = 0;
    for (const std::span<const Aabb> list : {boxes, others})
      for (const Aabb& b : list)
        if (const double size = static_cast<double>((b.hi - b.lo).maxCoeff()); size < 1e30) sum += size, ++count;
    width_ = sum > 0 ? sum / static_cast<double>(count) : 1.0;
    std::uint32_t slots = 16;
    while (slots < 2 * boxes.size()) slots *= 2;
    mask_ = slots - 1;
    entry_.clear(), large_.clear();
    first_.assign(slots + 1, 0);
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (boxes[i].empty()) continue;
      const Cells c = cells_of(boxes[i]);
      if (!c.few) {
        large_.push_back(i);
        continue;
      }
      each_cell(c, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        const std::uint32_t slot = slot_of(x, y, z);
        entry_.push_back({slot, i}), ++first_[slot + 1];
      });
    }
    for (std::uint32_t k = 0; k < slots; ++k) first_[k + 1] += first_[k];
    item_.resize(entry_.size()), box_.resize(entry_.size());
    for (const Entry& e : entry_) {
      const std::uint32_t at = first_[e.slot]++;  // first_ then says where slots end
      item_[at] = e.item, box_[at] = boxes[e.item];
    }
  }

  template <class F>
  void find(const Aabb& box, std::span<const Aabb> boxes, F&& f) const {
    if (box.empty()) return;
    for (const std::uint32_t j : large_)
      if (overlaps(box, boxes[j])) f(j);
    const Cells c = cells_of(box);
    if (!c.few) {  // all that are not large
      for (std::uint32_t j = 0; j < boxes.size(); ++j)
        if (overlaps(box, boxes[j]) && cells_of(boxes[j]).few) f(j);
      return;
    }
    const BoxQuery wanted(box);
    each_cell(c, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      const std::uint32_t slot = slot_of(x, y, z), from = slot > 0 ? first_[slot - 1] : 0;
      std::uint32_t last = kNone;  // a box may be in a slot more than once, by cells with the same hash
      for (std::uint32_t k = from; k < first_[slot]; ++k) {
        const std::uint32_t j = item_[k];
        if (!wanted.meets(box_[k]) || j == last) continue;
        last = j;
        const Vec3 low = box.lo.cwiseMax(box_[k].lo);
        if (cell_of(low[0]) == x && cell_of(low[1]) == y && cell_of(low[2]) == z) f(j);
      }
    });
  }

  double width_ = 1;  // m
  std::uint32_t mask_ = 0;
  Array<std::uint32_t> first_, item_;  // boxes of slot k: item_[first_[k - 1]] to item_[first_[k] - 1], ascending
  Array<Aabb> box_;                    // theirs
  Array<std::uint32_t> large_;
  Array<Entry> entry_;
};

}  // namespace

Variant<BoxSearch> bounds_hash() { return variant_of<BoxSearch, HashSearch>("hash", "a uniform grid, hashed"); }

}  // namespace feder
