#include "geom/hull.h"

#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry tessellate_hull(const Shape& shape) {
  const HullData& data = static_cast<const Hull&>(shape).data();
  Geometry g;
  g.kind = "hull";
  for (const HullFace& f : data.faces) {
    std::vector<P> loop;
    for (std::uint16_t i = 0; i < f.count; ++i)
      loop.push_back(point(data.corners[data.loops[static_cast<std::size_t>(f.first) + i]]));
    face(g, loop, point(f.normal));
  }
  return g;
}

}  // namespace

ShapeDrawing draw_hull() {
  return {"hull", [](const Shape& s) {
            Drawing d;
            d.own = tessellate_hull(s);
            return d;
          }};
}

}  // namespace feder::view
