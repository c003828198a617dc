// The surface where a field on a regular grid has one value, as triangles: marching cubes (isosurface.cpp).
#pragma once
#include <span>
#include <vector>

#include "feder/types.h"

namespace feder {

struct IsoGrid {
  Vec3 origin = Vec3::Zero();  // m, of the corner 0, 0, 0
  Real cell = 1;               // m, edge of a cell
  int n[3] = {0, 0, 0};        // corners along x, y, z; fewer than two: no cells

  // Blocks of cells, x fastest; the last of an axis may have fewer cells.
  static constexpr int kBlock = 8;  // cells
  int blocks(int axis) const { return n[axis] < 2 ? 0 : (n[axis] - 2) / kBlock + 1; }
  std::uint32_t block_count() const {  // below 2^32
    return static_cast<std::uint32_t>(blocks(0)) * static_cast<std::uint32_t>(blocks(1)) *
           static_cast<std::uint32_t>(blocks(2));
  }
  Real coordinate(int axis, int corner) const { return origin[axis] + static_cast<Real>(corner) * cell; }
};

// Corners of the cells of one block. The value at first + (x, y, z) stands at x + kRow y + kLayer z of the block's own.
struct IsoBlock {
  static constexpr int kRow = IsoGrid::kBlock + 1, kLayer = kRow * kRow, kCorners = kRow * kLayer;
  int first[3];
  int count[3];  // 2 to kRow
  IsoBlock(const IsoGrid& grid, std::uint32_t index);
};

struct IsoMesh {
  std::vector<Vec3> vertices;            // m
  std::vector<Vec3> normals;             // units, or zero where the field has no slope; empty when not asked for
  std::vector<std::uint32_t> triangles;  // three vertices each, counterclockwise as seen from outside
};

// Contract, checked by tests/geom/test_isosurface.cpp:
//  - inside is where a value is above the level; NaN is outside; normals point outwards, to lower values;
//  - a grid edge between inside and outside has one vertex; all edges cut at one corner (to rounding) share one, and
//    triangles that have two corners the same are left out: different vertices differ in position;
//  - the surface is closed but at the rim of the grid and at the faces of blocks that are left out: each of its edges
//    belongs to two triangles, which run along it in opposite directions (or to more, half of them each way, where
//    several parts meet on an edge between corners that are at the level);
//  - equal values give equal meshes, whatever was asked before; the order follows that of the blocks.
// Replaces the content of the mesh; allocates only when it, or what its blocks share, outnumbers every earlier call.
class IsoSurface {
 public:
  // Of the whole grid; values of all corners, x fastest.
  void extract(const IsoGrid& grid, std::span<const Real> values, Real level, bool with_normals, IsoMesh& mesh);

  // Of these blocks alone, no block twice; nothing else of the grid costs memory or time. sample(block, values) writes
  // the values of a block's corners; blocks that share corners must be given the same values.
  template <class Sample>
  void extract_blocks(const IsoGrid& grid, std::span<const std::uint32_t> blocks, Sample&& sample, Real level,
                      bool with_normals, IsoMesh& mesh) {
    begin(mesh);
    for (const std::uint32_t index : blocks) add_sampled(grid, index, sample, level, with_normals, mesh);
    finish(mesh);
  }

  // Of the whole grid, sampled block by block.
  template <class Sample>
  void extract_sampled(const IsoGrid& grid, Sample&& sample, Real level, bool with_normals, IsoMesh& mesh) {
    begin(mesh);
    for (std::uint32_t index = 0, count = grid.block_count(); index < count; ++index)
      add_sampled(grid, index, sample, level, with_normals, mesh);
    finish(mesh);
  }

 private:
  // A block, and where its values stand.
  struct View {
    const IsoGrid& grid;
    const IsoBlock& block;
    const Real* values;
    std::ptrdiff_t stride[3];
    Real level;
    bool with_normals;
    IsoMesh& mesh;
  };
  // Vertices that several blocks may share, by place: an open hash table, emptied by counting up `age_`.
  struct Slot {
    std::uint64_t place = 0;
    std::uint32_t vertex = 0, age = 0;
  };

  template <class Sample>
  void add_sampled(const IsoGrid& grid, std::uint32_t index, Sample& sample, Real level, bool with_normals,
                   IsoMesh& mesh) {
    const IsoBlock block(grid, index);
    sample(block, static_cast<Real*>(values_));
    add({grid, block, values_, {1, IsoBlock::kRow, IsoBlock::kLayer}, level, with_normals, mesh});
  }
  void begin(IsoMesh& mesh);
  void add(const View& view);
  void finish(IsoMesh& mesh) const;

  bool mark_inside(const View& view);
  void add_vertices(const View& view);
  void add_triangles(const View& view);
  template <int kAxis>
  void add_edges(const View& view, unsigned cut, int y, int z);
  std::uint32_t shared_vertex(const View& view, const int (&corner)[3], unsigned kind, const Vec3& position);
  void grow();

  Real values_[IsoBlock::kCorners];
  std::uint16_t inside_[IsoBlock::kLayer];        // of a row of corners along x, a bit each
  std::uint32_t vertex_[3 * IsoBlock::kCorners];  // by axis and lower corner of an edge; set where it is cut
  Real coordinate_[3][IsoBlock::kRow];            // m, of the block's corners
  std::vector<Slot> slots_;
  std::size_t used_ = 0;
  std::uint32_t age_ = 0;
};

}  // namespace feder
