// A shape: immutable geometry in its own frame, shared between colliders. Convex shapes are a core (points, or an
// analytic support function) rounded by `radius`: a sphere is a point, a capsule a segment.
// One file per shape, one feder_variant(geom <kind>) line each: its row has its arguments, for scripts too. Checked
// for every kind by tests/geom/test_shape_contract.cpp: bounds hold all supports, mass equals a voxel sum, I = tr(C)1 -
// C, faces lie on the surface, rays agree with support planes; test_shape_distance.cpp: distances agree with supports
// and rays.
#pragma once
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "feder/types.h"

namespace feder {

// Distance from a point of a rounded core, at offset `d` from it, and its direction; `fallback` where d vanishes.
inline Real round_distance(const Vec3& d, Real radius, const Vec3& fallback, Vec3& normal) {
  normal = normalized_or(d, fallback);
  return length(d) - radius;
}

// What a part of a compound or a triangle of a mesh states of its surface: friction, restitution, belts, a material.
// What it does not state is its material's, and what that does not state is the body's.
// Each below 0: not stated.
struct SurfaceNumbers {
  Real friction_static = -1, friction_dynamic = -1, restitution = -1;
  Real rolling_friction = -1;  // lever arm, m

  // Calls f(field) for all of them, in this order.
  template <class S, class F>
  static void each_field(S& s, F&& f) {
    f(s.friction_static), f(s.friction_dynamic), f(s.restitution), f(s.rolling_friction);
  }
};

struct ShapeSurface {
  SurfaceNumbers numbers = {};
  bool has_velocity = false;
  Vec3 velocity = Vec3::Zero();  // body frame, m/s, when has_velocity
  std::string material = {};     // of the world's; "": not stated

  template <class S, class F>
  static void each_field(S& s, F&& f) {
    SurfaceNumbers::each_field(s.numbers, f), f(s.has_velocity), f(s.velocity), f(s.material);
  }
};

inline constexpr std::size_t kMaxSurfaces = 0xffff;

// What is stated takes the place of what was there.
inline void override_numbers(SurfaceNumbers& all, const SurfaceNumbers& by) {
  if (by.friction_static >= 0) all.friction_static = by.friction_static;
  if (by.friction_dynamic >= 0) all.friction_dynamic = by.friction_dynamic;
  if (by.restitution >= 0) all.restitution = by.restitution;
  if (by.rolling_friction >= 0) all.rolling_friction = by.rolling_friction;
}

// All about the centre of mass, in the shape's frame. A shape without volume (plane, mesh) has mass 0.
struct MassProperties {
  Real mass = 0;                // kg
  Vec3 center = Vec3::Zero();   // m
  Mat3 inertia = Mat3::Zero();  // kg m^2
};
// The same solid rotated and moved by `pose`.
MassProperties transformed(const MassProperties& m, const Pose& pose);
MassProperties combined(std::span<const MassProperties> parts);

struct RayHit {
  Real fraction = 1;           // of the ray vector, 0..1
  Vec3 normal = Vec3::Zero();  // unit, outward, in the frame of the ray; zero when the ray starts inside
};

struct Triangle {
  Vec3 a, b, c;
  std::uint8_t flat_edges = 0;         // bit k: edge k (ab, bc, ca) joins a coplanar or concave neighbour;
                                       // bit 3 + k: the same seen from behind
  SurfaceNumber surface = 0;           // in Shape::surfaces()
  Real edge_cosine[3] = {-1, -1, -1};  // between this normal and that of the neighbour across edge k; -1: none
};

inline constexpr int kMaxFacePoints = 32;

class Shape;
using ShapePtr = std::shared_ptr<const Shape>;
struct SdfDesc;  // feder/sdf.h
using MakeSdf = std::function<ShapePtr(const SdfDesc&)>;

// How a mesh finds its triangles. Results have the same bits with any of them; which is fastest depends on the mesh.
struct MeshIndex {
  std::string index = {};   // "bvh", "grid", "kd_tree", "octree"; "": "bvh" of boxes, built for contacts
  std::string volume = {};  // of "bvh": a bounding volume
  std::string build = {};   // of "bvh": how it is built
  std::uint32_t leaf = 0;   // triangles in a leaf or cell; 0: the index chooses
  bool chosen() const { return !index.empty() || !volume.empty() || !build.empty() || leaf > 0; }

  template <class S, class F>
  static void each_field(S& s, F&& f) {
    f(s.index), f(s.volume), f(s.build), f(s.leaf);
  }
};
// Names of this build: "a, b".
std::string mesh_index_names();
std::string bounding_volume_names();
std::string tree_build_names();

struct CompoundPart {
  ShapePtr shape;
  Pose pose;
  SurfaceNumber surface = 0;  // in the compound's Shape::surfaces()
};

// What a shape is made from; `input()` is a view of it for make_shape().
struct ShapeInput;
struct ShapeArguments {
  std::vector<double> sizes = {};
  Vec3 direction = Vec3(0, 1, 0);
  std::vector<Vec3> points = {};
  std::vector<std::uint32_t> triangles = {};
  std::vector<CompoundPart> parts = {};
  std::vector<ShapeSurface> surfaces = {};
  std::vector<SurfaceNumber> triangle_surfaces = {};  // one per triangle, or none
  MeshIndex mesh_index = {};
  std::string content = {};  // bytes, of a distance field
  ShapeInput input() const;
};

class Shape {
 public:
  virtual ~Shape() = default;
  const char* kind() const { return kind_; }
  int kind_id() const { return kind_id_; }  // row in shape_kinds()
  Real radius() const { return radius_; }   // rounding of the core, m
  bool convex() const { return convex_; }
  bool planar() const { return planar_; }  // a 2D section in the xy plane; meets only its like and planes

  virtual Aabb bounds(const Pose& pose) const = 0;
  virtual MassProperties mass(Real density) const = 0;  // density kg/m^3 (2D sections: kg/m^2)
  // Farthest distance of any point from `center` (shape frame), m; infinite for planes.
  virtual Real extent(const Vec3& center) const = 0;
  // Ray from `origin` along `ray` (shape frame, whole vector = fraction 1). False when it misses.
  virtual bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const = 0;

  // Signed distance of `p` (shape frame) from the surface, negative inside, and the unit direction in which it grows.
  // Beyond `limit` any number of at least `limit` may be returned. A mesh has no inside: its distance is never negative
  // and `normal` points to the side of `p`. In 2D sections z is ignored.
  virtual Real distance(const Vec3& p, Real limit, Vec3& normal) const = 0;

  // Of a solid that is not convex: half its thickness, the radius of the median of balls that fill it; else 0.
  virtual Real inner_radius() const { return 0; }

  // Convex only. Farthest core point along `direction` (shape frame; need not be unit).
  virtual Vec3 support(const Vec3& direction) const;
  // Convex only. The core's face, edge or point most aligned with the unit `direction`: its corner points,
  // counter-clockwise seen from outside; returns the count (1..kMaxFacePoints).
  virtual int face(const Vec3& direction, Vec3* points) const;

  // Meshes only. Calls visit(context, triangle index) for triangles whose box overlaps `local` (shape frame), in
  // ascending order.
  virtual void triangles_in(const Aabb& local, void (*visit)(void*, std::uint32_t), void* context) const;
  virtual const Triangle& triangle(std::uint32_t index) const;
  // Of meshes and distance fields, for reports: "bvh of obb, sah, 20000 triangles, 1.2 MB".
  virtual std::string describe() const { return {}; }
  // What it could not do for its spacing or its input, and the cure: a body made from it passes them on as warnings.
  virtual std::span<const std::string> warnings() const { return {}; }
  // Meshes only: the solid that its triangles bound, for bodies with a mass; made once, by `make` if it is
  // given. SceneError when there is none.
  virtual std::shared_ptr<const Shape> solid(const MakeSdf& make = {}) const;
  // Meshes only, for drawing. Calls edge(context, a, b) for the edges of the volumes of the index so many levels below
  // the whole and of those above that none lies below (shape frame), while it returns true. True: there are deeper
  // ones.
  virtual bool volumes_at(int level, bool (*edge)(void*, const Vec3&, const Vec3&), void* context) const;
  // Meshes with index = "bsp" only, for drawing. Calls visit(context, triangle, corners) for parts of triangles, none
  // of which hides a later one from `eye` (shape frame). False: this shape knows no such order.
  virtual bool back_to_front(const Vec3& eye, void (*visit)(void*, std::uint32_t, std::span<const Vec3>),
                             void* context) const;

  // The half-space n.x <= d, n unit: true and both for a plane.
  virtual bool half_space(Vec3& /*normal*/, Real& /*distance*/) const { return false; }
  // Of a compound: a body made from it gets one collider per part. Empty for all others.
  virtual std::span<const CompoundPart> parts() const;
  // What triangles of a mesh and parts of a compound name by number, from 1. Empty where nothing differs from the body.
  virtual std::span<const ShapeSurface> surfaces() const;

  // What make_shape() makes an equal shape from, to the last bit. SceneError for shapes that scripts cannot make.
  virtual ShapeArguments arguments() const;

  // The section in the xy plane, for worlds with dimension = 2. SceneError when the shape has none.
  virtual std::shared_ptr<const Shape> section() const;

 protected:
  Shape(const char* kind, bool convex, Real radius = 0);
  Shape(int kind_id, bool convex, Real radius);

 private:
  const char* kind_;
  int kind_id_;
  bool convex_;

 protected:
  Real radius_;
  bool planar_ = false;
};

// Arguments of a shape, as its row names them. The views are valid until make_shape() returns.
struct ShapeInput {
  std::vector<double> sizes = {};  // sizes, then numbers, in the order of the arguments
  Vec3 direction = Vec3(0, 1, 0);
  std::span<const Vec3> points = {};  // z is ignored by 2D shapes
  std::span<const std::uint32_t> triangles = {};
  std::span<const CompoundPart> parts = {};
  std::span<const ShapeSurface> surfaces = {};
  std::span<const SurfaceNumber> triangle_surfaces = {};  // one per triangle, or none
  MeshIndex mesh_index = {};
  std::string_view content = {};
  Real size(std::size_t k) const { return static_cast<Real>(sizes[k]); }
};

inline ShapeInput ShapeArguments::input() const {
  return {sizes, direction, points, triangles, parts, surfaces, triangle_surfaces, mesh_index, content};
}

// surfaces: of the triangles before it.
enum class ShapeArgumentType : std::uint8_t { size, number, direction, points, points_2d, triangles, parts, surfaces };
struct ShapeArgument {
  const char* name;
  ShapeArgumentType type;
  double fallback = NAN;  // NaN: must be given; of a direction any number: that of ShapeInput
};

struct SdfMakers;

// What all shapes of a kind have in common; decides which pairs touch.
struct ShapeTraits {
  bool convex = false;
  bool planar = false;  // a section of 2D worlds
  bool whole = true;    // one collider, not the parts of a compound
};

// One row per kind, in the order of the feder_variant(geom ...) lines.
struct ShapeKind {
  const char* name;
  const char* usage;  // "(radius, height)"
  const char* summary;
  ShapeTraits traits;
  std::vector<ShapeArgument> arguments;
  ShapePtr (*make)(const ShapeInput&);  // SceneError on non-finite or non-positive sizes
  std::vector<ShapePtr> (*samples)();   // a few for the contract tests: ordinary, flat, tiny
  bool any_convex = false;              // its pair tests serve every convex shape without a kind of its own
  const char* other_names = "";         // "cube, cuboid": what else people call it, for messages
  const SdfMakers* fields = nullptr;    // of distance fields: feder/sdf.h
};
std::span<const ShapeKind> shape_kinds();
int shape_kind_id(const char* name);  // SceneError when this build has none
ShapePtr make_shape(const char* kind, const ShapeInput& input);
// For convex shapes that are made on the fly, such as a triangle with its thickness. SceneError when this build has
// none.
int any_convex_kind();

// make_shape() by types. Axis of capsule, cylinder and cone: y. Origin: centre of sphere, box, capsule, cylinder; a
// cone's origin is halfway up its height (base at -h/2).
inline ShapePtr make_sphere(Real radius) { return make_shape("sphere", {{radius}}); }
// The shape of points of nets and surfaces.
inline ShapePtr make_point(Real radius) { return make_sphere(radius); }
inline ShapePtr make_box(Real width, Real height, Real depth) {  // full sizes
  return make_shape("box", {{width, height, depth}});
}
// Whole height, caps included: at least 2 radius.
inline ShapePtr make_capsule(Real radius, Real height) { return make_shape("capsule", {{radius, height}}); }
inline ShapePtr make_cylinder(Real radius, Real height) { return make_shape("cylinder", {{radius, height}}); }
inline ShapePtr make_cone(Real radius, Real height) { return make_shape("cone", {{radius, height}}); }
// Quickhull; SceneError when the points are flat or too few.
inline ShapePtr make_hull(std::span<const Vec3> points) { return make_shape("hull", {.points = points}); }
// The half-space n.x <= d is solid.
inline ShapePtr make_plane(const Vec3& normal, Real distance) { return make_shape("plane", {{distance}, normal}); }
// For static bodies. `triangle_surfaces`: the number of each triangle's surface.
inline ShapePtr make_mesh(std::span<const Vec3> vertices, std::span<const std::uint32_t> triangles,
                          std::span<const ShapeSurface> surfaces = {},
                          std::span<const SurfaceNumber> triangle_surfaces = {}) {
  return make_shape(
      "mesh",
      {.points = vertices, .triangles = triangles, .surfaces = surfaces, .triangle_surfaces = triangle_surfaces});
}
inline ShapePtr make_circle(Real radius) { return make_shape("circle", {{radius}}); }  // 2D
// 2D: the convex hull of the points.
inline ShapePtr make_polygon(std::span<const Vec2> points, Real radius = 0) {
  std::vector<Vec3> flat;
  for (const Vec2& p : points) flat.emplace_back(p[0], p[1], 0);
  return make_shape("polygon", {.sizes = {radius}, .points = flat});
}
inline ShapePtr make_compound(const std::vector<CompoundPart>& parts, std::span<const ShapeSurface> surfaces = {}) {
  return make_shape("compound", {.parts = parts, .surfaces = surfaces});
}

}  // namespace feder
