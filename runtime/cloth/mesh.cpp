// Elements of a cloth and their stiffness from moduli. An edge stands for the area of its two triangles: k = stretch
// (A1 + A2)/|e|^2 (Van Gelder 1998), which is exact for the rows of a sheet. A sheet's cell has both diagonals as shear
// links, each k = shear |d|^2/(2 area of the cell), so it has no preferred diagonal. Diagonals also stretch: rows give
// that much less, so that `stretch` is the modulus of the whole. Hinges of a triangle mesh are its edges, k = bend
// |e|^2/(A1 + A2) (Grinspun et al. 2003, up to a factor). A sheet has one for each three vertices in a row instead,
// about the line across: with the mesh's own, every other vertex of a row could kink freely, because the triangles on
// both sides lie over the neighbouring row (measured: 25 % too soft). Its diagonals resist twist only. At a clamp the
// bent length is half a cell: twice the stiffness. Masses of a sheet come from cells: alternate diagonals would load
// every other vertex twice. Weak spot: bending of a triangle mesh along other than its own lines depends on the mesh.
#include "cloth/mesh.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "feder/error.h"

namespace feder {
namespace {

Real area_of(std::span<const Vec3> x, const std::uint32_t* t) {
  return Real(0.5) * length(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

std::string three(const std::uint32_t* t) {
  return "{" + std::to_string(t[0] + 1) + ", " + std::to_string(t[1] + 1) + ", " + std::to_string(t[2] + 1) + "}";
}

// One side of a triangle; sorted, equal edges lie together.
struct Side {
  std::uint32_t a, b, triangle, opposite;
  bool reversed;  // runs from b to a
  bool operator<(const Side& o) const { return a != o.a ? a < o.a : b != o.b ? b < o.b : triangle < o.triangle; }
};

std::vector<Side> sides_of(std::span<const std::uint32_t> triangles) {
  FEDER_ASSERT(triangles.size() % 3 == 0);
  std::vector<Side> sides;
  sides.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size() / 3; ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[3 * t + static_cast<std::uint32_t>(k)],
                          b = triangles[3 * t + static_cast<std::uint32_t>((k + 1) % 3)],
                          c = triangles[3 * t + static_cast<std::uint32_t>((k + 2) % 3)];
      sides.push_back({std::min(a, b), std::max(a, b), t, c, a > b});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

bool shares_edge(const std::uint32_t* s, const std::uint32_t* t, std::uint32_t& own, std::uint32_t& other) {
  int common = 0;
  own = other = kNone;
  for (int i = 0; i < 3; ++i) {
    bool in_t = false, in_s = false;
    for (int j = 0; j < 3; ++j) in_t = in_t || s[i] == t[j], in_s = in_s || t[i] == s[j];
    common += in_t;
    if (!in_t) own = s[i];
    if (!in_s) other = t[i];
  }
  FEDER_ASSERT(common != 2 || (own != kNone && other != kNone));
  return common == 2;
}

}  // namespace

void make_sheet(const Real size[2], std::uint32_t nx, std::uint32_t ny, std::vector<Vec3>& vertices,
                std::vector<std::uint32_t>& triangles) {
  FEDER_ASSERT(nx >= 2 && ny >= 2);
  vertices.clear(), triangles.clear();
  for (std::uint32_t j = 0; j < ny; ++j)
    for (std::uint32_t i = 0; i < nx; ++i)
      vertices.push_back(Vec3((static_cast<Real>(i) / static_cast<Real>(nx - 1) - Real(0.5)) * size[0], 0,
                              (static_cast<Real>(j) / static_cast<Real>(ny - 1) - Real(0.5)) * size[1]));
  for (std::uint32_t j = 0; j + 1 < ny; ++j)
    for (std::uint32_t i = 0; i + 1 < nx; ++i) {
      const std::uint32_t a = j * nx + i, b = a + 1, c = a + nx, d = c + 1;  // a b on this row, c d on the next
      if ((i + j) % 2 == 0)
        triangles.insert(triangles.end(), {a, d, b, a, c, d});  // normal +y
      else
        triangles.insert(triangles.end(), {a, c, b, b, c, d});
    }
  FEDER_ASSERT(triangles.size() == std::size_t(6) * (nx - 1) * (ny - 1) && triangles.back() + 1 == vertices.size());
}

void check_mesh(std::span<const Vec3> x, std::span<const std::uint32_t> triangles) {
  const auto fail = [](const std::string& what) { throw SceneError("cloth: " + what); };
  if (x.size() < 3) fail("vertices: expected at least 3, got " + std::to_string(x.size()));
  if (triangles.empty() || triangles.size() % 3)
    fail("triangles: expected three vertex numbers each, got " + std::to_string(triangles.size()) + " numbers");
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!is_finite(x[i])) fail("vertices[" + std::to_string(i + 1) + "]: expected finite numbers");
  // triangles: indices, area, and each vertex in one of them
  std::vector<char> used(x.size(), 0);
  for (std::size_t t = 0; t < triangles.size() / 3; ++t) {
    const std::uint32_t* v = &triangles[3 * t];
    const std::string at = "triangles[" + std::to_string(t + 1) + "]";
    for (int k = 0; k < 3; ++k) {
      if (v[k] >= x.size())
        fail(at + ": expected vertex numbers from 1 to " + std::to_string(x.size()) + ", got " +
             std::to_string(v[k] + 1));
      used[v[k]] = 1;
    }
    const Real longest = std::max({length(x[v[1]] - x[v[0]]), length(x[v[2]] - x[v[1]]), length(x[v[0]] - x[v[2]])});
    if (!(area_of(x, v) > Real(1e-5) * longest * longest))
      fail(at + ": expected a triangle with an area, got " + three(v) + " without one");
  }
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!used[i]) fail("vertices[" + std::to_string(i + 1) + "]: belongs to no triangle");
  const std::vector<Side> sides = sides_of(triangles);
  // sides are sorted: those of one edge follow each other
  for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
    const Side &s = sides[k], &n = sides[k + 1];
    if (s.a != n.a || s.b != n.b) continue;
    const std::string edge = "the edge " + std::to_string(s.a + 1) + "-" + std::to_string(s.b + 1);
    const std::string both = std::to_string(s.triangle + 1) + " and " + std::to_string(n.triangle + 1);
    if (k + 2 < sides.size() && sides[k + 2].a == s.a && sides[k + 2].b == s.b)
      fail("triangles: " + edge + " belongs to more than two triangles (" + both + ", " +
           std::to_string(sides[k + 2].triangle + 1) + ")");
    if (s.reversed == n.reversed)
      fail("triangles: " + edge + " is run the same way by triangles " + both + "; expected one winding for all");
  }
}

Real hinge_angle(const Vec3& v0, const Vec3& v1, const Vec3& v2, const Vec3& v3) {
  const Vec3 e = v1 - v0, n1 = cross(e, v2 - v0), n2 = cross(v3 - v0, e);
  return arc_tan2(dot(cross(n1, n2), normalized_or(e, Vec3(1, 0, 0))), dot(n1, n2));
}

// The four vertices of cell c, when it is whole; shared: the ends of its diagonal, then the other two.
static bool cell_corners(const ClothMesh& m, std::uint32_t c, std::uint32_t (&v)[4]) {
  const std::uint32_t *s = &m.triangles[6 * c], *t = s + 3;
  if (!shares_edge(s, t, v[2], v[3])) return false;
  int n = 0;
  for (int i = 0; i < 3; ++i)
    if (s[i] != v[2] && n < 2) v[n++] = s[i];
  FEDER_ASSERT(n == 2 && v[0] != v[1] && v[2] != v[3]);
  return true;
}

// In the cell of triangle t: the corners next to a and next to b, off the edge a-b. False when the cell is torn.
static bool across(const ClothMesh& m, std::span<const Vec3> rest, std::uint32_t t, std::uint32_t a, std::uint32_t b,
                   std::uint32_t (&inner)[2]) {
  std::uint32_t v[4], others[2];
  if (!cell_corners(m, t / 2, v)) return false;
  FEDER_ASSERT(std::count(v, v + 4, a) == 1 && std::count(v, v + 4, b) == 1);
  int n = 0;
  for (const std::uint32_t i : v)
    if (i != a && i != b && n < 2) others[n++] = i;
  const bool first = length(rest[others[0]] - rest[a]) < length(rest[others[1]] - rest[a]);
  inner[0] = others[first ? 0 : 1], inner[1] = others[first ? 1 : 0];
  return true;
}

void inner_neighbors(const ClothMesh& m, std::span<const Vec3> rest, const ClothEdge& e, std::uint32_t (&inner)[2]) {
  const bool whole = across(m, rest, e.triangle[0], e.a, e.b, inner);
  FEDER_ASSERT(whole);
}

void lump_masses(const ClothMesh& m, std::span<const Vec3> rest, Real density, std::span<Real> mass) {
  FEDER_ASSERT(mass.size() <= rest.size());  // hidden vertices have none
  std::fill(mass.begin(), mass.end(), Real(0));
  const auto give = [&](const std::uint32_t* v, int n, Real total) {
    FEDER_ASSERT(!(total < 0));
    for (int k = 0; k < n; ++k) mass[v[k]] += total / static_cast<Real>(n);
  };
  for (std::uint32_t t = 0; t < m.triangles.size() / 3; ++t) {
    const std::uint32_t* k = &m.triangles[3 * t];
    std::uint32_t v[4];
    if (m.grid && cell_corners(m, t / 2, v))
      give(v, 4, density * area_of(rest, k));
    else
      give(k, 3, density * area_of(rest, k));
  }
}

// Three vertices in a row: `wing` - `middle` - `wing`, about the line from the middle to `axis`.
struct RowHinge {
  std::uint32_t middle, wing[2], axis;
  Real stiffness;
  bool operator<(const RowHinge& o) const {
    return std::tie(middle, wing[0], wing[1]) < std::tie(o.middle, o.wing[0], o.wing[1]);
  }
  bool same(const RowHinge& o) const { return middle == o.middle && wing[0] == o.wing[0] && wing[1] == o.wing[1]; }
};

static void add_hinge(ClothMesh& m, std::span<const Vec3> rest, const std::uint32_t (&v)[4], Real stiffness) {
  FEDER_ASSERT(v[0] != v[1] && std::max({v[0], v[1], v[2], v[3]}) < rest.size());
  ClothHinge h;
  std::copy(v, v + 4, h.v);
  h.angle = hinge_angle(rest[v[0]], rest[v[1]], rest[v[2]], rest[v[3]]);
  h.stiffness = stiffness;
  m.hinges.push_back(h);
}

// The mesh's own hinge at edge e, v[0] -> v[1] as the first triangle runs it.
static void add_edge_hinge(ClothMesh& m, std::span<const Vec3> rest, const ClothEdge& e, Real stiffness) {
  const std::uint32_t* t = &m.triangles[3 * e.triangle[0]];
  const int at = t[0] == e.opposite[0] ? 1 : t[1] == e.opposite[0] ? 2 : 0;
  FEDER_ASSERT(std::minmax(t[at], t[(at + 1) % 3]) == std::minmax(e.a, e.b));
  add_hinge(m, rest, {t[at], t[(at + 1) % 3], e.opposite[0], e.opposite[1]}, stiffness);
}

static void add_row_hinges(ClothMesh& m, std::span<const Vec3> rest, std::vector<RowHinge>& list) {
  // each edge across gave half of its length; a vertex between two edges gets both
  for (RowHinge& h : list)
    if (h.wing[0] > h.wing[1]) std::swap(h.wing[0], h.wing[1]);
  std::stable_sort(list.begin(), list.end());
  for (std::size_t i = 0; i < list.size();) {
    RowHinge h = list[i++];
    FEDER_ASSERT(h.axis != h.middle && h.axis != h.wing[0] && h.axis != h.wing[1]);
    for (; i < list.size() && list[i].same(h); ++i) h.stiffness += list[i].stiffness;
    add_hinge(m, rest, {h.middle, h.axis, h.wing[0], h.wing[1]}, h.stiffness);
  }
}

static void make_hinges(ClothMesh& m, std::span<const Vec3> rest, Real bend) {
  m.hinges.clear();
  if (bend == 0) return;
  std::vector<RowHinge> rows;
  for (const ClothEdge& e : m.edges) {
    const Real size = length(rest[e.b] - rest[e.a]);
    std::uint32_t near[2], far[2];
    // border: hinges only at a clamp, to its ghost vertices
    if (e.triangle[1] == kNone) {
      for (const ClothGhost& g : m.ghosts)
        for (int k = 0; k < 2; ++k) {
          const std::uint32_t middle = k ? e.b : e.a;
          if (g.clamped != middle || !across(m, rest, e.triangle[0], e.a, e.b, near) || near[k] != g.inner) continue;
          FEDER_ASSERT(g.vertex < rest.size() && g.vertex > std::max(g.inner, g.clamped));
          const Real cell = length(rest[g.inner] - rest[middle]);
          rows.push_back({middle, {g.inner, g.vertex}, k ? e.a : e.b, bend * size / cell});  // size/2 over cell/2
        }
      continue;
    }
    // diagonals resist twist; other edges of a sheet give rows of three vertices, those of a mesh a hinge of their own
    const Real area = area_of(rest, &m.triangles[3 * e.triangle[0]]) + area_of(rest, &m.triangles[3 * e.triangle[1]]);
    if (m.grid && e.triangle[0] / 2 == e.triangle[1] / 2) {
      add_edge_hinge(m, rest, e, bend * size * size / (2 * area));
    } else if (m.grid && across(m, rest, e.triangle[0], e.a, e.b, near) &&
               across(m, rest, e.triangle[1], e.a, e.b, far)) {
      for (int k = 0; k < 2; ++k) {
        const std::uint32_t middle = k ? e.b : e.a;
        const Real cells = length(rest[near[k]] - rest[middle]) + length(rest[far[k]] - rest[middle]);
        rows.push_back({middle, {near[k], far[k]}, k ? e.a : e.b, bend * size / cells});  // size/2 over the mean cell
      }
    } else {
      add_edge_hinge(m, rest, e, bend * size * size / area);
    }
  }
  add_row_hinges(m, rest, rows);
}

// Width over depth of the cells of a sheet.
static double cell_aspect(const ClothMesh& m, std::span<const Vec3> rest) {
  double width = 0, depth = 0;
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Vec3 d = rest[m.triangles[(k + 1) % 3]] - rest[m.triangles[k]];
    width = std::fmax(width, std::fabs(double(d[0]))), depth = std::fmax(depth, std::fabs(double(d[2])));
  }
  FEDER_ASSERT(width > 0 && depth > 0);
  return width / depth;
}

void make_elements(ClothMesh& m, std::span<const Vec3> rest, const ClothStiffness& k) {
  const std::vector<Side> sides = sides_of(m.triangles);
  m.edges.clear(), m.links.clear();
  for (std::size_t i = 0; i < sides.size();) {
    ClothEdge e;
    e.a = sides[i].a, e.b = sides[i].b;
    int n = 0;
    for (; i < sides.size() && sides[i].a == e.a && sides[i].b == e.b; ++i, ++n)
      if (n < 2) e.triangle[n] = sides[i].triangle, e.opposite[n] = sides[i].opposite;
    FEDER_ASSERT(n <= 2 && e.a != e.b && e.b < rest.size());
    m.edges.push_back(e);
  }

  // rows of a sheet give up what its diagonals add: Young's modulus of the whole is `stretch` (square cells)
  const Real whole = Real(0.5) * (k.stretch + std::sqrt(k.stretch * k.stretch + 4 * k.shear * k.shear));
  const Real plain = m.grid ? whole - k.shear : k.stretch;
  RowStiffness woven{};
  if (m.grid && k.woven()) woven = row_stiffness(k, cell_aspect(m, rest));
  for (const ClothEdge& e : m.edges) {
    Real area = area_of(rest, &m.triangles[3 * e.triangle[0]]);
    if (e.triangle[1] != kNone) area += area_of(rest, &m.triangles[3 * e.triangle[1]]);
    const Real size = length(rest[e.b] - rest[e.a]);
    const bool diagonal = m.grid && e.triangle[1] != kNone && e.triangle[0] / 2 == e.triangle[1] / 2;
    Real rows = plain;
    if (k.woven() && !diagonal) {
      const Vec3 d = rest[e.b] - rest[e.a];
      rows = !m.grid ? thread_stiffness(k, d) : std::fabs(d[0]) > std::fabs(d[2]) ? woven.x : woven.z;
    }
    const Real stiffness = diagonal ? k.shear * size * size / (2 * area) : rows * area / (size * size);
    m.links.push_back({e.a, e.b, size, stiffness, diagonal});
  }
  // the second diagonal of each cell is a shear link that is no edge
  make_hinges(m, rest, k.bend);
  if (!m.grid) return;
  for (std::uint32_t c = 0; c < m.triangles.size() / 6; ++c) {
    std::uint32_t a = 0, b = 0;
    const std::uint32_t *s = &m.triangles[6 * c], *t = s + 3;
    if (!shares_edge(s, t, a, b)) continue;  // torn
    FEDER_ASSERT(a != b);                    // across the diagonal that is an edge
    const Real size = length(rest[b] - rest[a]), area = area_of(rest, s) + area_of(rest, t);
    m.links.push_back({std::min(a, b), std::max(a, b), size, k.shear * size * size / (2 * area), 1});
  }
}

}  // namespace feder
