#include "feder/sdf.h"

#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry tessellate_field(const Shape& shape) {
  const SdfSurface surface = sdf_surface(shape);
  Geometry g;
  g.kind = "sdf";
  g.vertices.reserve(surface.vertices.size());
  for (std::size_t i = 0; i < surface.vertices.size(); ++i)
    g.vertices.push_back({to_float3(surface.vertices[i]), to_float3(surface.normals[i]), 0, 0});
  g.indices = surface.triangles;
  return g;
}

}  // namespace

ShapeDrawing draw_sdf() {
  return {"sdf", [](const Shape& s) { return Drawing{.own = tessellate_field(s)}; }};
}

}  // namespace feder::view
