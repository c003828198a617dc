// Triangle mesh: static, a surface without inside. A hierarchy of boxes (triangles are stored in its order, so visits
// are ascending) or another index (mesh_index.h), and per edge what the neighbour does, so that contacts do not catch
// on seams. Corners at the same place are one corner; triangles without area are dropped. Source of rays: Moeller and
// Trumbore 1997. Weak spot: no inside, so what has passed the surface is on its other side; a body with a mass has the
// distance field of its triangles instead (solid).
#include <algorithm>
#include <mutex>
#include <numeric>
#include <tuple>

#include "base/borrowed_list.h"
#include "bounds/box_tree.h"
#include "bounds/volume.h"
#include "feder/error.h"
#include "feder/params.h"
#include "feder/sdf.h"
#include "geom/closest.h"
#include "geom/mesh_index.h"
#include "geom/surfaces.h"

namespace feder {
namespace {

constexpr Real kFlatSine = Real(0.01);  // edges bent by less than 0.6 degrees count as flat
constexpr Real kNoArea = Real(1e-10);   // of the longest side squared: such triangles are dropped

struct Corners {
  std::uint32_t v[3];
};

// Surfaces of triangles: both lists are empty where none is stated.
struct TriangleSurfaces {
  std::vector<ShapeSurface> list;
  std::vector<SurfaceNumber> of;  // by triangle
};

void sort_once(std::vector<std::uint32_t>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

Vec3 normal_of(const Triangle& t) { return normalized_or(cross(t.b - t.a, t.c - t.a), Vec3::Zero()); }

bool ray_meets(const Aabb& box, const Vec3& o, const Vec3& d, Real limit) {
  Real enter = 0, leave = limit;
  for (int i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (o[i] < box.lo[i] || o[i] > box.hi[i]) return false;
      continue;
    }
    const Real t0 = (box.lo[i] - o[i]) / d[i], t1 = (box.hi[i] - o[i]) / d[i];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  // the slack keeps rays along an edge between two boxes
  return enter <= leave + Real(1e-5) * (1 + std::abs(leave));
}

class Mesh final : public Shape {
 public:
  Mesh(std::vector<Vec3> vertices, std::vector<Corners> triangles, TriangleSurfaces surfaces, const MeshIndex& choice);

  Aabb bounds(const Pose& pose) const override {
    Aabb box;
    for (const Vec3& v : vertices_) box.include(to_world(pose, v));
    return box;
  }
  MassProperties mass(Real) const override { return {}; }
  Real extent(const Vec3& center) const override {
    Real far = 0;
    for (const Vec3& v : vertices_) far = std::max(far, length(v - center));
    return far;
  }
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override;
  ShapeArguments arguments() const override;
  void triangles_in(const Aabb& local, void (*visit)(void*, std::uint32_t), void* context) const override;
  const Triangle& triangle(std::uint32_t i) const override { return triangles_[i]; }
  std::span<const ShapeSurface> surfaces() const override { return surfaces_; }
  std::string describe() const override;
  ShapePtr solid(const MakeSdf& make) const override;
  bool volumes_at(int level, bool (*edge)(void*, const Vec3&, const Vec3&), void* context) const override;
  bool back_to_front(const Vec3& eye, void (*visit)(void*, std::uint32_t, std::span<const Vec3>),
                     void* context) const override;

 private:
  void find_neighbors(std::span<const Corners> corners);
  void make_index();
  template <class F>
  void each_along(const Vec3& origin, const Vec3& ray, const Real& best, F&& visit) const;

  std::vector<Vec3> vertices_;
  std::vector<std::uint32_t> given_;  // by triangle: which it was of those given
  std::vector<Triangle> triangles_;   // in the order of the hierarchy's leaves; contacts read one at once
  std::vector<ShapeSurface> surfaces_;
  Arena arena_{"mesh"};
  BoxTree tree_{arena_};  // of the boxes of the triangles; empty where another index is chosen
  MeshIndex choice_;
  std::unique_ptr<TriangleIndex> index_;  // that one
  mutable std::mutex solid_mutex_;
  mutable ShapePtr solid_;  // when it was asked for
};

Mesh::Mesh(std::vector<Vec3> vertices, std::vector<Corners> triangles, TriangleSurfaces surfaces,
           const MeshIndex& choice)
    : Shape("mesh", false), vertices_(std::move(vertices)), surfaces_(std::move(surfaces.list)), choice_(choice) {
  std::vector<Aabb> boxes;
  boxes.reserve(triangles.size());
  for (const Corners& c : triangles) {
    Aabb& box = boxes.emplace_back();
    for (const std::uint32_t v : c.v) box.include(vertices_[v]);
  }
  tree_.build(boxes);
  given_.assign(tree_.order().begin(), tree_.order().end());
  std::vector<Corners> corners;  // in that order
  corners.reserve(given_.size()), triangles_.reserve(given_.size());
  for (const std::uint32_t i : given_) {
    const Corners& c = triangles[i];
    corners.push_back(c);
    const SurfaceNumber surface = surfaces.of.empty() ? SurfaceNumber(0) : surfaces.of[i];
    triangles_.push_back({vertices_[c.v[0]], vertices_[c.v[1]], vertices_[c.v[2]], 0, surface, {-1, -1, -1}});
  }
  tree_.number_in_order();
  find_neighbors(corners);
  if (choice_.chosen()) make_index();
}

// Triangles keep the order of the boxes' hierarchy, so contacts come in the same order with any index.
void Mesh::make_index() {
  std::vector<Vec3> corners;
  corners.reserve(3 * triangles_.size());
  for (const Triangle& t : triangles_) corners.insert(corners.end(), {t.a, t.b, t.c});
  index_ = find_variant(triangle_indexes(), choice_.index.empty() ? "bvh" : choice_.index, "mesh index")
               .make(corners, choice_);
  tree_.build({});
}

ShapePtr Mesh::solid(const MakeSdf& make) const {
  if (std::none_of(shape_kinds().begin(), shape_kinds().end(), [](const ShapeKind& k) { return k.fields; }))
    return nullptr;
  const std::lock_guard lock(solid_mutex_);
  if (!solid_) {
    const ShapeArguments own = arguments();
    const SdfDesc inside{.vertices = own.points, .triangles = own.triangles};
    solid_ = make ? make(inside) : make_sdf(inside);
  }
  return solid_;
}

std::string Mesh::describe() const {
  const auto number = [](std::size_t n) { return std::to_string(n); };
  std::string text = choice_.index.empty() ? "bvh" : choice_.index;
  if (text == "bvh")
    text += " of " + (choice_.volume.empty() ? std::string("aabb") : choice_.volume) + ", " +
            (choice_.build.empty() ? std::string("top_down") : choice_.build);
  if (choice_.leaf > 0) text += ", leaf " + number(choice_.leaf);
  return text + ", " + number(triangles_.size()) + (triangles_.size() == 1 ? " triangle" : " triangles") +
         (index_ ? ", " + number((index_->bytes() + 1023) / 1024) + " KiB" : "");
}

bool Mesh::volumes_at(int level, bool (*edge)(void*, const Vec3&, const Vec3&), void* context) const {
  const EdgeVisitor visit{edge, context};
  if (index_) return index_->volumes_at(level, visit);
  return tree_.boxes_at(level, [&](const Aabb& box) { return edges_of_box(box, visit); });
}

bool Mesh::back_to_front(const Vec3& eye, void (*visit)(void*, std::uint32_t, std::span<const Vec3>),
                         void* context) const {
  return index_ && index_->back_to_front(eye, visit, context);
}

void Mesh::find_neighbors(std::span<const Corners> corners) {
  struct Side {
    std::uint32_t low, high;  // vertices
    std::uint32_t triangle, edge;
    auto operator<=>(const Side&) const = default;
  };
  std::vector<Side> list;
  list.reserve(3 * corners.size());
  for (std::uint32_t i = 0; i < corners.size(); ++i)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = corners[i].v[k], b = corners[i].v[(k + 1) % 3];
      list.push_back({std::min(a, b), std::max(a, b), i, k});
    }
  std::sort(list.begin(), list.end());
  for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
    while (end < list.size() && list[end].low == list[first].low && list[end].high == list[first].high) ++end;
    const std::span<const Side> sides(&list[first], end - first);
    if (sides.size() != 2) continue;  // borders, and edges of three or more triangles, stay sharp
    for (int s = 0; s < 2; ++s) {
      const Side &own = sides[static_cast<std::size_t>(s)], &other = sides[static_cast<std::size_t>(1 - s)];
      const Corners &c = corners[own.triangle], &o = corners[other.triangle];
      const Vec3 n = normal_of(triangles_[own.triangle]), m = normal_of(triangles_[other.triangle]);
      const Vec3 &p = vertices_[c.v[own.edge]], &q = vertices_[c.v[(own.edge + 1) % 3]];
      const Vec3& far = vertices_[o.v[(other.edge + 2) % 3]];
      const Vec3 away = cross(far - p, q - p);  // as long as the distance to the edge, times the edge
      const Real sine = dot(n, far - p) * length(q - p) / length(away);
      const bool outward = dot(cross(q - p, n), far - p) > 0;  // else folded back over the triangle
      if (sine > (outward ? -kFlatSine : kFlatSine))
        triangles_[own.triangle].flat_edges |= std::uint8_t(1u << own.edge);
      if (sine < (outward ? kFlatSine : -kFlatSine))
        triangles_[own.triangle].flat_edges |= std::uint8_t(8u << own.edge);
      triangles_[own.triangle].edge_cosine[own.edge] = outward ? std::abs(dot(n, m)) : -std::abs(dot(n, m));
    }
  }
}

ShapeArguments Mesh::arguments() const {
  // corners are different places: their numbers, by place
  std::vector<std::uint32_t> order(vertices_.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [](const Vec3& p, const Vec3& q) {
    return std::tie(p[0], p[1], p[2]) < std::tie(q[0], q[1], q[2]);
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t i, std::uint32_t j) { return before(vertices_[i], vertices_[j]); });
  const auto number_of = [&](const Vec3& p) {
    return *std::lower_bound(order.begin(), order.end(), p,
                             [&](std::uint32_t i, const Vec3& q) { return before(vertices_[i], q); });
  };
  ShapeArguments out{.points = vertices_, .triangles = std::vector<std::uint32_t>(3 * triangles_.size())};
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    std::uint32_t* to = &out.triangles[3 * std::size_t(given_[k])];
    to[0] = number_of(triangles_[k].a), to[1] = number_of(triangles_[k].b), to[2] = number_of(triangles_[k].c);
  }
  out.surfaces = surfaces_, out.mesh_index = choice_;
  if (surfaces_.empty()) return out;
  out.triangle_surfaces.resize(triangles_.size());
  for (std::size_t k = 0; k < triangles_.size(); ++k) out.triangle_surfaces[given_[k]] = triangles_[k].surface;
  return out;
}

// Two-sided, as contacts are. Möller and Trumbore 1997.
bool Mesh::raycast(const Vec3& o, const Vec3& d, RayHit& hit) const {
  bool found = false;
  Real best = 1;
  const auto meet = [&](std::uint32_t i) {
    const Triangle& triangle = triangles_[i];
    const Vec3 &a = triangle.a, ab = triangle.b - a, ac = triangle.c - a;
    const Vec3 p = cross(d, ac), s = o - a, q = cross(s, ab);
    const Real det = dot(ab, p);
    if (det == 0) return;
    const Real u = dot(s, p) / det, v = dot(d, q) / det, t = dot(ac, q) / det;
    constexpr Real kSeam = Real(-1e-6);  // rays through a shared edge hit one of the two
    if (u < kSeam || v < kSeam || u + v > 1 - kSeam || t < 0 || t > best || (found && t == best)) return;
    best = t, found = true;
    const Vec3 n = normalized_or(cross(ab, ac), Vec3::Zero());
    hit = {t, dot(n, d) > 0 ? Vec3(-n) : n};
  };
  each_along(o, d, best, meet);
  return found;
}

// Of the triangles whose boxes the ray may meet before `best`, which visits may bring nearer.
template <class F>
void Mesh::each_along(const Vec3& origin, const Vec3& ray, const Real& best, F&& visit) const {
  if (!index_) return tree_.query_if([&](const Aabb& box) { return ray_meets(box, origin, ray, best); }, visit);
  BorrowedList<std::uint32_t> list;
  index_->find_ray(origin, ray, *list);
  sort_once(*list);
  for (const std::uint32_t i : *list) visit(i);
}

Real Mesh::distance(const Vec3& p, Real limit, Vec3& normal) const {
  struct Search {
    const Mesh* mesh;
    Vec3 p, on;
    Real nearest;  // squared
    std::uint32_t triangle;
  } search{this, p, Vec3::Zero(), kInfinity, kNone};
  Aabb around{p, p};
  around.grow(limit);
  triangles_in(
      around,
      [](void* context, std::uint32_t i) {
        Search& s = *static_cast<Search*>(context);
        const Triangle& t = s.mesh->triangles_[i];
        const Vec3 on = closest_on_triangle(s.p, t.a, t.b, t.c);
        const Real d = dot(s.p - on, s.p - on);
        if (d < s.nearest) s.nearest = d, s.on = on, s.triangle = i;
      },
      &search);
  if (search.triangle == kNone) {
    normal = vec3(0, 1, 0);
    return limit;
  }
  const Triangle t = triangle(search.triangle);
  normal = normalized_or(p - search.on, normalized_or(cross(t.b - t.a, t.c - t.a), vec3(0, 1, 0)));
  return std::sqrt(search.nearest);
}

void Mesh::triangles_in(const Aabb& local, void (*visit)(void*, std::uint32_t), void* context) const {
  if (!index_) return tree_.query(local, [&](std::uint32_t i) { visit(context, i); });
  BorrowedList<std::uint32_t> list;
  index_->find(local, *list);
  sort_once(*list);
  for (const std::uint32_t i : *list) {
    const Triangle& t = triangles_[i];
    Aabb box{t.a, t.a};
    box.include(t.b), box.include(t.c);
    if (overlaps(box, local)) visit(context, i);
  }
}

// The different places among them, in the order in which they come first; returns the number of each.
std::vector<std::uint32_t> number_places(std::span<const Vec3> vertices, std::vector<Vec3>& places) {
  std::vector<std::uint32_t> order(vertices.size()), number(vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    const Vec3 &a = vertices[i], &b = vertices[j];
    if (a[0] != b[0]) return a[0] < b[0];
    if (a[1] != b[1]) return a[1] < b[1];
    return a[2] != b[2] ? a[2] < b[2] : i < j;
  });
  // the first at its place for now
  for (std::size_t k = 0; k < order.size(); ++k)
    number[order[k]] = k > 0 && vertices[order[k]] == vertices[order[k - 1]] ? number[order[k - 1]] : order[k];
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    if (number[i] != i) {
      number[i] = number[number[i]];
      continue;
    }
    number[i] = static_cast<std::uint32_t>(places.size());
    places.push_back(vertices[i]);
  }
  return number;
}

void check_index(const MeshIndex& c) {
  const std::string index = c.index.empty() ? "bvh" : c.index;
  find_variant(triangle_indexes(), index, "mesh index");
  if (index != "bvh" && (!c.volume.empty() || !c.build.empty()))
    throw SceneError("mesh: volume and build are those of index = \"bvh\", got index = \"" + index + "\"");
  if (!c.volume.empty()) bounding_volume(c.volume);
  if (!c.build.empty()) tree_build(c.build);
}

ShapePtr make(const ShapeInput& in) {
  const std::span<const Vec3> vertices = in.points;
  const std::span<const std::uint32_t> triangles = in.triangles;
  if (triangles.size() % 3 != 0 || triangles.empty())
    throw SceneError("mesh: expected three vertex numbers per triangle, got " + std::to_string(triangles.size()) +
                     " numbers");
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (!is_finite(vertices[i]))
      throw SceneError("mesh: expected finite vertices, but vertex " + std::to_string(i + 1) + " is not");
  std::vector<Vec3> points;
  const std::vector<std::uint32_t> number = number_places(vertices, points);
  check_surfaces("mesh", in.surfaces);
  if (!in.triangle_surfaces.empty() && 3 * in.triangle_surfaces.size() != triangles.size())
    throw SceneError("mesh: expected a surface per triangle, got " + std::to_string(in.triangle_surfaces.size()) +
                     " of " + std::to_string(triangles.size() / 3));
  TriangleSurfaces surfaces;
  const bool differs = std::any_of(in.triangle_surfaces.begin(), in.triangle_surfaces.end(), [](auto s) { return s; });
  if (differs) surfaces.list.assign(in.surfaces.begin(), in.surfaces.end());
  std::vector<Corners> kept;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    Corners c;
    for (std::size_t k = 0; k < 3; ++k) {
      if (triangles[i + k] >= vertices.size())
        throw SceneError("mesh: triangle " + std::to_string(i / 3 + 1) + " names vertex " +
                         std::to_string(triangles[i + k] + 1) + ", but there are " + std::to_string(vertices.size()));
      c.v[k] = number[triangles[i + k]];
    }
    const Vec3 ab = points[c.v[1]] - points[c.v[0]], ac = points[c.v[2]] - points[c.v[0]], bc = ac - ab;
    const Real longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    if (differs && in.triangle_surfaces[i / 3] > in.surfaces.size())
      fail_surface_number("mesh: triangle " + std::to_string(i / 3 + 1), in.triangle_surfaces[i / 3], in.surfaces);
    if (!(length(cross(ab, ac)) > kNoArea * longest)) continue;
    kept.push_back(c);
    if (differs) surfaces.of.push_back(in.triangle_surfaces[i / 3]);
  }
  if (kept.empty()) throw SceneError("mesh: no triangle has an area");
  check_index(in.mesh_index);
  return std::make_shared<Mesh>(std::move(points), std::move(kept), std::move(surfaces), in.mesh_index);
}

}  // namespace

ShapeKind geom_mesh() {
  return {"mesh",
          "(vertices, triangles, [{ surfaces =, index =, volume =, build =, leaf = }])",
          "triangles {i, j, k} from 1, static, or with a mass the solid within; {i, j, k, s} has surfaces[s] in place "
          "of the body's",
          {},
          {{"vertices", ShapeArgumentType::points},
           {"triangles", ShapeArgumentType::triangles},
           {"surfaces", ShapeArgumentType::surfaces, 0}},
          make,
          [] {
            const Vec3 v[5] = {{-2, 0, -2}, {2, 0, -2}, {2, 0, 2}, {-2, 0, 2}, {0, 1, 0}};
            const std::uint32_t pyramid[12] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};
            const std::uint32_t floor[6] = {0, 2, 1, 0, 3, 2};
            const ShapeSurface surfaces[2] = {{.numbers = {.friction_static = 1, .friction_dynamic = 1}},
                                              {.has_velocity = true, .velocity = vec3(1, 0, 0), .material = "ice"}};
            const SurfaceNumber of[4] = {2, 0, 1, 2};
            return std::vector<ShapePtr>{make_mesh(v, pyramid), make_mesh({v, 4}, floor),
                                         make_mesh(v, pyramid, surfaces, of)};
          }};
}

}  // namespace feder
