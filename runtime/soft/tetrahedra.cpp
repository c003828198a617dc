// From a description to a mesh: tetrahedra are checked and turned, the skin is the faces that one of them has alone.
#include "soft/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "feder/error.h"
#include "geom/solid_mesh.h"
#include "soft/stability.h"

namespace feder {
namespace {

constexpr double kNoVolume = 1e-6;  // of the cube of the longest edge: a tetrahedron with less volume has none

struct SkinFace {
  std::array<std::uint32_t, 3> key;   // sorted
  std::array<std::uint32_t, 3> face;  // counter-clockwise seen from outside
  friend bool operator<(const SkinFace& a, const SkinFace& b) { return a.key < b.key; }
};

void list_faces(std::span<const TetrahedronPoints> tetrahedra, std::vector<SkinFace>& faces) {
  for (const TetrahedronPoints& t : tetrahedra)
    for (const auto& f : kTetrahedronFaces) {
      SkinFace s;
      for (std::size_t k = 0; k < 3; ++k) s.face[k] = t[static_cast<std::size_t>(f[k])];
      s.key = s.face;
      std::sort(s.key.begin(), s.key.end());
      faces.push_back(s);
    }
  std::sort(faces.begin(), faces.end());
}

std::string numbered(const char* what, std::size_t k) { return std::string(what) + "[" + std::to_string(k + 1) + "]"; }

void take_given(const SoftDesc& d, const std::string& owner, SoftMesh& m) {
  const std::size_t n = d.points.size();
  const auto refuse = [&](const std::string& text) { throw SceneError(owner + ": " + text); };
  if (n < 4) refuse("points: expected at least 4, got " + std::to_string(n));
  if (d.tetrahedra.empty() || d.tetrahedra.size() % 4 != 0)
    refuse("tetrahedra: expected four point numbers for each, at least one, got " +
           std::to_string(d.tetrahedra.size()) + " numbers");
  if (double(d.tetrahedra.size()) / 4 > kMaxSolidCells)
    refuse("tetrahedra: expected at most 1e7, got " + print_number(double(d.tetrahedra.size()) / 4));
  for (std::size_t i = 0; i < n; ++i)
    if (!is_finite(d.points[i])) refuse(numbered("points", i) + ": expected finite numbers");
  std::vector<bool> used(n, false);
  for (std::size_t k = 0; k < d.tetrahedra.size() / 4; ++k) {
    TetrahedronPoints t;
    Corners x;
    for (std::size_t c = 0; c < 4; ++c) {
      t[c] = d.tetrahedra[4 * k + c];
      if (t[c] >= n)
        refuse(numbered("tetrahedra", k) + ": expected point numbers from 1 to " + std::to_string(n) + ", got " +
               std::to_string(std::size_t(t[c]) + 1));
      used[t[c]] = true;
      x[c] = wide(d.points[t[c]]);
    }
    double volume = tetrahedron_volume(x);
    if (volume < 0) std::swap(t[2], t[3]), volume = -volume;
    const double edge = longest_edge(x);
    if (!(volume > kNoVolume * edge * edge * edge))
      refuse(numbered("tetrahedra", k) + ": expected four corners with a volume between them, got " +
             print_number(volume) + " m3");
    m.tetrahedra.push_back(t);
  }
  for (std::size_t i = 0; i < n; ++i)
    if (!used[i]) refuse(numbered("points", i) + ": expected a point of some tetrahedron, got one of none");
  m.rest.assign(d.points.begin(), d.points.end());
}

// Points of the skin come first, so that the others need not be shown.
void fill(const SoftDesc& d, const std::string& owner, SoftMesh& m) {
  SolidMesh solid;
  try {
    solid = fill_shape(*d.shape, d.resolution);
  } catch (const SceneError& e) {
    throw SceneError(owner + ": " + e.what());
  }
  std::vector<SkinFace> faces;
  list_faces(solid.tetrahedra, faces);
  std::vector<bool> outside(solid.points.size(), false);
  for (std::size_t k = 0; k < faces.size();) {
    std::size_t end = k + 1;
    while (end < faces.size() && faces[end].key == faces[k].key) ++end;
    if (end == k + 1)
      for (const std::uint32_t i : faces[k].key) outside[i] = true;
    k = end;
  }
  std::vector<std::uint32_t> number(solid.points.size());
  for (const bool skin : {true, false})
    for (std::size_t i = 0; i < solid.points.size(); ++i)
      if (outside[i] == skin) {
        number[i] = static_cast<std::uint32_t>(m.rest.size());
        m.rest.push_back(solid.points[i]);
      }
  for (const auto& t : solid.tetrahedra)
    m.tetrahedra.push_back({number[t[0]], number[t[1]], number[t[2]], number[t[3]]});
}

}  // namespace

void SoftMesh::derive() {
  skin.clear(), edges.clear(), volume.clear();
  rest_volume = mean_edge = 0, visible = 0;
  double area = 0;
  std::vector<SkinFace> faces;
  list_faces({tetrahedra.data(), tetrahedra.size()}, faces);
  for (std::size_t k = 0; k < faces.size();) {
    std::size_t end = k + 1;
    while (end < faces.size() && faces[end].key == faces[k].key) ++end;
    if (end == k + 1) {
      const auto& f = faces[k].face;
      for (const std::uint32_t i : f) skin.push_back(i), visible = std::max(visible, i + 1);
      const auto a = wide(rest[f[0]]);
      area += length(cross(wide(rest[f[1]]) - a, wide(rest[f[2]]) - a)) / 2;
      for (std::size_t c = 0; c < 3; ++c)
        edges.push_back({std::min(f[c], f[(c + 1) % 3]), std::max(f[c], f[(c + 1) % 3])});
    }
    k = end;
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& e : edges) mean_edge += length(wide(rest[e[0]]) - wide(rest[e[1]])) / double(edges.size());
  inverse.resize(9 * tetrahedra.size()), stiffening.assign(flowed.size() / 9, Real(1));
  for (std::size_t k = 0; k < tetrahedra.size(); ++k) {
    const double v = tetrahedron_volume(rest_corners(k));
    rest_volume += v;
    volume.push_back(static_cast<Real>(v));
    shape(k);
  }
  girth = area > 0 ? 2 * rest_volume / area : 0;
  find_parts();
}

// F = sum e g^T over edges e and gradients g; of the elastic part F P that is g' = P^T g.
void SoftMesh::shape(std::size_t k) {
  const Corners x = rest_corners(k);
  Corners g = barycentric_gradients(x);
  if (!flowed.empty()) {
    const double before = gradient_bound(g);
    const Real* p = &flowed[9 * k];  // by rows
    for (Double3& v : g)
      v = v.x * Double3{double(p[0]), double(p[1]), double(p[2])} +
          v.y * Double3{double(p[3]), double(p[4]), double(p[5])} +
          v.z * Double3{double(p[6]), double(p[7]), double(p[8])};
    stiffening[k] = static_cast<Real>(gradient_bound(g) / before);
  }
  for (std::size_t c = 1; c < 4; ++c) {
    Real* at = &inverse[9 * k + 3 * (c - 1)];
    at[0] = static_cast<Real>(g[c].x), at[1] = static_cast<Real>(g[c].y), at[2] = static_cast<Real>(g[c].z);
  }
}

void SoftMesh::find_parts() {
  const auto n = static_cast<std::uint32_t>(rest.size());
  part_of.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) part_of[i] = i;
  const auto root = [&](std::uint32_t i) {
    while (part_of[i] != i) i = part_of[i] = part_of[part_of[i]];
    return i;
  };
  for (const TetrahedronPoints& t : tetrahedra)
    for (std::size_t c = 1; c < 4; ++c) {
      const std::uint32_t a = root(t[0]), b = root(t[c]);
      part_of[std::max(a, b)] = std::min(a, b);
    }
  for (std::uint32_t i = 0; i < n; ++i) part_of[i] = root(i);
  part_first.clear();
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < n; ++i)  // a root comes first of its part
    part_of[i] = part_of[i] == i ? count++ : part_of[part_of[i]];
  part_first.assign(count + 1, 0), part_points.resize(n);
  for (const std::uint32_t p : part_of) ++part_first[p + 1];
  for (std::uint32_t p = 0; p < count; ++p) part_first[p + 1] += part_first[p];
  std::vector<std::uint32_t> at(part_first.begin(), part_first.end());
  for (std::uint32_t i = 0; i < n; ++i) part_points[at[part_of[i]]++] = i;
}

void make_tetrahedra(const SoftDesc& d, const std::string& owner, SoftMesh& m) {
  const bool given = !d.points.empty() || !d.tetrahedra.empty();
  if (given == (d.shape != nullptr))
    throw SceneError(owner + ": expected either points with tetrahedra or a shape, got " +
                     (given ? "both" : "neither"));
  given ? take_given(d, owner, m) : fill(d, owner, m);
  m.derive();
  // more than two tetrahedra on a face overlap
  std::vector<SkinFace> faces;
  list_faces({m.tetrahedra.data(), m.tetrahedra.size()}, faces);
  for (std::size_t k = 0; k + 2 < faces.size(); ++k)
    if (faces[k].key == faces[k + 2].key)
      throw SceneError(owner + ": tetrahedra: expected at most two on each face, got three on that of points " +
                       std::to_string(std::size_t(faces[k].key[0]) + 1) + ", " +
                       std::to_string(std::size_t(faces[k].key[1]) + 1) + " and " +
                       std::to_string(std::size_t(faces[k].key[2]) + 1));
}

}  // namespace feder
