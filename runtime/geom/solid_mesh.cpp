// Isosurface stuffing (Labelle and Shewchuk, "Isosurface Stuffing", SIGGRAPH 2007): a body-centred cubic lattice, of
// which points that lie close to the surface are moved onto it, and tetrahedra that the surface still cuts are cut by
// stencils. Faces that a cut leaves with four corners are split at the one of the lowest number, so both sides agree
// and no prism is without a split; the paper's parity rule would give a somewhat better worst angle. Weak spot: edges
// and corners of the shape are rounded by part of a cell, which is why boxes have a lattice of their own: five
// tetrahedra to a cell, mirrored from cell to cell.
#include "geom/solid_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <unordered_map>

#include "base/trig.h"
#include "feder/error.h"
#include "feder/params.h"
#include "geom/tetrahedron.h"
#include "geom/triangle_field.h"

namespace feder {

double smallest_dihedral(const Corners& x) {
  const Corners g = barycentric_gradients(x);  // along the inward normals of the faces
  double least = 4;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      least = std::fmin(least, arc_tangent2(length(cross(g[i], g[j])), -dot(g[i], g[j])));
  return least;
}

namespace {

using Four = std::array<std::uint32_t, 4>;
// Of a lattice point that a cut of the edge to it moves: shares of the edge's length (Labelle and Shewchuk, table 2).
constexpr double kWarpLong = 0.24999, kWarpShort = 0.41189;
constexpr double kOnSurface = 1e-9;  // of a cell: counts as on the surface
constexpr int kHalvings = 40;        // of an edge that is cut
constexpr double kFills = 1e-6;      // of its bounding box: a shape that leaves less of it is a box

void check_cells(double cells, const std::string& what) {
  if (!(cells <= kMaxSolidCells))
    throw SceneError("resolution: expected at most 1e7 cells in the box of the " + what + ", got " +
                     print_number(cells));
}

// The box from -half to half: whole cells along each side, five tetrahedra each.
SolidMesh fill_box(const Vec3& half, const std::array<std::uint32_t, 3>& n) {
  SolidMesh m;
  const auto at = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return (k * (n[1] + 1) + j) * (n[0] + 1) + i;
  };
  for (std::uint32_t k = 0; k <= n[2]; ++k)
    for (std::uint32_t j = 0; j <= n[1]; ++j)
      for (std::uint32_t i = 0; i <= n[0]; ++i) {
        const double share[3] = {double(i) / n[0], double(j) / n[1], double(k) / n[2]};
        Vec3 p;
        for (int d = 0; d < 3; ++d) p[d] = static_cast<Real>(double(half[d]) * (2 * share[d] - 1));
        m.points.push_back(p);
      }
  // corner q of a cell: bit 0 along x, 1 along y, 2 along z
  static constexpr int kEven[5][4] = {{0, 1, 2, 4}, {3, 1, 7, 2}, {5, 1, 4, 7}, {6, 2, 7, 4}, {1, 2, 4, 7}};
  for (std::uint32_t k = 0; k < n[2]; ++k)
    for (std::uint32_t j = 0; j < n[1]; ++j)
      for (std::uint32_t i = 0; i < n[0]; ++i)
        for (const auto& t : kEven) {
          const bool mirrored = ((i + j + k) & 1) != 0;
          Four v;
          for (std::size_t c = 0; c < 4; ++c) {
            const auto q = static_cast<std::uint32_t>(mirrored ? t[c] ^ 1 : t[c]);
            v[c] = at(i + (q & 1), j + (q >> 1 & 1), k + (q >> 2));
          }
          if (mirrored) std::swap(v[2], v[3]);
          m.tetrahedra.push_back(v);
        }
  return m;
}

class Stuffing {
 public:
  // depth(p): below the surface, m
  using Depth = std::function<double(const Vec3&)>;
  Stuffing(Depth depth, const Aabb& box, double cell, const std::array<std::int64_t, 3>& n)
      : depth_(std::move(depth)), cell_(cell), n_(n) {
    for (std::size_t d = 0; d < 3; ++d) {
      const int k = static_cast<int>(d);
      origin_[d] = 0.5 * (double(box.lo[k]) + double(box.hi[k])) - 0.5 * double(n[d]) * cell;
    }
  }

  SolidMesh run() {
    place_points();
    cut_edges();
    warp();
    std::int64_t c[3];
    // the four tetrahedra round each edge between the middles of two cells that share a face
    for (c[2] = 0; c[2] < n_[2]; ++c[2])
      for (c[1] = 0; c[1] < n_[1]; ++c[1])
        for (c[0] = 0; c[0] < n_[0]; ++c[0])
          for (int axis = 0; axis < 3; ++axis) {
            if (c[axis] + 1 >= n_[static_cast<std::size_t>(axis)]) continue;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            static constexpr int kRound[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
            std::uint32_t ring[5];
            for (int q = 0; q < 5; ++q) {
              std::int64_t p[3] = {c[0], c[1], c[2]};
              ++p[axis], p[u] += kRound[q][0], p[v] += kRound[q][1];
              ring[q] = corner(p[0], p[1], p[2]);
            }
            std::int64_t next[3] = {c[0], c[1], c[2]};
            ++next[axis];
            const std::uint32_t a = middle(c[0], c[1], c[2]), b = middle(next[0], next[1], next[2]);
            for (int q = 0; q < 4; ++q) fill({a, b, ring[q], ring[q + 1]});
          }
    return finish();
  }

 private:
  std::uint32_t corner(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::uint32_t>((k * (n_[1] + 1) + j) * (n_[0] + 1) + i);
  }
  std::uint32_t middle(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return first_middle_ + static_cast<std::uint32_t>((k * n_[1] + j) * n_[0] + i);
  }
  double depth(const Double3& p) const { return depth_(narrow(p)); }

  void place_points() {
    const auto add = [&](std::int64_t i, std::int64_t j, std::int64_t k, double half) {
      const Double3 p = {origin_[0] + cell_ * (double(i) + half), origin_[1] + cell_ * (double(j) + half),
                         origin_[2] + cell_ * (double(k) + half)};
      const double d = depth(p);
      points_.push_back(p);
      sign_.push_back(std::fabs(d) < kOnSurface * cell_ ? 0 : d > 0 ? 1 : -1);
    };
    for (std::int64_t k = 0; k <= n_[2]; ++k)
      for (std::int64_t j = 0; j <= n_[1]; ++j)
        for (std::int64_t i = 0; i <= n_[0]; ++i) add(i, j, k, 0);
    first_middle_ = static_cast<std::uint32_t>(points_.size());
    for (std::int64_t k = 0; k < n_[2]; ++k)
      for (std::int64_t j = 0; j < n_[1]; ++j)
        for (std::int64_t i = 0; i < n_[0]; ++i) add(i, j, k, 0.5);
  }

  struct Cut {
    std::uint32_t a, b;  // ends, a < b
    Double3 at;
    double share;  // of the edge, from a
    bool is_long;
  };
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t(std::min(a, b)) << 32 | std::max(a, b);
  }

  void add_cut(std::uint32_t a, std::uint32_t b, bool is_long) {
    if (a > b) std::swap(a, b);
    if (sign_[a] * sign_[b] >= 0) return;
    double lo = 0, hi = 1;
    const Double3 e = points_[b] - points_[a];
    for (int k = 0; k < kHalvings; ++k) {
      const double mid = 0.5 * (lo + hi);
      (depth(points_[a] + mid * e) > 0) == (sign_[a] > 0) ? lo = mid : hi = mid;
    }
    const double share = 0.5 * (lo + hi);
    cuts_.push_back({a, b, points_[a] + share * e, share, is_long});
  }

  void cut_edges() {
    for (std::int64_t k = 0; k <= n_[2]; ++k)
      for (std::int64_t j = 0; j <= n_[1]; ++j)
        for (std::int64_t i = 0; i <= n_[0]; ++i) {
          if (i < n_[0]) add_cut(corner(i, j, k), corner(i + 1, j, k), true);
          if (j < n_[1]) add_cut(corner(i, j, k), corner(i, j + 1, k), true);
          if (k < n_[2]) add_cut(corner(i, j, k), corner(i, j, k + 1), true);
        }
    for (std::int64_t k = 0; k < n_[2]; ++k)
      for (std::int64_t j = 0; j < n_[1]; ++j)
        for (std::int64_t i = 0; i < n_[0]; ++i) {
          const std::uint32_t m = middle(i, j, k);
          if (i + 1 < n_[0]) add_cut(m, middle(i + 1, j, k), true);
          if (j + 1 < n_[1]) add_cut(m, middle(i, j + 1, k), true);
          if (k + 1 < n_[2]) add_cut(m, middle(i, j, k + 1), true);
          for (int q = 0; q < 8; ++q) add_cut(m, corner(i + (q & 1), j + (q >> 1 & 1), k + (q >> 2)), false);
        }
  }

  // Points go to the nearest cut that is too close; the cuts of their edges are then gone.
  void warp() {
    std::vector<std::vector<std::uint32_t>> of(points_.size());
    for (std::uint32_t c = 0; c < cuts_.size(); ++c) of[cuts_[c].a].push_back(c), of[cuts_[c].b].push_back(c);
    for (std::uint32_t p = 0; p < of.size(); ++p) {
      if (sign_[p] == 0) continue;
      double nearest = double(kInfinity);
      Double3 to = points_[p];
      for (const std::uint32_t c : of[p]) {
        const Cut& cut = cuts_[c];
        const std::uint32_t other = cut.a == p ? cut.b : cut.a;
        if (sign_[other] == 0) continue;
        const double share = cut.a == p ? cut.share : 1 - cut.share;
        if (share >= (cut.is_long ? kWarpLong : kWarpShort)) continue;
        const double distance = share * (cut.is_long ? 1 : std::sqrt(0.75));
        if (distance < nearest) nearest = distance, to = cut.at;
      }
      if (nearest < double(kInfinity)) sign_[p] = 0, points_[p] = to;
    }
    for (const Cut& c : cuts_) {
      if (sign_[c.a] * sign_[c.b] >= 0) continue;
      cut_point_[key(c.a, c.b)] = static_cast<std::uint32_t>(points_.size());
      points_.push_back(c.at);
    }
  }

  void put(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    Four t = {a, b, c, d};
    const double volume = tetrahedron_volume({points_[a], points_[b], points_[c], points_[d]});
    if (volume < 0) std::swap(t[2], t[3]);
    tetrahedra_.push_back(t);
  }

  // The part of a lattice tetrahedron that is within.
  void fill(const Four& t) {
    std::uint32_t in[4], on[4], out[4];
    int ins = 0, ons = 0, outs = 0;
    for (const std::uint32_t v : t) (sign_[v] > 0 ? in[ins++] : sign_[v] < 0 ? out[outs++] : on[ons++]) = v;
    if (ins == 0) return;
    if (outs == 0) return put(t[0], t[1], t[2], t[3]);
    std::sort(in, in + ins), std::sort(out, out + outs);
    const auto cut = [&](std::uint32_t a, std::uint32_t b) {
      const auto found = cut_point_.find(key(a, b));
      FEDER_ASSERT(found != cut_point_.end());
      return found->second;
    };
    if (ins == 1) {
      std::uint32_t far[3];
      int k = 0;
      for (int i = 0; i < outs; ++i) far[k++] = cut(in[0], out[i]);
      for (int i = 0; i < ons; ++i) far[k++] = on[i];
      return put(in[0], far[0], far[1], far[2]);
    }
    if (ins == 2 && outs == 1) {
      const std::uint32_t a = cut(in[0], out[0]), b = cut(in[1], out[0]);
      put(on[0], in[0], in[1], b), put(on[0], in[0], b, a);
      return;
    }
    if (ins == 2) {
      const std::uint32_t a0 = cut(in[0], out[0]), a1 = cut(in[0], out[1]), b0 = cut(in[1], out[0]),
                          b1 = cut(in[1], out[1]);
      put(in[0], in[1], b0, b1), put(in[0], a0, b0, b1), put(in[0], a0, a1, b1);
      return;
    }
    const std::uint32_t a = cut(in[0], out[0]), b = cut(in[1], out[0]), c = cut(in[2], out[0]);
    put(in[0], a, b, c), put(in[0], in[1], b, c), put(in[0], in[1], in[2], c);
  }

  // The points that are used, in the order of their numbers.
  SolidMesh finish() const {
    SolidMesh m;
    std::vector<std::uint32_t> number(points_.size(), kNone);
    for (const Four& t : tetrahedra_)
      for (const std::uint32_t v : t) number[v] = 0;
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (number[v] == kNone) continue;
      number[v] = static_cast<std::uint32_t>(m.points.size());
      m.points.push_back(narrow(points_[v]));
    }
    for (const Four& t : tetrahedra_) m.tetrahedra.push_back({number[t[0]], number[t[1]], number[t[2]], number[t[3]]});
    return m;
  }

  Depth depth_;
  double cell_;
  std::array<std::int64_t, 3> n_;
  double origin_[3];
  std::uint32_t first_middle_ = 0;
  std::vector<Double3> points_;  // the lattice, then cuts
  std::vector<int> sign_;        // 1 within, 0 on the surface, -1 outside
  std::vector<Cut> cuts_;
  std::unordered_map<std::uint64_t, std::uint32_t> cut_point_;  // looked up, never walked
  std::vector<Four> tetrahedra_;
};

// The triangles of a mesh, which has no inside of its own; empty for a solid.
std::vector<Vec3> corners_of_mesh(const Shape& shape, double volume) {
  if (volume > 0 || shape.convex()) return {};
  const ShapeArguments made = shape.arguments();
  std::vector<Vec3> corners;
  for (const std::uint32_t i : made.triangles) corners.push_back(made.points[i]);
  return corners;
}

}  // namespace

SolidMesh fill_shape(const Shape& shape, std::uint32_t resolution) {
  const Aabb box = shape.bounds(Pose{});
  const Vec3 size = box.hi - box.lo;
  const std::string kind = shape.kind();
  if (shape.planar() || !is_finite(size)) throw SceneError("shape: expected a solid of finite size, got a " + kind);
  if (resolution < 1) throw SceneError("resolution: expected at least 1, got 0");
  const double longest = double(size.maxCoeff()), cell = longest / resolution;
  std::array<std::uint32_t, 3> whole;
  std::array<std::int64_t, 3> n;
  double cells = 1, around = 1;
  for (std::size_t d = 0; d < 3; ++d) {
    const double length = double(size[static_cast<int>(d)]), side = std::fmax(1, std::round(length / cell));
    cells *= side, around *= length;
    whole[d] = static_cast<std::uint32_t>(std::fmin(side, kMaxSolidCells));
    n[d] = static_cast<std::int64_t>(std::fmin(std::ceil(length / cell - 1e-6) + 2, kMaxSolidCells));
  }
  check_cells(cells, kind);
  double volume = double(shape.mass(1).mass);
  std::vector<Vec3> corners = corners_of_mesh(shape, volume);
  Stuffing::Depth depth = [&](const Vec3& p) {
    Vec3 normal;
    return -double(shape.distance(p, static_cast<Real>(2 * cell), normal));
  };
  std::optional<TriangleField> field;
  if (!corners.empty()) {
    field.emplace(corners);
    if (field->volume() < 0) {  // inside out
      for (std::size_t k = 0; k < corners.size(); k += 3) std::swap(corners[k], corners[k + 1]);
      field.emplace(corners);
    }
    if (field->open_edges() > 0)
      throw SceneError("shape: expected a closed mesh, got one with " + std::to_string(field->open_edges()) +
                       " open edges round " + print_number(field->open_area()) + " m2");
    volume = field->volume();
    depth = [&field](const Vec3& p) { return -double(field->signed_distance(p)); };
  }
  if (!(volume > 0)) throw SceneError("shape: expected a solid with a volume, got a " + kind);
  if (volume > (1 - kFills) * around) {
    SolidMesh m = fill_box(Vec3(size / 2), whole);
    const Vec3 middle = Real(0.5) * (box.lo + box.hi);
    for (Vec3& p : m.points) p += middle;
    return m;
  }
  SolidMesh m = Stuffing(depth, box, cell, n).run();
  if (m.tetrahedra.empty())
    throw SceneError("resolution: expected cells that fit into the " + kind + ", got " + std::to_string(resolution) +
                     " along its longest side");
  return m;
}

}  // namespace feder
