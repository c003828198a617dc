// A frame as triangles in world space, one solid per thing that is drawn: for files that know no instances.
#pragma once
#include <string>
#include <vector>

#include "view/frame.h"

namespace feder::view {

struct Solid {
  std::uint32_t object = kNone;  // slot
  Color color;
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;
};

// Instances, dynamic meshes and grounds (as squares about the scene), in the frame's order.
std::vector<Solid> solids(const Frame& frame);
// An instance in the world.
Solid solid(const Instance& instance, const Geometry& geometry);
// A square of the plane, as wide as four times what else is drawn, at least 10 m.
Solid solid(const Ground& ground, const Frame& frame);
// Points as balls of this geometry.
Instance ball_instance(const Point& point, Color color, std::uint32_t object);
Color point_color(const PointGroup& group, const Point& point);

}  // namespace feder::view
