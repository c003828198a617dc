// world:region{ ... }: a static sensor that reports what enters and leaves.
#include "lua/rigid_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

int region_position(lua_State* L) {
  Self self = check_self(L);
  return push_vector(L, lua::rigid(self.record).pose(self.id).position);
}

int region_set_position(lua_State* L) {
  Self self = check_self(L);
  Rigid& rigid = lua::rigid(self.record);
  rigid.set_pose(self.id, {vector_argument(L, 2, self.record.planar()), rigid.pose(self.id).rotation});
  return return_self(L);
}

int region_set_rotation(lua_State* L) {
  Self self = check_self(L);
  Rigid& rigid = lua::rigid(self.record);
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
  const ObjectId id = lua::rigid(r).add_body(desc);
  r.special[id] = object_class(state(L), "region");
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
