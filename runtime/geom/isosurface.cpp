// Marching cubes (Lorensen and Cline 1987): the corners of a cell that are inside choose its triangles, whose corners
// lie on the cell's edges, by linear interpolation. The 256 cases come from one rule, not from their symmetries: on
// each face of a cell, a line cuts every run of inside corners off; these lines close to loops, and a loop becomes a
// fan of triangles. Both cells of a face draw the same lines on it, so there are no holes (the ambiguity of the paper,
// Duerst 1988), and no fan has a diagonal in a face, so no edge has more than two triangles. Normals: the mean over the
// cells around a vertex of the slopes of the field there, of second order but at the rim of the grid and on edges that
// hardly cross.
// Cells are visited by blocks of 8^3, a row of corners as bits of a number: empty rows cost some instructions.
// Kept between calls: memory alone.
// Weak spot: of two inside corners across a face, apart is a guess, so that thin bridges along a diagonal break. Where
// a value equals the level, parts of the surface may meet in a corner or along an edge.
#include "geom/isosurface.h"

#include <algorithm>
#include <array>
#include <bit>

#include "feder/error.h"

namespace feder {
namespace {

constexpr int kRow = IsoBlock::kRow, kLayer = IsoBlock::kLayer, kCorners = IsoBlock::kCorners;
constexpr int kMaxTriangles = 5;     // in a cell
constexpr unsigned kCornerKind = 3;  // of a place: that of an edge is its axis

// Corners of a cell are numbered by bits x, y, z; an edge by its axis and its lower corner.
struct CellEdge {
  int axis, corner;
  constexpr int index() const { return 8 * axis + corner; }
  constexpr int place() const {
    return axis * kCorners + (corner & 1) + (corner >> 1 & 1) * kRow + (corner >> 2) * kLayer;
  }
  // A bit for each face of the cell that it lies on.
  constexpr unsigned faces() const {
    unsigned bits = 0;
    for (int k = 0; k < 3; ++k)
      if (k != axis) bits |= 1u << (2 * k + (corner >> k & 1));
    return bits;
  }
};

constexpr CellEdge edge_between(int a, int b) { return {std::countr_zero(static_cast<unsigned>(a ^ b)), a & b}; }

constexpr int kEdgeIndices = 24;  // half of them are edges

// By the index of an edge: the next one of its loop, which has the inside on its left as seen from outside.
using Loops = std::array<CellEdge, kEdgeIndices>;

// Adds the lines on the face of the cell that lies at `side` of `axis`.
constexpr void add_lines(unsigned inside, int axis, int side, Loops& next) {
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
  // counterclockwise as seen from outside of the cell
  const int ring[4] = {base, base + (side ? u : v), base + u + v, base + (side ? v : u)};
  for (int k = 0; k < 4; ++k) {
    const int before = ring[k], first = ring[(k + 1) % 4];
    if ((inside >> before & 1) || !(inside >> first & 1)) continue;
    int last = k + 1;
    while (inside >> ring[(last + 1) % 4] & 1) ++last;
    next[static_cast<std::size_t>(edge_between(before, first).index())] =
        edge_between(ring[last % 4], ring[(last + 1) % 4]);
  }
}

struct Case {
  std::uint16_t place[3 * kMaxTriangles] = {};  // of the edges that the triangles have corners on, in vertex_
  std::uint8_t count = 0;                       // of these places
};

struct Cases {
  Case of[256] = {};
  bool flat_diagonal = false;  // does a fan need a diagonal in a face?
};

// The fan of a loop, from a corner whose diagonals run through the cell.
constexpr void add_fan(const CellEdge* loop, int n, Cases& cases, Case& out) {
  int apex = 0;
  for (; apex < n; ++apex) {
    unsigned shared = 0;
    for (int k = 2; k < n - 1; ++k) shared |= loop[apex].faces() & loop[(apex + k) % n].faces();
    if (!shared) break;
  }
  if (apex == n) cases.flat_diagonal = true;
  for (int k = 1; k < n - 1; ++k)
    for (const int corner : {apex, apex + k, apex + k + 1})
      out.place[out.count++] = static_cast<std::uint16_t>(loop[corner % n].place());
}

constexpr Cases make_cases() {
  Cases cases;
  for (unsigned inside = 1; inside < 255; ++inside) {
    Loops next{};
    for (CellEdge& e : next) e.axis = -1;
    for (int face = 0; face < 6; ++face) add_lines(inside, face / 2, face % 2, next);
    for (int start = 0; start < kEdgeIndices; ++start) {
      CellEdge loop[12] = {};
      int n = 0;
      for (int at = start; next[static_cast<std::size_t>(at)].axis >= 0;) {
        const CellEdge e = next[static_cast<std::size_t>(at)];
        next[static_cast<std::size_t>(at)].axis = -1;
        loop[n++] = e;
        at = e.index();
      }
      if (n > 0) add_fan(loop, n, cases, cases.of[inside]);
    }
  }
  return cases;
}

constexpr Cases kCases = make_cases();
static_assert(!kCases.flat_diagonal);

// Where the search for a place begins (Knuth's multiplicative hash).
std::size_t home(std::uint64_t place, std::size_t mask) {
  return static_cast<std::size_t>((place * 0x9e3779b97f4a7c15ull) >> 32) & mask;
}

// Change per cell at t between the values a and b of neighbours, with the curvature by the corners before and after
// them if there are any. Bounded, so that the sign is that of b - a.
Real slope_at(Real t, Real a, Real b, const Real* before, const Real* after) {
  const Real step = b - a, low = before ? *before - a + step : Real(0), high = after ? *after - b - step : Real(0);
  const Real curvature = before && after ? (low + high) / 2 : low + high, most = Real(0.75) * std::abs(step);
  return step + clamp((t - Real(0.5)) * curvature, -most, most);
}

}  // namespace

IsoBlock::IsoBlock(const IsoGrid& grid, std::uint32_t index) {
  FEDER_ASSERT(index < grid.block_count());
  for (int k = 0; k < 3; ++k) {
    const auto blocks = static_cast<std::uint32_t>(grid.blocks(k));
    first[k] = static_cast<int>(index % blocks) * IsoGrid::kBlock;
    count[k] = std::min(kRow, grid.n[k] - first[k]);
    index /= blocks;
  }
}

void IsoSurface::extract(const IsoGrid& grid, std::span<const Real> values, Real level, bool with_normals,
                         IsoMesh& mesh) {
  const std::ptrdiff_t row = grid.n[0], layer = row * grid.n[1];
  FEDER_ASSERT(grid.block_count() == 0 || values.size() == static_cast<std::size_t>(layer * grid.n[2]));
  begin(mesh);
  for (std::uint32_t index = 0, count = grid.block_count(); index < count; ++index) {
    const IsoBlock block(grid, index);
    const Real* first = values.data() + block.first[0] + row * block.first[1] + layer * block.first[2];
    add({grid, block, first, {1, row, layer}, level, with_normals, mesh});
  }
  finish(mesh);
}

void IsoSurface::begin(IsoMesh& mesh) {
  mesh.vertices.clear(), mesh.normals.clear(), mesh.triangles.clear();
  used_ = 0;
  if (++age_ == 0) {
    for (Slot& s : slots_) s.age = 0;
    age_ = 1;
  }
}

void IsoSurface::add(const View& view) {
  if (!mark_inside(view)) return;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < view.block.count[k]; ++i) coordinate_[k][i] = view.grid.coordinate(k, view.block.first[k] + i);
  add_vertices(view);
  add_triangles(view);
}

void IsoSurface::finish(IsoMesh& mesh) const {
  for (Vec3& n : mesh.normals) n = is_finite(n) ? normalized_or(n, Vec3::Zero()) : Vec3::Zero();
}

// Whether the block has corners of both kinds.
bool IsoSurface::mark_inside(const View& view) {
  const int nx = view.block.count[0], ny = view.block.count[1], nz = view.block.count[2];
  const unsigned full = (1u << nx) - 1;
  unsigned all = full, some = 0;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y) {
      const Real* row = view.values + y * view.stride[1] + z * view.stride[2];
      unsigned bits = 0;
      if (nx == kRow)
        for (int x = 0; x < kRow; ++x) bits |= (row[x] > view.level ? 1u : 0u) << x;
      else
        for (int x = 0; x < nx; ++x) bits |= (row[x] > view.level ? 1u : 0u) << x;
      inside_[y + kRow * z] = static_cast<std::uint16_t>(bits);
      all &= bits, some |= bits;
    }
  return some != 0 && all != full;
}

void IsoSurface::add_vertices(const View& view) {
  const int nx = view.block.count[0], ny = view.block.count[1], nz = view.block.count[2];
  const unsigned steps = (1u << (nx - 1)) - 1;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y) {
      const std::uint16_t* row = inside_ + y + kRow * z;
      const unsigned bits = row[0];
      add_edges<0>(view, (bits ^ bits >> 1) & steps, y, z);
      if (y + 1 < ny) add_edges<1>(view, bits ^ row[1], y, z);
      if (z + 1 < nz) add_edges<2>(view, bits ^ row[kRow], y, z);
    }
}

// Vertices on edges along kAxis that begin in the row y, z at the corners of these bits.
template <int kAxis>
void IsoSurface::add_edges(const View& view, unsigned cut, int y, int z) {
  constexpr int kU = (kAxis + 1) % 3, kV = (kAxis + 2) % 3;
  const auto& count = view.block.count;
  IsoMesh& mesh = view.mesh;
  for (; cut; cut &= cut - 1) {
    const int corner[3] = {std::countr_zero(cut), y, z};
    const Real* at = view.values + corner[0] + y * view.stride[1] + z * view.stride[2];
    const Real a = at[0], b = at[view.stride[kAxis]], lo = coordinate_[kAxis][corner[kAxis]],
               hi = coordinate_[kAxis][corner[kAxis] + 1];
    Real t = (view.level - a) / (b - a);
    if (!(t >= 0 && t <= 1)) t = Real(0.5);  // not a number
    Vec3 p(coordinate_[0][corner[0]], coordinate_[1][y], coordinate_[2][z]);
    p[kAxis] = lo + t * (hi - lo);
    std::uint32_t vertex;
    if (p[kAxis] <= lo) {
      p[kAxis] = lo;
      vertex = shared_vertex(view, corner, kCornerKind, p);
    } else if (p[kAxis] >= hi) {
      p[kAxis] = hi;
      int end[3] = {corner[0], y, z};
      ++end[kAxis];
      vertex = shared_vertex(view, end, kCornerKind, p);
    } else if (corner[kU] == 0 || corner[kU] == count[kU] - 1 || corner[kV] == 0 || corner[kV] == count[kV] - 1) {
      vertex = shared_vertex(view, corner, kAxis, p);
    } else {
      vertex = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(p);
      if (view.with_normals) mesh.normals.push_back(Vec3::Zero());
    }
    vertex_[kAxis * kCorners + corner[0] + kRow * y + kLayer * z] = vertex;
    if (!view.with_normals) continue;
    // the sum over the cells of this block around the edge, times their size
    const Real* end = at + view.stride[kAxis];
    const std::ptrdiff_t u0 = corner[kU] > 0 ? -view.stride[kU] : 0, v0 = corner[kV] > 0 ? -view.stride[kV] : 0,
                         u1 = corner[kU] + 1 < count[kU] ? view.stride[kU] : 0,
                         v1 = corner[kV] + 1 < count[kV] ? view.stride[kV] : 0;
    const Real across_u = u0 && u1 ? Real(2) : Real(1), across_v = v0 && v1 ? Real(2) : Real(1);
    const Real du = at[u1] - at[u0], dv = at[v1] - at[v0];
    const Real slope = slope_at(t, a, b, corner[kAxis] > 0 ? at - view.stride[kAxis] : nullptr,
                                corner[kAxis] + 2 < count[kAxis] ? end + view.stride[kAxis] : nullptr);
    Vec3& normal = mesh.normals[vertex];
    normal[kAxis] -= across_u * across_v * slope;
    normal[kU] -= across_v * (du + t * (end[u1] - end[u0] - du));
    normal[kV] -= across_u * (dv + t * (end[v1] - end[v0] - dv));
  }
}

void IsoSurface::add_triangles(const View& view) {
  const int nx = view.block.count[0], ny = view.block.count[1], nz = view.block.count[2];
  const unsigned steps = (1u << (nx - 1)) - 1;
  for (int z = 0; z + 1 < nz; ++z)
    for (int y = 0; y + 1 < ny; ++y) {
      const std::uint16_t* row = inside_ + y + kRow * z;
      const unsigned r[4] = {row[0], row[1], row[kRow], row[kRow + 1]};
      const unsigned some = r[0] | r[1] | r[2] | r[3], all = r[0] & r[1] & r[2] & r[3];
      std::uint32_t found[3 * kMaxTriangles * IsoGrid::kBlock];
      std::size_t n = 0;
      for (unsigned cells = (some | some >> 1) & ~(all & all >> 1) & steps; cells; cells &= cells - 1) {
        const int x = std::countr_zero(cells);
        const Case& c = kCases.of[(r[0] >> x & 3) | (r[1] >> x & 3) << 2 | (r[2] >> x & 3) << 4 | (r[3] >> x & 3) << 6];
        const std::uint32_t* vertex = vertex_ + x + kRow * y + kLayer * z;
        for (int k = 0; k < c.count; k += 3) {
          const std::uint32_t i = vertex[c.place[k]], j = vertex[c.place[k + 1]], l = vertex[c.place[k + 2]];
          found[n] = i, found[n + 1] = j, found[n + 2] = l;
          n += i != j && j != l && l != i ? 3 : 0;
        }
      }
      view.mesh.triangles.insert(view.mesh.triangles.end(), found, found + n);
    }
}

// The vertex on the edge of the axis `kind` from a corner of the block, or at that corner; a new one at `position` when
// no block has made it yet.
std::uint32_t IsoSurface::shared_vertex(const View& view, const int (&corner)[3], unsigned kind, const Vec3& position) {
  if (2 * (used_ + 1) > slots_.size()) grow();
  std::uint64_t place = 0;
  for (int k = 2; k >= 0; --k)
    place = place * static_cast<std::uint64_t>(view.grid.n[k]) +
            static_cast<std::uint64_t>(view.block.first[k] + corner[k]);
  place = place * 4 + kind;
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = home(place, mask);
  for (; slots_[at].age == age_; at = (at + 1) & mask)
    if (slots_[at].place == place) return slots_[at].vertex;
  const auto vertex = static_cast<std::uint32_t>(view.mesh.vertices.size());
  slots_[at] = {place, vertex, age_};
  ++used_;
  view.mesh.vertices.push_back(position);
  if (view.with_normals) view.mesh.normals.push_back(Vec3::Zero());
  return vertex;
}

void IsoSurface::grow() {
  std::vector<Slot> old(std::max<std::size_t>(1024, 2 * slots_.size()));
  old.swap(slots_);
  const std::size_t mask = slots_.size() - 1;
  for (const Slot& s : old) {
    if (s.age != age_) continue;
    std::size_t at = home(s.place, mask);
    while (slots_[at].age == age_) at = (at + 1) & mask;
    slots_[at] = s;
  }
}

}  // namespace feder
