// Where a volume is asked for: box = {min, max}, or a shape with its pose.
#pragma once
#include "feder/shape.h"
#include "lua/options.h"

namespace feder::lua {

// box = {min, max}, or shape = with position; and rotation. A mistake when there is neither or both.
void box_or_shape(Options& o, ShapePtr& shape, Vec3& position, Quat& rotation);
bool box_corners(Options& o, Vec3& lo, Vec3& hi);  // of box = {min, max}; false when it is absent
bool has_volume(Options& o);                       // is one of these given?
template <class T>
constexpr Option<T> box_row(void (*read)(Options&, const OptionRow&, T&)) {
  return special("box", "{min, max}", read, "m");
}

}  // namespace feder::lua
