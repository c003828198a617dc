// Methods that all soft things have, beside those of their system: what is of one point or of all, and attachments. A
// part says with SoftPoints<S> what the points of system S are called. Points count from 1 in Lua.
#pragma once
#include "lua/method.h"
#include "lua/object_points.h"

namespace feder::lua {

// Of one, or of all.
template <class S>
double soft_mass(const Object<S>& s, lua_State* L) {
  if (!lua_isnoneornil(L, 2)) return s.system.point_mass(s.id, point_argument(L, s, 2));
  double sum = 0;
  for (std::size_t i = 0; i < SoftPoints<S>::count(s.system, s.id); ++i) sum += s.system.point_mass(s.id, i);
  return sum;
}

// The points that the argument at 2 means: a number, or where the system has names, those of a side.
template <class S>
std::vector<std::uint32_t> points_argument(lua_State* L, const Object<S>& s) {
  if constexpr (requires { s.system.named(s.id, ""); })
    if (lua_type(L, 2) == LUA_TSTRING) return s.system.named(s.id, lua_tostring(L, 2));
  return {static_cast<std::uint32_t>(point_argument(L, s, 2))};
}

// To another soft thing: to the point that is named, or the nearest one.
template <class S>
void attach_to_soft(const Object<S>& s, lua_State* L, const std::vector<std::uint32_t>& points, ObjectId other) {
  const Points at = points_of(L, 3);
  const bool named = !lua_isnoneornil(L, 4);
  if (named && points.size() > 1) fail_here(L, "expected no point for " + describe(L, 2) + ": it is several points");
  for (const std::uint32_t i : points) {
    std::size_t j = 0;
    if (named) {
      j = number_in(L, 4, at.size() / 3, "point");
    } else {
      const Vec3 x = s.system.point(s.id, i);
      double least = double(kInfinity);
      for (std::size_t k = 0; k < at.size() / 3; ++k) {
        if (other == s.id && k == i) continue;
        double square = 0;
        for (std::size_t d = 0; d < 3; ++d)
          square += (at[3 * k + d] - double(x[static_cast<int>(d)])) * (at[3 * k + d] - double(x[static_cast<int>(d)]));
        if (square < least) least = square, j = k;
      }
    }
    s.system.attach_point(s.id, i, other, j);
  }
}

template <class S>
void soft_attach(const Object<S>& s, lua_State* L) {
  const std::vector<std::uint32_t> points = points_argument(L, s);
  if (has_method(L, 3, "attach"))
    return attach_to_soft(s, L, points, check_object(L, 3, s.record, std::string(function_name(L)) + ".other"));
  const ObjectId body = check_object(L, 3, s.record, std::string(function_name(L)) + ".body", "body");
  const bool has_place = !lua_isnoneornil(L, 4);
  if (has_place && points.size() > 1)
    fail_here(L, "expected no place for " + describe(L, 2) + ": it is several points");
  const Vec3 place = has_place ? vector_argument(L, 4, s.record.planar()) : Vec3(Vec3::Zero());
  const Pose pose = pose_of(L, s.record, body);
  for (const std::uint32_t i : points)
    s.system.attach(s.id, i, body, has_place ? place : to_local(pose, s.system.point(s.id, i)));
}

}  // namespace feder::lua
