// world:region{ ... }: a static sensor that reports what enters and leaves.
#include "lua/box_option.h"
#include "lua/rigid_part.h"

namespace feder::lua {
namespace {

using Region = Object<Rigid>;

Vec3 region_position(const Region& r) { return r.system.pose(r.id).position; }

void region_set_position(const Region& r, const Vec3& position) {
  r.system.set_pose(r.id, {position, r.system.pose(r.id).rotation});
}

void region_set_rotation(const Region& r, lua_State* L) {
  r.system.set_pose(r.id, {r.system.pose(r.id).position, check_rotation(L, 2, function_name(L))});
}

const Method kRegionMethods[] = {
    {"position", method<region_position>, "region:position() -> x, y, z", "m"},
    {"set_position", method<region_set_position>, "region:set_position(x, y, z) -> self", "m"},
    {"set_rotation", method<region_set_rotation>, "region:set_rotation{...} -> self",
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

ObjectId world_region(WorldRecord& r, lua_State* L) {
  BodyDesc desc = read_description(L, r, kRegion);
  desc.type = BodyType::fixed;
  desc.sensor = true;
  const ObjectId id = system_of<Rigid>(r).add_body(desc);
  r.special[id] = object_class(state(L), "region");
  return id;
}

}  // namespace feder::lua
