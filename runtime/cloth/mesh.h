// Topology of a cloth: checked triangles, edges, and their elements (links and hinges). Private to the module. All
// indices count from 0 within the cloth.
#pragma once
#include <span>
#include <vector>

#include "base/checks.h"
#include "feder/memory.h"

namespace feder {

// Resists a change of distance. Links that are edges of the mesh come first, in the order of the edges.
struct ClothLink {
  std::uint32_t a = 0, b = 0;
  Real rest = 0;            // m
  Real stiffness = 0;       // N/m, of the link itself
  std::uint32_t shear = 0;  // 1: a diagonal of a sheet's cell
};

// Resists a change of the angle between two triangles that share the edge v[0]-v[1]; v[2] and v[3] lie across.
struct ClothHinge {
  std::uint32_t v[4] = {};
  Real angle = 0;      // at rest, rad
  Real stiffness = 0;  // N m per rad
};

struct ClothEdge {
  std::uint32_t a = 0, b = 0;  // a < b
  std::uint32_t triangle[2] = {kNone, kNone};
  std::uint32_t opposite[2] = {kNone, kNone};
};

// Ghost vertex of a clamp: a hidden vertex, the mirror image of `inner` in `clamped`, that the first hinge ends at.
struct ClothGhost {
  std::uint32_t clamped = 0, inner = 0;
  std::uint32_t vertex = 0;    // hidden vertex
  Vec3 offset = Vec3::Zero();  // from `clamped`, which it follows, m
};

struct ClothMesh {
  explicit ClothMesh(Arena& a) : triangles(&a), edges(&a), links(&a), hinges(&a), ghosts(&a) {}
  Array<std::uint32_t> triangles;  // three per triangle
  std::uint32_t grid = 0;          // of a sheet: its columns; triangles 2k and 2k+1 are the halves of cell k
  Array<ClothEdge> edges;
  Array<ClothLink> links;
  Array<ClothHinge> hinges;
  Array<ClothGhost> ghosts;
};

// Which items (links, triangles) are at each vertex: those of v are item[first[v]] .. item[first[v + 1] - 1],
// ascending.
struct Incidence {
  // each(f) calls f(vertex, item) in ascending order of items.
  template <class Each>
  Incidence(std::uint32_t points, Each&& each) : first(points + 1, 0) {
    each([&](std::uint32_t v, std::uint32_t) { ++first[v + 1]; });
    for (std::uint32_t v = 0; v < points; ++v) first[v + 1] += first[v];
    item.resize(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    each([&](std::uint32_t v, std::uint32_t k) { item[next[v]++] = k; });
  }
  std::span<const std::uint32_t> of(std::uint32_t v) const { return {item.data() + first[v], first[v + 1] - first[v]}; }

  std::vector<std::uint32_t> first, item;
};

// What the elements are made with.
struct ClothStiffness {
  Real stretch, shear;  // N/m
  Real bend;            // N m
  // N/m, along the warp and across it; < 0: stretch. The axis is a unit vector in the rest shape of a mesh.
  Real warp = -1, weft = -1;
  Real axis[3] = {1, 0, 0};
  bool woven() const { return warp >= 0 || weft >= 0; }
  Real along() const { return warp >= 0 ? warp : stretch; }
  Real across() const { return weft >= 0 ? weft : stretch; }
};

// Stiffness of the rows of a sheet along x and along z whose cells have this aspect (x over z), N/m; fabric.cpp.
struct RowStiffness {
  Real x, z;
};
RowStiffness row_stiffness(const ClothStiffness& k, double aspect);
// Of the threads in the direction of an edge of a mesh, N/m.
Real thread_stiffness(const ClothStiffness& k, const Vec3& edge);

// A sheet in its xz plane: vertices row by row, and triangles whose diagonals alternate.
void make_sheet(const Real size[2], std::uint32_t nx, std::uint32_t ny, std::vector<Vec3>& vertices,
                std::vector<std::uint32_t>& triangles);
// SceneError naming the first bad vertex, triangle or edge: not finite, out of range, without area, used by more than
// two triangles, wound against its neighbour; vertices that belong to no triangle.
void check_mesh(std::span<const Vec3> vertices, std::span<const std::uint32_t> triangles);
// The vertices across the border edge e of a sheet, next to e.a and e.b.
void inner_neighbors(const ClothMesh& mesh, std::span<const Vec3> rest, const ClothEdge& e, std::uint32_t (&inner)[2]);
// Makes edges, links and hinges anew from the triangles and the rest positions.
void make_elements(ClothMesh& mesh, std::span<const Vec3> rest, const ClothStiffness& k);
// Mass of each vertex by the rest shape: a quarter of each whole cell of a sheet, else a third of each triangle.
void lump_masses(const ClothMesh& mesh, std::span<const Vec3> rest, Real area_density, std::span<Real> mass);
// Angle between the triangles (v0 v1 v2) and (v1 v0 v3); 0 when flat.
Real hinge_angle(const Vec3& v0, const Vec3& v1, const Vec3& v2, const Vec3& v3);

}  // namespace feder
