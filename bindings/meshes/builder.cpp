// Polygons by ear clipping (Meisters 1975: every simple polygon has two ears), in the plane of their mean normal
// (Newell; Sutherland, Sproull and Schumacker 1974). Weak spot: a polygon that crosses itself, or of area 0, has no
// inside and becomes a fan; n corners take n^3 steps at worst, so one of more than kMaxClipped becomes a fan too.
#include "meshes/builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "feder/error.h"

namespace feder::meshes {
namespace {

constexpr std::size_t kMaxClipped = 300;

using Point2 = std::array<double, 2>;

// > 0: a, b, c turn left.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

bool in_triangle(const Point2& p, const Point2& a, const Point2& b, const Point2& c) {
  return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

// The points without the axis along which the normal is longest, so that the polygon turns left; empty without area.
std::vector<Point2> project(std::span<const Vec3> points) {
  std::array<double, 3> normal = {0, 0, 0};
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 &p = points[i], &q = points[(i + 1) % n], &o = points[0];
    for (int k = 0; k < 3; ++k) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      normal[static_cast<std::size_t>(k)] += (double(p[u]) - double(o[u])) * (double(q[v]) - double(o[v])) -
                                             (double(p[v]) - double(o[v])) * (double(q[u]) - double(o[u]));
    }
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  if (!(std::abs(normal[axis]) > 0)) return {};
  int u = static_cast<int>(axis + 1) % 3, v = static_cast<int>(axis + 2) % 3;
  if (normal[axis] < 0) std::swap(u, v);
  std::vector<Point2> flat;
  for (const Vec3& p : points) flat.push_back({double(p[u]), double(p[v])});
  return flat;
}

// Is corner i of the remaining ones an ear: convex, and no other corner within its triangle?
bool is_ear(const std::vector<Point2>& flat, const std::vector<std::size_t>& left, std::size_t i) {
  const std::size_t n = left.size();
  const Point2 &a = flat[left[(i + n - 1) % n]], &b = flat[left[i]], &c = flat[left[(i + 1) % n]];
  if (!(turn(a, b, c) > 0)) return false;
  return std::ranges::none_of(left, [&](std::size_t k) {
    const Point2& p = flat[k];
    return p != a && p != b && p != c && in_triangle(p, a, b, c);
  });
}

}  // namespace

void fail_file(const lua::MeshFile& file, const std::string& message, std::size_t line) {
  throw SceneError(file.name + (line > 0 ? ":" + std::to_string(line) : "") + ": " + message);
}

void Builder::add_vertex(const Vec3& at) {
  if (mesh_.vertices.size() == kMaxMeshVertices)
    fail_file(file_, "expected at most " + std::to_string(kMaxMeshVertices) + " vertices");
  mesh_.vertices.push_back(at);
}

void Builder::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  FEDER_ASSERT(std::max({a, b, c}) < vertex_count());
  if (a == b || b == c || c == a) return;
  if (mesh_.triangles.size() == 3 * kMaxMeshTriangles)
    fail_file(file_, "expected at most " + std::to_string(kMaxMeshTriangles) + " triangles");
  for (const std::uint32_t v : {a, b, c}) mesh_.triangles.push_back(v);
}

void Builder::add_polygon(std::span<const std::uint32_t> corners) {
  std::vector<Vec3> points;
  for (const std::uint32_t c : corners) points.push_back(mesh_.vertices[c]);
  std::vector<std::size_t> left(corners.size());
  std::iota(left.begin(), left.end(), std::size_t(0));
  if (corners.size() > 3 && corners.size() <= kMaxClipped) {
    const std::vector<Point2> flat = project(points);
    // the search goes on behind the last ear, so that a convex polygon is not cut into one thin fan
    std::size_t at = 0;
    while (!flat.empty() && left.size() > 3) {
      std::size_t tried = 0;
      while (tried < left.size() && !is_ear(flat, left, at % left.size())) ++at, ++tried;
      if (tried == left.size()) break;
      const std::size_t n = left.size(), i = at % n;
      add_triangle(corners[left[(i + n - 1) % n]], corners[left[i]], corners[left[(i + 1) % n]]);
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      at = i + 1;
    }
  }
  for (std::size_t i = 1; i + 1 < left.size(); ++i)
    add_triangle(corners[left[0]], corners[left[i]], corners[left[i + 1]]);
}

// Vertices by their coordinates, equal ones by their number: each stands for those behind it, in the order of the file.
void Builder::weld() {
  const auto& v = mesh_.vertices;
  std::vector<std::uint32_t> order(v.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&v](std::uint32_t a, std::uint32_t b) {
    for (int k = 0; k < 3; ++k)
      if (v[a][k] != v[b][k]) return v[a][k] < v[b][k];
    return a < b;
  };
  std::sort(order.begin(), order.end(), before);
  std::vector<std::uint32_t> first(v.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && v[order[i]] == v[order[i - 1]] ? first[order[i - 1]] : order[i];
  // triangles on the first ones; those with fewer than three go
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> number(v.size(), 0);
  for (std::size_t t = 0; t + 2 < mesh_.triangles.size(); t += 3) {
    const std::uint32_t a = first[mesh_.triangles[t]], b = first[mesh_.triangles[t + 1]],
                        c = first[mesh_.triangles[t + 2]];
    if (a == b || b == c || c == a) continue;
    for (const std::uint32_t x : {a, b, c}) triangles.push_back(x), number[x] = 1;
  }
  // the vertices that are left, in their order
  std::vector<Vec3> vertices;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == 0) continue;
    number[i] = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(v[i]);
  }
  for (std::uint32_t& x : triangles) x = number[x];
  mesh_.vertices = std::move(vertices), mesh_.triangles = std::move(triangles);
}

lua::TriangleMesh Builder::finish() {
  if (file_.weld) weld();
  if (mesh_.triangles.empty()) fail_file(file_, "expected triangles, got none");
  return std::move(mesh_);
}

}  // namespace feder::meshes
