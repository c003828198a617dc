// A hierarchy of bounding volumes, by any volume and build of bounds/.
#include "bounds/volume.h"
#include "geom/mesh_index.h"

namespace feder {
namespace {

class BvhIndex final : public TriangleIndex {
 public:
  BvhIndex(std::span<const Vec3> corners, const MeshIndex& choice)
      : tree_(bounding_volume(choice.volume.empty() ? "aabb" : choice.volume).hierarchy()) {
    tree_->build({corners, 3}, tree_build(choice.build.empty() ? "top_down" : choice.build),
                 choice.leaf > 0 ? choice.leaf : 4);
  }
  void find(const Aabb& box, std::vector<std::uint32_t>& out) const override { tree_->query(box, append(out)); }
  void find_ray(const Vec3& origin, const Vec3& ray, std::vector<std::uint32_t>& out) const override {
    tree_->query_ray(origin, ray, append(out));
  }
  std::size_t bytes() const override { return tree_->bytes(); }
  bool volumes_at(int level, EdgeVisitor visit) const override { return tree_->volumes_at(level, visit); }

 private:
  static ItemVisitor append(std::vector<std::uint32_t>& out) {
    return {[](void* to, std::uint32_t i) { static_cast<std::vector<std::uint32_t>*>(to)->push_back(i); }, &out};
  }
  std::unique_ptr<Hierarchy> tree_;
};

}  // namespace

TriangleIndexKind geom_bvh() {
  return triangle_index<BvhIndex>("bvh", "hierarchy of bounding volumes: any shape of mesh");
}

}  // namespace feder
