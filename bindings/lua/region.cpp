// world:region{ ... }: a static sensor that reports what enters and leaves.
#include "lua/box_option.h"
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

void read_box(Options& o, const OptionRow&, BodyDesc& d) { box_or_shape(o, d.shape, d.position, d.rotation); }

constexpr Option<BodyDesc> kRegion[] = {
    field<&BodyDesc::name>("name"),
    box_row(read_box),
    later<BodyDesc>("shape", "shape"),
    later<BodyDesc>("position", "vector", "m"),
    later<BodyDesc>("rotation", "rotation"),
    field<&BodyDesc::group>("group", "", kBits),
    field<&BodyDesc::mask>("mask", "", kBits),
    later<BodyDesc>("tags", kWordsType),
};

}  // namespace

std::vector<OptionInfo> region_rows() { return describe_rows(kRegion); }

std::span<const Method> region_methods() { return kRegionMethods; }

int world_region(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  BodyDesc desc;
  desc.type = BodyType::fixed;
  desc.sensor = true;
  o.read(kRegion, desc);
  desc.tags = tag_option(o, r);
  const ObjectId id = lua::rigid(r).add_body(desc);
  r.special[id] = object_class(state(L), "region");
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
