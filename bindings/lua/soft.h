// Methods that all soft things have, beside those of their system: what is of one point or of all, and attachments. A
// part says with SoftPoints<S> what the points of system S are called. Points count from 1 in Lua.
#pragma once
#include "lua/method.h"

namespace feder::lua {

// Of one, or of all.
template <class S>
double soft_mass(const Object<S>& s, lua_State* L) {
  if (!lua_isnoneornil(L, 2)) return s.system.point_mass(s.id, point_argument(L, s, 2));
  double sum = 0;
  for (std::size_t i = 0; i < SoftPoints<S>::count(s.system, s.id); ++i) sum += s.system.point_mass(s.id, i);
  return sum;
}

template <class S>
void soft_attach(const Object<S>& s, lua_State* L) {
  const std::size_t i = point_argument(L, s, 2);
  const ObjectId body = check_object(L, 3, s.record, std::string(function_name(L)) + ".body", "body");
  const Vec3 local = lua_isnoneornil(L, 4) ? to_local(pose_of(L, s.record, body), s.system.point(s.id, i))
                                           : vector_argument(L, 4, s.record.planar());
  s.system.attach(s.id, i, body, local);
}

}  // namespace feder::lua
