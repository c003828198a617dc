#include "narrow/field_tools.h"

#include "narrow/field_contact.h"

namespace feder {

const FieldTools* field_tools() {
  static const FieldTools tools = {
      is_sdf, [](const Shape& field) { return static_cast<const Sdf&>(field).ball_shapes(); },
      [](const Shape& field, const Convex& core, const Pose& place, const Vec3& start, Vec3& at, Vec3& normal) {
        return least_over_convex(static_cast<const Sdf&>(field).field(), core, place, start, at, normal);
      }};
  return &tools;
}

}  // namespace feder
