#include "view/geometry.h"

#include <algorithm>
#include <string_view>

#include "view/tessellate.h"

namespace feder::view {

#include "shape_drawings_declare.inc"

namespace {

std::span<const ShapeDrawing> shape_drawings() {
  static const std::initializer_list<ShapeDrawing> table = {
#include "shape_drawings_rows.inc"
  };
  return {table.begin(), table.size()};
}

void measure(Geometry& g) {
  g.low = {1e30f, 1e30f, 1e30f}, g.high = {-1e30f, -1e30f, -1e30f};
  for (const Vertex& v : g.vertices) g.low = min(g.low, v.position), g.high = max(g.high, v.position);
}

}  // namespace

std::uint32_t GeometryCache::keep(Geometry geometry) {
  auto made = std::make_shared<Geometry>(std::move(geometry));
  measure(*made);
  geometries_.push_back(std::move(made));
  return static_cast<std::uint32_t>(geometries_.size() - 1);
}

std::uint32_t GeometryCache::shared(Geometry (*unit)()) {
  for (const auto& [made, id] : shared_)
    if (made == unit) return id;
  shared_.emplace_back(unit, keep(unit()));
  return shared_.back().second;
}

Fitted GeometryCache::make(const ShapePtr& given) {
  const Shape& shape = *given;
  Fitted f;
  Drawing d;
  const auto rows = shape_drawings();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const ShapeDrawing& r) { return std::string_view(r.kind) == shape.kind(); });
  if (row != rows.end())
    d = row->draw(shape);
  else
    d.own = shape.convex() ? tessellate_convex(shape) : tessellate_mesh(shape);
  if (d.own && d.own->vertices.empty()) return f;  // a plane is a ground; parts of a compound are fitted one by one
  const auto nothing = [](void*, std::uint32_t, std::span<const Vec3>) {};
  if (d.own && shape.back_to_front(Vec3::Zero(), nothing, nullptr)) d.own->ordered = given;
  f.geometry = d.own ? keep(std::move(*d.own)) : shared(d.unit);
  f.scale = d.scale, f.stretch = d.stretch;
  return f;
}

const Fitted& GeometryCache::fit(const ShapePtr& shape) {
  Entry& entry = entries_[shape.get()];
  if (!entry.shape) entry = {shape, make(shape)};
  return entry.fitted;
}

}  // namespace feder::view
