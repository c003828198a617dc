#include "view/geometry.h"

#include <algorithm>
#include <cstring>

namespace feder::view {
namespace {

void set(float out[3], float x, float y, float z) { out[0] = x, out[1] = y, out[2] = z; }

void measure(Geometry& g) {
  for (int k = 0; k < 3; ++k) g.low[k] = 1e30f, g.high[k] = -1e30f;
  for (const Vertex& v : g.vertices)
    for (int k = 0; k < 3; ++k)
      g.low[k] = std::min(g.low[k], v.position[k]), g.high[k] = std::max(g.high[k], v.position[k]);
}

}  // namespace

std::uint32_t GeometryCache::shared(const char* kind, Geometry (*unit)()) {
  for (const auto& [name, id] : shared_)
    if (std::strcmp(name, kind) == 0) return id;
  auto made = std::make_shared<Geometry>(unit());
  measure(*made);
  geometries_.push_back(std::move(made));
  shared_.emplace_back(kind, static_cast<std::uint32_t>(geometries_.size() - 1));
  return shared_.back().second;
}

Fitted GeometryCache::make(const Shape& shape) {
  const std::string_view kind = shape.kind();
  Fitted f;
  const auto along = [&shape](Real x, Real y, Real z, int axis) {
    return static_cast<float>(shape.support(vec3(x, y, z))[axis]);
  };
  const float r = static_cast<float>(shape.radius());
  if (kind == "plane" || kind == "compound") return f;  // a ground; parts, which are fitted one by one
  if (kind == "sphere") {
    f.geometry = shared("ball", unit_ball);
    set(f.scale, r, r, r);
  } else if (kind == "capsule") {
    f.geometry = shared("ball", unit_ball);
    set(f.scale, r, r, r);
    f.stretch = along(0, 1, 0, 1);
  } else if (kind == "box") {
    f.geometry = shared("box", unit_box);
    set(f.scale, 2 * along(1, 1, 1, 0), 2 * along(1, 1, 1, 1), 2 * along(1, 1, 1, 2));
  } else if (kind == "cylinder" || kind == "cone") {
    f.geometry = kind == "cone" ? shared("cone", unit_cone) : shared("cylinder", unit_cylinder);
    const float radius = along(1, -1, 0, 0);
    set(f.scale, radius, 2 * along(0, 1, 0, 1), radius);
  } else if (kind == "circle") {
    f.geometry = shared("disc", unit_disc);
    set(f.scale, r, r, kPrismDepth);
  } else {
    auto made = std::make_shared<Geometry>(kind == "hull"      ? tessellate_hull(shape)
                                           : kind == "polygon" ? tessellate_polygon(shape)
                                           : shape.convex()    ? tessellate_convex(shape)
                                                               : tessellate_mesh(shape));
    measure(*made);
    geometries_.push_back(std::move(made));
    f.geometry = static_cast<std::uint32_t>(geometries_.size() - 1);
  }
  return f;
}

const Fitted& GeometryCache::fit(const ShapePtr& shape) {
  Entry& entry = entries_[shape.get()];
  if (!entry.shape) entry = {shape, make(*shape)};
  return entry.fitted;
}

}  // namespace feder::view
