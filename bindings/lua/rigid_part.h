// Bodies, joints, regions and queries in Lua.
#pragma once
#include "feder/query.h"
#include "feder/rigid.h"
#include "lua/method.h"

namespace feder::lua {

inline constexpr const char *kSensorAll = "all", *kSensorValues = "true, false or \"all\"";

const Part& rigid_part();

template <>
Rigid& system_of<Rigid>(WorldRecord& record);  // with the material pairs

ObjectId world_body(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> body_rows();
ObjectId world_joint(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> joint_rows();
ObjectId world_region(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> region_rows();
std::span<const Method> body_methods();
std::span<const Method> joint_methods();
std::span<const Method> region_methods();
std::span<const Method> query_methods();

BodyType body_type_from_name(lua_State* L, int index);
const char* body_type_name(BodyType type);

}  // namespace feder::lua
