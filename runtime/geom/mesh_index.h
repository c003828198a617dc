// Indices of the triangles of a mesh: which of them may meet a box or a ray. One file per index, one
// feder_variant(geom <index> TABLE indexes) line. Contract, checked for every index by tests/geom/test_mesh_index.cpp:
// no triangle whose box overlaps the query is missed (by what knows more than boxes: none that meets it), whatever the
// triangles; the mesh sorts what they find, so that results have the same bits with any of them. Read only after the
// build, by several threads at once; a query allocates nothing but room in `out`. Boxes of a fifth of a metre and rays
// on 5,000 triangles (feder study mesh_index) take, over the mesh that chooses nothing, on even ground / a ribbon askew
// / a soup of many sizes: bvh of aabb by sah 1.2 / 1.4 / 0.7, of obb 4.5 / 1.9 / 2.4 (for 1.3, 4.6 and 2.4 times fewer
// triangles), grid 2.3 / 7.0 / 2.3, kd_tree 3.6 / 9.1 / 1.8, octree 7.9 / 9.5 / 9.3, bsp 46 / 27 / 3.9.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "bounds/edges.h"
#include "feder/shape.h"

namespace feder {

class TriangleIndex {
 public:
  virtual ~TriangleIndex() = default;
  // Appends numbers of triangles, in any order, some perhaps twice.
  virtual void find(const Aabb& box, std::vector<std::uint32_t>& out) const = 0;
  virtual void find_ray(const Vec3& origin, const Vec3& ray, std::vector<std::uint32_t>& out) const = 0;
  virtual std::size_t bytes() const = 0;
  // For drawing: Shape::volumes_at. Where space is divided and not the triangles, the cells.
  virtual bool volumes_at(int level, EdgeVisitor visit) const = 0;
  // For drawing: Shape::back_to_front, of those that know the order.
  using PieceVisitor = void (*)(void* context, std::uint32_t triangle, std::span<const Vec3> corners);
  virtual bool back_to_front(const Vec3&, PieceVisitor, void*) const { return false; }
};

struct TriangleIndexKind {
  const char* name;
  const char* summary;
  // `corners`: three per triangle.
  std::unique_ptr<TriangleIndex> (*make)(std::span<const Vec3> corners, const MeshIndex& choice);
};
std::span<const TriangleIndexKind> triangle_indexes();
template <class Made>
TriangleIndexKind triangle_index(const char* name, const char* summary) {
  return {name, summary, [](std::span<const Vec3> corners, const MeshIndex& choice) -> std::unique_ptr<TriangleIndex> {
            return std::make_unique<Made>(corners, choice);
          }};
}

inline Aabb box_of_triangle(std::span<const Vec3> corners, std::uint32_t i) {
  Aabb box;
  for (std::size_t k = 0; k < 3; ++k) box.include(corners[3 * std::size_t(i) + k]);
  return box;
}
inline std::vector<Aabb> boxes_of_triangles(std::span<const Vec3> corners) {
  std::vector<Aabb> boxes;
  boxes.reserve(corners.size() / 3);
  for (std::uint32_t i = 0; 3 * std::size_t(i) < corners.size(); ++i) boxes.push_back(box_of_triangle(corners, i));
  return boxes;
}

}  // namespace feder
