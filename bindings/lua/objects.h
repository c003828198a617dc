// The makers of objects and their methods: one file each (body_make.cpp, body.cpp, joint.cpp, net_make.cpp, net.cpp,
// region.cpp), plus the queries and the world's own methods.
#pragma once
#include <functional>

#include "lua/records.h"

namespace feder::lua {

int world_body(lua_State* L);
int world_joint(lua_State* L);
int world_net(lua_State* L);
int world_region(lua_State* L);
int world_cloth(lua_State* L);
int world_fluid(lua_State* L);

std::span<const Method> body_methods();
std::span<const Method> joint_methods();
std::span<const Method> net_methods();
std::span<const Method> region_methods();
std::span<const Method> cloth_methods();  // empty where the module is left out
void destroy_cloth(WorldRecord& record, ObjectId id, const std::string& where);
void clear_cloth_forces(World& world);
// Forces of scripts on the vertices of cloth: evaluate(position, velocity, mass, sum) for those that `acts` accepts.
void apply_to_cloth(WorldRecord& record, const std::function<bool(ObjectId, TagMask)>& acts,
                    const std::function<Vec3(ObjectId, const Vec3&, const Vec3&, Real)>& evaluate);
std::span<const Method> fluid_methods();  // this and the next two are empty where the module is left out
std::span<const Method> emitter_methods();
std::span<const Method> drain_methods();
void destroy_fluid_object(WorldRecord& record, ObjectId id, const std::string& where);  // a fluid, emitter or drain
std::span<const Method> query_methods();
std::span<const Method> world_methods();

BodyType body_type_from_name(lua_State* L, int index);
const char* body_type_name(BodyType type);
// friction = number | { static =, dynamic = }, of an options table.
bool friction_option(Options& o, Real& fixed, Real& dynamic);
bool box_option(Options& o, ShapePtr& shape, Vec3& center);  // box = {min, max}
SpringDesc read_spring(Options& o, std::size_t point_count);
int push_vector(lua_State* L, const Vec3& v);  // three numbers
inline int return_self(lua_State* L) {
  lua_settop(L, 1);
  return 1;
}

}  // namespace feder::lua
