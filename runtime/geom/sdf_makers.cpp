// The functions of feder/sdf.h, by the kind of shape that is a field.
#include "feder/error.h"
#include "feder/sdf.h"

namespace feder {
namespace {

const SdfMakers& makers() {
  for (const ShapeKind& kind : shape_kinds())
    if (kind.fields) return *kind.fields;
  throw SceneError("sdf: this build has no distance fields");
}

const SdfMakers* makers_of(const Shape& shape) {
  return shape_kinds()[static_cast<std::size_t>(shape.kind_id())].fields;
}

}  // namespace

ShapePtr make_sdf(const SdfDesc& desc) { return makers().make(desc); }
ShapePtr sdf_union(const Shape& a, const Shape& b, const Pose& place_b) {
  return makers().combine(SdfOperation::unite, a, b, place_b);
}
ShapePtr sdf_subtract(const Shape& a, const Shape& b, const Pose& place_b) {
  return makers().combine(SdfOperation::subtract, a, b, place_b);
}
ShapePtr sdf_intersect(const Shape& a, const Shape& b, const Pose& place_b) {
  return makers().combine(SdfOperation::intersect, a, b, place_b);
}
ShapePtr sdf_offset(const Shape& a, Real distance) { return makers().offset(a, distance); }

std::vector<ShapePtr> sdf_parts(const ShapePtr& field) { return makers().parts(field); }

std::optional<SdfReport> sdf_report(const Shape& shape) {
  const SdfMakers* of = makers_of(shape);
  if (!of) return std::nullopt;
  return of->report(shape);
}

SdfSurface sdf_surface(const Shape& shape) {
  const SdfMakers* of = makers_of(shape);
  if (!of) throw SceneError(std::string("sdf_surface: a ") + shape.kind() + " is no field");
  return of->surface(shape);
}

}  // namespace feder
