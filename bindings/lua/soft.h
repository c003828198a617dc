// Methods that all soft things have: points that are read, moved, pushed, pinned and attached. A part gives its system
// as S, and says with SoftPoints<S> what it calls them. Points count from 1 in Lua.
#pragma once
#include "lua/buffer.h"
#include "lua/objects.h"

namespace feder::lua {

template <class S>
struct SoftPoints;  // static constexpr const char* kOne ("vertex"); static std::size_t count(const S&, ObjectId)

template <class S>
struct Soft {
  Self self;
  S& system;

  explicit Soft(lua_State* L) : self(check_self(L)), system(self.world.need<S>()) {}
  std::size_t count() const { return SoftPoints<S>::count(system, self.id); }
  // The argument as an index from 0.
  std::size_t point(lua_State* L, int index = 2) const { return number_in(L, index, count(), SoftPoints<S>::kOne); }
  Vec3 vector(lua_State* L, int index) const { return vector_argument(L, index, self.record.planar()); }
};

template <class S, Vec3 (S::*Read)(ObjectId, std::size_t) const>
int soft_read(lua_State* L) {
  const Soft<S> s(L);
  return push_vector(L, (s.system.*Read)(s.self.id, s.point(L)));
}

template <class S, void (S::*Write)(ObjectId, std::size_t, const Vec3&)>
int soft_write(lua_State* L) {
  const Soft<S> s(L);
  const std::size_t i = s.point(L);
  (s.system.*Write)(s.self.id, i, s.vector(L, 3));
  return return_self(L);
}

template <class S, void (S::*Change)(ObjectId, std::size_t)>
int soft_change(lua_State* L) {
  const Soft<S> s(L);
  (s.system.*Change)(s.self.id, s.point(L));
  return return_self(L);
}

template <class S>
int soft_pinned(lua_State* L) {
  const Soft<S> s(L);
  lua_pushboolean(L, s.system.pinned(s.self.id, s.point(L)));
  return 1;
}

// Of one, or of all.
template <class S>
int soft_mass(lua_State* L) {
  const Soft<S> s(L);
  double sum = 0;
  if (!lua_isnoneornil(L, 2))
    sum = s.system.point_mass(s.self.id, s.point(L));
  else
    for (std::size_t i = 0; i < s.count(); ++i) sum += s.system.point_mass(s.self.id, i);
  lua_pushnumber(L, sum);
  return 1;
}

template <class S>
int soft_attach(lua_State* L) {
  const Soft<S> s(L);
  const std::size_t i = s.point(L);
  const ObjectId body = check_object(L, 3, s.self.record, std::string(function_name(L)) + ".body", "body");
  const Vec3 local =
      lua_isnoneornil(L, 4) ? to_local(pose_of(L, s.self.record, body), s.system.point(s.self.id, i)) : s.vector(L, 4);
  s.system.attach(s.self.id, i, body, local);
  return return_self(L);
}

template <class S, void (S::*Read)(ObjectId, std::vector<Vec3>&) const>
int soft_vectors(lua_State* L) {
  const Soft<S> s(L);
  std::vector<Vec3> all;
  (s.system.*Read)(s.self.id, all);
  return push_vectors(L, all);
}

}  // namespace feder::lua
