// What impacts and casts ask of distance fields, in builds that have them.
#pragma once
#include <span>

#include "narrow/gjk.h"

namespace feder {

struct FieldTools {
  bool (*is_field)(const Shape&);
  std::span<const CompoundPart> (*balls)(const Shape& field);  // spheres
  // least_over_convex of field_contact.h
  Real (*least)(const Shape& field, const Convex& core, const Pose& place, const Vec3& start, Vec3& at, Vec3& normal);
};
const FieldTools* field_tools();  // null in a build without

}  // namespace feder
