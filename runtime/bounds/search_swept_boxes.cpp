// Search by a hierarchy of the boxes, built anew for each call (box_tree.h). Kept between calls: memory.
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
    for (std::uint32_t i = 0; i < a.size(); ++i) tree_.query(a[i], [&](std::uint32_t j) { out.push_back({i, j}); });
  }
  void within(std::span<const Aabb> boxes, Array<BoxPair>& out) override {
    out.clear();
    tree_.build(boxes);
    tree_.pairs([&](std::uint32_t i, std::uint32_t j) { out.push_back({i, j}); });
  }

 private:
  BoxTree tree_;
};

}  // namespace

Variant<BoxSearch> bounds_swept_boxes() {
  return variant_of<BoxSearch, SweptBoxes>("swept_boxes", "a hierarchy of the boxes");
}

}  // namespace feder
