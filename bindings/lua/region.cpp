// world:region{ ... }: a static sensor that reports what enters and leaves.
#include "lua/objects.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

int region_position(lua_State* L) {
  Self self = check_self(L);
  return push_vector(L, self.record.rigid().pose(self.id).position);
}

int region_set_position(lua_State* L) {
  Self self = check_self(L);
  Rigid& rigid = self.record.rigid();
  rigid.set_pose(self.id, {vector_argument(L, 2, self.record.planar()), rigid.pose(self.id).rotation});
  return return_self(L);
}

int region_set_rotation(lua_State* L) {
  Self self = check_self(L);
  Rigid& rigid = self.record.rigid();
  rigid.set_pose(self.id, {rigid.pose(self.id).position, check_rotation(L, 2, function_name(L))});
  return return_self(L);
}

const Method kRegionMethods[] = {
    {"position", guard<region_position>, "region:position() -> x, y, z", "m"},
    {"set_position", guard<region_set_position>, "region:set_position(x, y, z) -> self", "m"},
    {"set_rotation", guard<region_set_rotation>, "region:set_rotation{...} -> self",
     "{x, y, z, w} or {axis =, angle =}"},
};

}  // namespace

std::span<const Method> region_methods() { return kRegionMethods; }

// {min, max} corners as a shape and its centre.
bool box_option(Options& o, ShapePtr& shape, Vec3& center) {
  if (!o.push("box", LUA_TTABLE, "{ {x, y, z}, {x, y, z} }")) return false;
  lua_State* L = o.L();
  if (lua_rawlen(L, -1) != 2)
    o.raise("box", "expected two corners { {x, y, z}, {x, y, z} }, got a table of " +
                       std::to_string(lua_rawlen(L, -1)) + " values");
  lua_rawgeti(L, -1, 1), lua_rawgeti(L, -2, 2);
  const Vec3 lo = check_vector(L, -2, o.path("box") + "[1]", o.planar()),
             hi = check_vector(L, -1, o.path("box") + "[2]", o.planar());
  lua_pop(L, 3);
  for (int k = 0; k < (o.planar() ? 2 : 3); ++k)
    if (!(hi[k] > lo[k]))
      o.raise("box", std::string("expected the second corner above the first, got ") + print_number(lo[k]) + " and " +
                         print_number(hi[k]) + " along " + "xyz"[k]);
  const Real depth = hi[2] > lo[2] ? hi[2] - lo[2] : Real(1);
  shape = make_box(hi[0] - lo[0], hi[1] - lo[1], depth);
  center = (lo + hi) * Real(0.5);
  return true;
}

int world_region(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  BodyDesc desc;
  desc.type = BodyType::fixed;
  desc.sensor = true;
  o.text("name", desc.name);
  const bool has_box = box_option(o, desc.shape, desc.position);
  if (!has_box && !shape_option(o, "shape", desc.shape))
    o.raise(nullptr, "expected box = {min, max} or shape =, got neither");
  if (has_box && (o.has("shape") || o.has("position"))) o.raise("box", "expected box or shape and position, got both");
  o.vector("position", desc.position);
  o.rotation("rotation", desc.rotation);
  std::int64_t bits = 0;
  if (o.integer("group", bits, 0, 0xffffffffll)) desc.group = static_cast<std::uint32_t>(bits);
  if (o.integer("mask", bits, 0, 0xffffffffll)) desc.mask = static_cast<std::uint32_t>(bits);
  o.has("tags"), o.has("shape");
  o.finish();
  desc.tags = tag_option(o, r);
  const ObjectId id = r.rigid().add_body(desc);
  r.regions.insert(id);
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
