// Triangles of a shape for drawing and export, and the cache that makes them once per shape. Boxes share one unit
// cube, spheres and capsules one ball, and so on, scaled by the instance: ten thousand boxes of any size are one batch.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "feder/shape.h"
#include "view/float3.h"

namespace feder::view {

struct Vertex {
  Float3 position;
  Float3 normal;  // unit, outward
  float side;     // -1, 0, 1: which way the instance's stretch moves it along y
  float edge;     // 1 on a drawn edge of the face, falling linearly to 0 in its middle; 0 all over: no edges
};

struct Geometry {
  const char* kind = "";  // of the shape
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // counter-clockwise seen from outside
  bool two_sided = false;              // open surfaces
  Float3 low, high;                    // box of the vertices, unscaled, m
  ShapePtr ordered;                    // its triangles from back to front, where the shape knows that; else null
};

// A shape as an instance sees it: its geometry and how to scale it.
struct Fitted {
  std::uint32_t geometry = kNone;  // kNone: nothing to draw (planes are Frame::grounds)
  Float3 scale{1, 1, 1};
  float stretch = 0;
};

class GeometryCache {
 public:
  // Makes the geometry on first use and keeps the shape alive, so that its address stays its own.
  const Fitted& fit(const ShapePtr& shape);
  const std::vector<std::shared_ptr<const Geometry>>& geometries() const { return geometries_; }

 private:
  struct Entry {
    ShapePtr shape;
    Fitted fitted;
  };
  std::uint32_t keep(Geometry geometry);
  std::uint32_t shared(Geometry (*unit)());
  Fitted make(const ShapePtr& shape);

  std::vector<std::shared_ptr<const Geometry>> geometries_;
  std::unordered_map<const Shape*, Entry> entries_;
  std::vector<std::pair<Geometry (*)(), std::uint32_t>> shared_;
};

// Depth that circles and polygons of 2D worlds are drawn with, m.
inline constexpr float kPrismDepth = 0.4f;

}  // namespace feder::view
