// Points of objects by their methods.
#include "lua/object_points.h"

#include <algorithm>
#include <cstring>

#include "lua/buffer.h"

namespace feder::lua {
namespace {

void add_point(lua_State* L, int index, Points& out, const char* method, std::initializer_list<double> numbers = {}) {
  const int n = call_method_of(L, index, method, numbers);
  for (int k = 0; k < 3; ++k) out.push_back(k < n ? lua_tonumber(L, k - n) : 0);
  lua_pop(L, n);
}

// Has a body's pose, or the centre of points.
bool take_sample(lua_State* L, ObjectSample& out) {
  const bool soft = has_method(L, -1, "positions");
  if (!soft && !has_method(L, -1, "position")) return false;
  const Points points = points_of(L, -1);
  out.parts = points.size() / 3;
  for (std::size_t i = 0; i < points.size(); ++i) out.position[i % 3] += points[i] / static_cast<double>(out.parts);
  out.turns = !soft && has_method(L, -1, "rotation");
  if (!out.turns) return true;
  const int n = call_method_of(L, -1, "rotation");
  for (int k = 0; k < 4 && k < n; ++k) out.rotation[k] = lua_tonumber(L, k - n);
  lua_pop(L, n);
  return true;
}

}  // namespace

bool has_method(lua_State* L, int index, const char* name) {
  const Handle* h = test_handle(L, index);
  const ObjectClass* row = h ? class_row(state(L), h->kind) : nullptr;
  return row && std::ranges::any_of(row->methods, [&](const Method& m) { return std::strcmp(m.name, name) == 0; });
}

int call_method_of(lua_State* L, int index, const char* name, std::initializer_list<double> numbers) {
  const int top = lua_gettop(L);
  index = lua_absindex(L, index);
  lua_getfield(L, index, name);
  lua_pushvalue(L, index);
  for (const double x : numbers) lua_pushnumber(L, x);
  lua_call(L, 1 + static_cast<int>(numbers.size()), LUA_MULTRET);
  return lua_gettop(L) - top;
}

Points points_of(lua_State* L, int index, bool frame) {
  Points out;
  if (has_method(L, index, "positions")) {
    call_method_of(L, index, "positions");
    const auto numbers = test_buffer(L, -1);
    out.assign(numbers.begin(), numbers.end());
    lua_pop(L, 1);
  } else if (has_method(L, index, "position")) {
    add_point(L, index, out, "position");
    if (frame && has_method(L, index, "world_point"))
      for (int k = 0; k < 3; ++k)
        add_point(L, index, out, "world_point", {k == 0 ? 1.0 : 0, k == 1 ? 1.0 : 0, k == 2 ? 1.0 : 0});
  } else {
    fail_here(L, "expected a body, net, cloth or fluid, got " + describe(L, index));
  }
  return out;
}

std::vector<ObjectSample> sample_objects(lua_State* L, WorldRecord& record) {
  std::vector<ObjectSample> out;
  const Objects& objects = record.world->objects();
  for (const SystemDescriptor* d : record.world->catalog())
    for (const ObjectKind kind : d->kinds)
      objects.for_each(kind, [&](ObjectId id) {
        ObjectSample sample;
        push_handle(L, record, id);
        if (take_sample(L, sample)) {
          sample.name = objects.describe(id);
          out.push_back(std::move(sample));
        }
        lua_pop(L, 1);
      });
  return out;
}

}  // namespace feder::lua
