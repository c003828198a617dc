// Quickhull (Barber, Dobkin and Huhdanpaa 1996) in double: a tetrahedron of far points grows by the farthest point
// outside any face, replacing the faces that see it. Then triangles in one plane merge into polygons, and corners on
// their edges or inside them go. Corners nearer than kThin of the size to a face are not outside; faces merge within
// kFlat. Weak spot: points spread evenly on a sphere are all corners, and more than kMaxHullCorners are refused.
#include "bounds/quickhull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/double3.h"
#include "feder/error.h"

namespace feder {
namespace {

constexpr double kThin = 1e-6;          // of the size of the cloud
constexpr double kFlat = 2e-5;          // of the size: triangles this near to a plane are one face
constexpr double kMinThickness = 1e-4;  // of the size: flatter clouds are refused
constexpr std::size_t kMaxPoints = 100000;
constexpr int kMaxWorkingCorners = 1024;

struct Face {
  int v[3], next[3];  // next[i]: across the edge v[i], v[i + 1]
  Double3 normal;
  double offset, area;
  bool alive = true;
  std::vector<int> outside;  // points above it that no earlier face has taken
  int farthest = -1;
  double height = 0;

  int edge_from(int vertex) const { return v[0] == vertex ? 0 : (v[1] == vertex ? 1 : 2); }
};

class Builder {
 public:
  explicit Builder(std::span<const Vec3> cloud) {
    for (const Vec3& p : cloud) points_.push_back(wide(p));
  }

  void run() {
    start();
    int corners = 4;
    for (int f = highest(); f >= 0; f = highest()) {
      if (++corners > kMaxWorkingCorners)
        throw SceneError("hull: expected points with at most " + std::to_string(kMaxHullCorners) +
                         " corners in their convex hull, got more than " + std::to_string(corners - 1));
      grow(f, faces_[f].farthest);
    }
  }

  HullData polygons(std::span<const Vec3> cloud);

 private:
  double height(const Face& f, int p) const { return dot(f.normal, points_[p]) - f.offset; }

  int add_face(int a, int b, int c) {
    Face f;
    f.v[0] = a, f.v[1] = b, f.v[2] = c;
    f.next[0] = f.next[1] = f.next[2] = -1;
    const Double3 n = cross(points_[b] - points_[a], points_[c] - points_[a]);
    f.area = length(n);
    f.normal = (f.area > 0 ? 1 / f.area : 0) * n;
    f.offset = dot(f.normal, points_[a]);
    faces_.push_back(std::move(f));
    return static_cast<int>(faces_.size()) - 1;
  }

  void assign(int p, int first_face) {
    int best = -1;
    double most = kThin * size_;
    for (int f = first_face; f < static_cast<int>(faces_.size()); ++f) {
      if (!faces_[f].alive) continue;
      const double h = height(faces_[f], p);
      if (h > most) most = h, best = f;
    }
    if (best < 0) return;
    Face& face = faces_[best];
    face.outside.push_back(p);
    if (most > face.height) face.height = most, face.farthest = p;
  }

  int highest() const {
    int best = -1;
    for (int f = 0; f < static_cast<int>(faces_.size()); ++f)
      if (faces_[f].alive && faces_[f].farthest >= 0 && (best < 0 || faces_[f].height > faces_[best].height)) best = f;
    return best;
  }

  void start();
  void grow(int seed, int p);
  void remove_visible(int f, int entered, int p, std::vector<std::array<int, 3>>& rim, std::vector<int>& seen);
  std::vector<int> merge() const;

  std::vector<Double3> points_;
  std::vector<Face> faces_;
  double size_ = 0;
};

// Four points far apart: the extremes of an axis, the farthest from their line, the farthest from that plane.
void Builder::start() {
  int lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0};
  const auto coordinate = [](const Double3& p, int axis) { return axis == 0 ? p.x : (axis == 1 ? p.y : p.z); };
  const int n = static_cast<int>(points_.size());
  int axis = 0;
  for (int k = 0; k < 3; ++k) {
    for (int i = 1; i < n; ++i) {
      if (coordinate(points_[i], k) < coordinate(points_[lo[k]], k)) lo[k] = i;
      if (coordinate(points_[i], k) > coordinate(points_[hi[k]], k)) hi[k] = i;
    }
    const double extent = coordinate(points_[hi[k]], k) - coordinate(points_[lo[k]], k);
    if (extent > size_) size_ = extent, axis = k;
  }
  if (!(size_ > 0)) throw SceneError("hull: all points are the same");
  const int a = lo[axis], b = hi[axis];
  int c = a, d = a;
  double most = 0;
  for (int i = 0; i < n; ++i) {
    const double h = length(cross(points_[i] - points_[a], points_[b] - points_[a])) / size_;
    if (h > most) most = h, c = i;
  }
  if (!(most > kMinThickness * size_))
    throw SceneError("hull: the points lie on a line; expected a body with a volume");
  const Double3 m = cross(points_[b] - points_[a], points_[c] - points_[a]);
  double side = 0;
  for (int i = 0; i < n; ++i) {
    const double h = dot(m, points_[i] - points_[a]) / length(m);
    if (std::abs(h) > std::abs(side)) side = h, d = i;
  }
  if (!(std::abs(side) > kMinThickness * size_))
    throw SceneError("hull: the points lie in a plane; expected a body with a volume");
  const int v[4] = {a, side > 0 ? c : b, side > 0 ? b : c, d};
  constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  constexpr int kNext[4][3] = {{1, 3, 2}, {2, 3, 0}, {0, 3, 1}, {1, 2, 0}};
  for (const auto& f : kFaces) add_face(v[f[0]], v[f[1]], v[f[2]]);
  for (int f = 0; f < 4; ++f)
    for (int e = 0; e < 3; ++e) faces_[f].next[e] = kNext[f][e];
  for (int i = 0; i < n; ++i) assign(i, 0);
}

// Collects the connected faces that see p, and their rim in order.
void Builder::remove_visible(int f, int entered, int p, std::vector<std::array<int, 3>>& rim, std::vector<int>& seen) {
  faces_[f].alive = false;
  seen.push_back(f);
  for (int k = 0; k < 3; ++k) {
    const int e = (entered + k) % 3, from = faces_[f].v[e], to = faces_[f].v[(e + 1) % 3], g = faces_[f].next[e];
    if (!faces_[g].alive) continue;
    if (height(faces_[g], p) > 0)
      remove_visible(g, faces_[g].edge_from(to), p, rim, seen);
    else
      rim.push_back({from, to, g});
  }
}

void Builder::grow(int seed, int p) {
  std::vector<std::array<int, 3>> rim;
  std::vector<int> seen;
  remove_visible(seed, 0, p, rim, seen);
  const int first = static_cast<int>(faces_.size()), count = static_cast<int>(rim.size());
  for (const auto& [from, to, outer] : rim) {
    const int f = add_face(from, to, p);
    faces_[f].next[0] = outer;
    faces_[outer].next[faces_[outer].edge_from(to)] = f;
  }
  for (int i = 0; i < count; ++i) {
    faces_[first + i].next[1] = first + (i + 1) % count;
    faces_[first + i].next[2] = first + (i + count - 1) % count;
  }
  for (const int f : seen) {
    for (const int q : faces_[f].outside)
      if (q != p) assign(q, first);
    faces_[f].outside.clear();
  }
}

// The group of each face: largest triangles first, each takes the neighbours that lie in its plane.
std::vector<int> Builder::merge() const {
  std::vector<int> group(faces_.size(), -1), order;
  for (int f = 0; f < static_cast<int>(faces_.size()); ++f)
    if (faces_[f].alive) order.push_back(f);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return faces_[a].area > faces_[b].area; });
  for (const int seed : order) {
    if (group[seed] >= 0) continue;
    std::vector<int> stack{seed};
    group[seed] = seed;
    while (!stack.empty()) {
      const int f = stack.back();
      stack.pop_back();
      for (const int g : faces_[f].next) {
        if (group[g] >= 0) continue;
        bool flat = dot(faces_[g].normal, faces_[seed].normal) > 0.5 || faces_[g].area < kThin * size_ * size_;
        for (const int v : faces_[g].v) flat = flat && std::abs(height(faces_[seed], v)) <= kFlat * size_;
        if (flat) group[g] = seed, stack.push_back(g);
      }
    }
  }
  return group;
}

HullData Builder::polygons(std::span<const Vec3> cloud) {
  const std::vector<int> group = merge();
  // a corner of the hull touches three groups or more
  std::vector<std::vector<int>> groups_at(points_.size());
  for (int f = 0; f < static_cast<int>(faces_.size()); ++f) {
    if (!faces_[f].alive) continue;
    for (const int v : faces_[f].v)
      if (std::find(groups_at[v].begin(), groups_at[v].end(), group[f]) == groups_at[v].end())
        groups_at[v].push_back(group[f]);
  }
  HullData hull;
  std::vector<int> number(points_.size(), -1);
  for (std::size_t v = 0; v < points_.size(); ++v) {
    if (groups_at[v].size() < 3) continue;
    number[v] = static_cast<int>(hull.corners.size());
    hull.corners.push_back(cloud[v]);
  }
  if (hull.corners.size() > kMaxHullCorners)
    throw SceneError("hull: expected points with at most " + std::to_string(kMaxHullCorners) +
                     " corners in their convex hull, got " + std::to_string(hull.corners.size()));
  for (int seed = 0; seed < static_cast<int>(faces_.size()); ++seed) {
    if (!faces_[seed].alive || group[seed] != seed) continue;
    // walk along the rim of the group: from an edge to the next one around its end
    int f = -1, e = 0;
    for (int g = 0; g < static_cast<int>(faces_.size()) && f < 0; ++g)
      for (int k = 0; k < 3 && f < 0; ++k)
        if (faces_[g].alive && group[g] == seed && group[faces_[g].next[k]] != seed) f = g, e = k;
    if (f < 0) continue;
    HullFace face;
    face.first = static_cast<std::uint16_t>(hull.loops.size());
    const int first_face = f, first_edge = e;
    std::size_t steps = 0;
    do {
      const int corner = number[faces_[f].v[e]];
      if (corner >= 0) hull.loops.push_back(static_cast<std::uint16_t>(corner));
      e = (e + 1) % 3;
      while (group[faces_[f].next[e]] == seed && ++steps < 10 * faces_.size()) {
        const int g = faces_[f].next[e];
        e = faces_[g].edge_from(faces_[f].v[e]);
        f = g;
      }
    } while ((f != first_face || e != first_edge) && ++steps < 10 * faces_.size());
    face.count = static_cast<std::uint16_t>(hull.loops.size() - face.first);
    if (face.count < 3) {
      hull.loops.resize(face.first);
      continue;
    }
    hull.faces.push_back(face);
  }
  return hull;
}

// Planes of the merged faces: Newell's normal, and far enough out to hold all corners of the face.
void set_planes(HullData& hull) {
  for (HullFace& f : hull.faces) {
    const Vec3& origin = hull.corner(f, 0);
    Vec3 n = Vec3::Zero();
    for (int i = 2; i < f.count; ++i) n += cross(hull.corner(f, i - 1) - origin, hull.corner(f, i) - origin);
    f.normal = normalized_or(n, Vec3::Zero());
    f.offset = -kInfinity;
    for (int i = 0; i < f.count; ++i) f.offset = std::max(f.offset, dot(f.normal, hull.corner(f, i)));
  }
}

}  // namespace

HullData build_hull(std::span<const Vec3> cloud) {
  if (cloud.size() < 4) throw SceneError("hull: expected at least 4 points, got " + std::to_string(cloud.size()));
  if (cloud.size() > kMaxPoints)
    throw SceneError("hull: expected at most " + std::to_string(kMaxPoints) + " points, got " +
                     std::to_string(cloud.size()));
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (!is_finite(cloud[i]))
      throw SceneError("hull: expected finite points, but point " + std::to_string(i + 1) + " is not");
  Builder builder(cloud);
  builder.run();
  HullData hull = builder.polygons(cloud);
  set_planes(hull);
  if (hull.faces.size() < 4) throw SceneError("hull: the points are too flat; expected a body with a volume");
  return hull;
}

}  // namespace feder
