#include "geom/hull.h"

#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry tessellate_hull(const Shape& shape) {
  const HullData& data = static_cast<const Hull&>(shape).data();
  Geometry g;
  g.kind = "hull";
  for (const HullFace& f : data.faces) {
    std::vector<Float3> loop;
    for (std::uint16_t i = 0; i < f.count; ++i)
      loop.push_back(to_float3(data.corners[data.loops[static_cast<std::size_t>(f.first) + i]]));
    face(g, loop, to_float3(f.normal));
  }
  return g;
}

}  // namespace

ShapeDrawing draw_hull() {
  return {"hull", [](const Shape& s) { return Drawing{.own = tessellate_hull(s)}; }};
}

}  // namespace feder::view
