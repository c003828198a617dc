// Search by a hierarchy of the boxes, built anew for each call (box_tree.h). Kept between calls: memory.
#include <algorithm>

#include "bounds/box_search.h"
#include "bounds/box_tree.h"

namespace feder {
namespace {

class SweptBoxes final : public BoxSearch {
 public:
  explicit SweptBoxes(Arena& arena) : tree_(arena) {}

  void between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out) override {
    out.clear();
    tree_.build(b);
    for (std::uint32_t i = 0; i < a.size(); ++i) {
      const auto begin = static_cast<std::ptrdiff_t>(out.size());
      tree_.query(a[i], [&](std::uint32_t j) { out.push_back({i, j}); });
      std::sort(out.begin() + begin, out.end());
    }
  }
  void within(std::span<const Aabb> boxes, Array<BoxPair>& out) override {
    out.clear();
    tree_.build(boxes);
    std::ptrdiff_t begin = 0;  // of the pairs of i, which come together
    tree_.pairs([&](std::uint32_t i, std::uint32_t j) {
      if (!out.empty() && out.back().a != i) {
        std::sort(out.begin() + begin, out.end());
        begin = static_cast<std::ptrdiff_t>(out.size());
      }
      out.push_back({i, j});
    });
    std::sort(out.begin() + begin, out.end());
  }

 private:
  BoxTree tree_;
};

}  // namespace

Variant<BoxSearch> bounds_swept_boxes() {
  return variant_of<BoxSearch, SweptBoxes>("swept_boxes", "a hierarchy of the boxes");
}

}  // namespace feder
