// Signed distance fields: shapes of any form, sampled on a grid, for bodies that are not convex and for what is carved.
// A field is a Shape like any other (make_sdf gives one). Errors, spacing h, q the distance to the nearest sharp edge
// or place with two nearest surfaces: distance 1.1 h^2/(4 q) for q >= 3 h, .9 h elsewhere; walls thinner than 2 h get
// lost (the field says so in `warnings`).
// Sources: sign by winding number, Jacobson, Kavan & Sorkine-Hornung 2013; distances swept outwards as Bridson, "Fluid
// Simulation for Computer Graphics" 2nd ed. 2015, 4.1; parity of rays, Nooruddin & Turk 2003.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "feder/shape.h"

namespace feder {

// How triangles become distances: the nearest triangle of each corner; triangles drawn into a band and swept outwards;
// the same with the sign by the parity of rays along x, y and z, two votes of three.
enum class SdfAcquire : std::uint8_t { exact, rasterise, rays };

// One of mesh, shape, function and values.
struct SdfDesc {
  std::span<const Vec3> vertices = {};
  std::span<const std::uint32_t> triangles = {};  // three vertices each, counterclockwise from outside
  ShapePtr shape = nullptr;
  // Distance at x, y, z, negative inside; what is no distance is made one from where it is 0.
  std::function<double(double, double, double)> function = {};
  std::span<const double> values = {};  // at the corners of the grid, x fastest: size/spacing + 1 along each side
  Vec3 size = Vec3::Zero();             // m, of the box about the origin where function or values are known
  Real spacing = 0;                     // m; 0: a 64th of the longest side
  bool adaptive = false;                // an octree, fine near the surface
  Real tolerance = 0;                   // m, adaptive: coarser near the surface where no more is lost
  SdfAcquire acquire = SdfAcquire::exact;
};

struct SdfReport {
  int cells[3] = {0, 0, 0};
  Real spacing = 0;  // m
  std::size_t bytes = 0;
  bool adaptive = false;
  Real error = -1;                         // m, the largest found by sampling near the surface; below 0: not known
  std::vector<std::string> warnings = {};  // what it could not do, and the cure
};

inline constexpr std::uint64_t kMostSdfCorners = 100000000;

// SceneError: more than one source or none; no triangle, none with an area, inside out; spacing not below the thinnest
// side; a box with a side 10^4 times another; a function that gives no finite number; too many cells.
ShapePtr make_sdf(const SdfDesc& desc);

// Of fields and other solids; `place_b`: b in the frame of a. The result has the finer spacing of the fields.
// SceneError when neither is a field, or nothing is left. Source: minimum and maximum of distances, whose errors
// outside of the surface are those of bounds.
ShapePtr sdf_union(const Shape& a, const Shape& b, const Pose& place_b = {});
ShapePtr sdf_subtract(const Shape& a, const Shape& b, const Pose& place_b = {});
ShapePtr sdf_intersect(const Shape& a, const Shape& b, const Pose& place_b = {});
ShapePtr sdf_offset(const Shape& a, Real distance);  // m, outwards; below 0: inwards
// The parts of a field that do not hang together, the largest first; what has fewer than 8 corners of the grid inside
// is dust and left out. One: the field itself.
std::vector<ShapePtr> sdf_parts(const ShapePtr& field);

// Of a field; nothing for other shapes.
std::optional<SdfReport> sdf_report(const Shape& shape);

// Triangles of the surface, for drawing and export: three corners each, and unit normals.
struct SdfSurface {
  std::vector<Vec3> vertices, normals;
  std::vector<std::uint32_t> triangles;
};
SdfSurface sdf_surface(const Shape& shape);  // SceneError for what is no field

// What the kind of shape brings that is a field; builds without it have none.
enum class SdfOperation : std::uint8_t { unite, subtract, intersect };
struct SdfMakers {
  ShapePtr (*make)(const SdfDesc&);
  ShapePtr (*combine)(SdfOperation, const Shape& a, const Shape& b, const Pose& place_b);
  ShapePtr (*offset)(const Shape&, Real distance);
  std::vector<ShapePtr> (*parts)(const ShapePtr&);
  SdfReport (*report)(const Shape&);
  SdfSurface (*surface)(const Shape&);
};

}  // namespace feder
