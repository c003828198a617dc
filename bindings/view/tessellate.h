// What surfaces are put together from. Flat faces are fans around their middle, so that `edge` runs from 0 there to 1
// at their rim and the renderer can draw edges one pixel wide at any distance.
#pragma once
#include <optional>

#include "view/geometry.h"

namespace feder::view {

constexpr int kRound = 32;  // segments of a circle
constexpr float kTurn = 6.28318530718f;

// A flat face, corners counter-clockwise seen from outside.
void face(Geometry& g, const std::vector<Float3>& loop, Float3 normal);

// Outline in the xy plane, counter-clockwise, with outward normals; drawn as a prism along z.
struct Outline {
  Float3 at, normal;
};
void prism(Geometry& g, const std::vector<Outline>& outline, float depth);

// Round sides between two radii, normals by the slope, and the discs that close them; y from -1/2 to 1/2.
Geometry frustum(const char* kind, float bottom, float top);
Geometry unit_ball();  // radius 1; the equator doubled, so that a stretch makes it a capsule
Geometry tessellate_mesh(const Shape& shape);
Geometry tessellate_convex(const Shape& shape);  // any convex shape, by its support function

// How a shape is drawn: a geometry that all of its kind share, scaled, or one of its own.
struct Drawing {
  Geometry (*unit)() = nullptr;
  Float3 scale{1, 1, 1};
  float stretch = 0;  // see Vertex::side
  std::optional<Geometry> own = {};
};

// One row per shape with a file in shapes/; the others are drawn by their triangles or their support function.
struct ShapeDrawing {
  const char* kind;
  Drawing (*draw)(const Shape&);
};

// The unit ball with the radius of a shape, and a frustum of height 1 with its extent across and along y.
Drawing scaled_ball(const Shape& shape, float stretch);
Drawing scaled_frustum(const Shape& shape, Geometry (*unit)());
// Coordinate of the support point in a direction.
inline float reach(const Shape& shape, const Vec3& direction, int axis) {
  return static_cast<float>(shape.support(direction)[axis]);
}

}  // namespace feder::view
