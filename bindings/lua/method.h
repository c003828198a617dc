// C++ functions as methods of Lua: method<F> reads self and the arguments of F by their types and pushes what F
// returns; where F returns nothing, the method returns self. F is one of
//  - a member of a system, with the object's id in front: &Rigid::mass, &Cloth::set_point;
//  - a member of World without arguments: &World::time;
//  - a function of self: f(const Object<Rigid>&, ...), f(const Self&, ...), f(WorldRecord&, ...);
//  - or of the Lua state alone: f(lua_State*).
// Arguments: Vec3 (numbers or a table, planar as the world is), bool, std::size_t (a point, see SoftPoints), and
// lua_State* for what no type says. Numbers, wrong types and destroyed objects: tests/lua/test_hostile.cpp.
#pragma once
#include <tuple>

#include "lua/buffer.h"
#include "lua/objects.h"
#include "lua/stack.h"

namespace feder::lua {

// The system of a world, made on first use.
template <class S>
S& system_of(WorldRecord& record) {
  return record.world->need<S>();
}

// A living object of a system: self of its methods.
template <class S>
struct Object : Self {
  S& system;
  explicit Object(lua_State* L) : Self(check_self(L)), system(system_of<S>(record)) {}
};

// Of systems whose objects have points: static constexpr const char* kOne, what one is called ("vertex"), and
// static std::size_t count(const S&, ObjectId).
template <class S>
struct SoftPoints;

// The argument, a number from 1 on, as the index of a point.
template <class S>
std::size_t point_argument(lua_State* L, const Object<S>& self, int index) {
  return number_in(L, index, SoftPoints<S>::count(self.system, self.id), SoftPoints<S>::kOne);
}

inline WorldRecord& record_of_self(WorldRecord& record) { return record; }
inline WorldRecord& record_of_self(const Self& self) { return self.record; }

template <class This>
This self_of(lua_State* L) {
  if constexpr (std::same_as<This, Self>)
    return check_self(L);
  else
    return This(L);
}

// The argument at `index`, which moves on to the next.
template <class T, class This>
T argument(lua_State* L, This& self, int& index) {
  if constexpr (std::same_as<T, Vec3>)
    return vector_argument(L, index, record_of_self(self).planar(), &index);
  else if constexpr (std::same_as<T, bool>)
    return flag_argument(L, index++);
  else if constexpr (std::same_as<T, std::size_t>)
    return point_argument(L, self, index++);
  else
    return L;
}

template <class... Arguments, class This, class F>
int answer(lua_State* L, This& self, F&& f) {
  [[maybe_unused]] int index = 2;
  const std::tuple<std::decay_t<Arguments>...> arguments{argument<std::decay_t<Arguments>>(L, self, index)...};
  using Result = std::decay_t<decltype(std::apply(f, arguments))>;
  if constexpr (std::is_void_v<Result>) {
    std::apply(f, arguments);
    return return_self(L);
  } else if constexpr (std::same_as<Result, ObjectId>) {
    push_handle(L, record_of_self(self), std::apply(f, arguments));
    return 1;
  } else {
    return push(L, std::apply(f, arguments));
  }
}

template <class R, class S, class... A>
int call(lua_State* L, R (S::*f)(ObjectId, A...)) {
  Object<S> self(L);
  return answer<A...>(L, self, [&](const auto&... a) { return (self.system.*f)(self.id, a...); });
}
template <class R, class S, class... A>
int call(lua_State* L, R (S::*f)(ObjectId, A...) const) {
  Object<S> self(L);
  return answer<A...>(L, self, [&](const auto&... a) { return (self.system.*f)(self.id, a...); });
}
template <class R>
int call(lua_State* L, R (World::*f)() const) {
  WorldRecord& record = check_world(L);
  return answer(L, record, [&] { return (record.world.get()->*f)(); });
}
template <class R, class This, class... A>
int call(lua_State* L, R (*f)(const This&, A...)) {
  const This self = self_of<This>(L);
  return answer<A...>(L, self, [&](const auto&... a) { return f(self, a...); });
}
template <class R, class... A>
int call(lua_State* L, R (*f)(WorldRecord&, A...)) {
  WorldRecord& record = check_world(L);
  return answer<A...>(L, record, [&](const auto&... a) { return f(record, a...); });
}
template <class R>
int call(lua_State* L, R (*f)(lua_State*)) {
  return push(L, f(L));
}

template <auto F>
int call_method(lua_State* L) {
  return call(L, F);
}
template <auto F>
inline constexpr lua_CFunction method = guard<call_method<F>>;

// What a member of a system lists of an object, three numbers each, in a buffer: &Cloth::normals.
template <class S, void (S::*List)(ObjectId, std::vector<Vec3>&) const>
int list_vectors(lua_State* L) {
  const Object<S> self(L);
  std::vector<Vec3> all;
  (self.system.*List)(self.id, all);
  return push_vectors(L, all);
}

// The options of the running maker, the table at 2, with the tags that every object may have.
template <class Desc, std::size_t N>
Desc read_description(lua_State* L, WorldRecord& record, const Option<Desc> (&rows)[N]) {
  Options o(L, 2, function_name(L), record.planar());
  Desc made;
  if constexpr (requires { made.record; }) made.record = &record;
  o.read(rows, made);
  made.tags = tag_option(o, record);
  return made;
}

// Takes an object out of the world, and nothing else with it: &Cloth::destroy_cloth.
template <auto Destroy>
std::vector<ObjectId> destroy_alone(WorldRecord& record, ObjectId id, const std::string& where) {
  const auto destroy = [&]<class S, class Text>(void (S::*f)(ObjectId, Text)) { (system_of<S>(record).*f)(id, where); };
  destroy(Destroy);
  return {};
}

}  // namespace feder::lua
