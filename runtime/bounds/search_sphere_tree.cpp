// Search by trees of spheres that are kept (sphere_tree.h): one for either question, as the same surface is asked for
// its triangles and for its edges.
#include "bounds/sphere_tree.h"

namespace feder {
namespace {

class SphereSearch final : public BoxSearch {
 public:
  explicit SphereSearch(Arena& arena) : between_(arena), within_(arena) {}

  void between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out) override {
    between_.update(b);
    between_.between(a, b, out);
  }
  void within(std::span<const Aabb> boxes, Array<BoxPair>& out) override {
    within_.update(boxes);
    within_.within(boxes, out);
  }

 private:
  SphereTree between_, within_;
};

}  // namespace

Variant<BoxSearch> bounds_sphere_tree() {
  return variant_of<BoxSearch, SphereSearch>("sphere_tree", "trees of spheres, updated where boxes moved");
}

}  // namespace feder
