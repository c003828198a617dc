// Volumes in options tables: box = {min, max}, or a shape with its pose.
#include "lua/box_option.h"

#include "lua/shapes.h"

namespace feder::lua {
namespace {

// {min, max} as a shape and its centre.
bool box_option(Options& o, ShapePtr& shape, Vec3& center) {
  Vec3 lo, hi;
  if (!box_corners(o, lo, hi)) return false;
  const Real depth = hi[2] > lo[2] ? hi[2] - lo[2] : Real(1);
  shape = make_box(hi[0] - lo[0], hi[1] - lo[1], depth);
  center = (lo + hi) * Real(0.5);
  return true;
}

}  // namespace

bool box_corners(Options& o, Vec3& lo, Vec3& hi) {
  if (!o.push("box", LUA_TTABLE, "{ {x, y, z}, {x, y, z} }")) return false;
  lua_State* L = o.L();
  if (lua_rawlen(L, -1) != 2)
    o.raise("box", "expected two corners { {x, y, z}, {x, y, z} }, got a table of " +
                       std::to_string(lua_rawlen(L, -1)) + " values");
  lua_rawgeti(L, -1, 1), lua_rawgeti(L, -2, 2);
  lo = check_vector(L, -2, o.path("box") + "[1]", o.planar());
  hi = check_vector(L, -1, o.path("box") + "[2]", o.planar());
  lua_pop(L, 3);
  for (int k = 0; k < (o.planar() ? 2 : 3); ++k)
    if (!(hi[k] > lo[k]))
      o.raise("box", std::string("expected the second corner above the first, got ") + print_number(lo[k]) + " and " +
                         print_number(hi[k]) + " along " + "xyz"[k]);
  return true;
}

bool has_volume(Options& o) { return o.has("box") || o.has("shape") || o.has("position") || o.has("rotation"); }

void box_or_shape(Options& o, ShapePtr& shape, Vec3& position, Quat& rotation) {
  const bool has_box = box_option(o, shape, position);
  if (!has_box && !shape_option(o, "shape", shape))
    o.raise(nullptr, "expected box = {min, max} or shape =, got neither");
  if (has_box && (o.has("shape") || o.has("position"))) o.raise("box", "expected box or shape and position, got both");
  o.vector("position", position);
  o.rotation("rotation", rotation);
}

}  // namespace feder::lua
