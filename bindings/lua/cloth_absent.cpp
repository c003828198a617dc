// In place of cloth.cpp and cloth_make.cpp where the build leaves the module out.
#include "lua/objects.h"

namespace feder::lua {

int world_cloth(lua_State* L) { fail_here(L, "this build leaves out the module 'cloth'"); }
std::span<const Method> cloth_methods() { return {}; }
void destroy_cloth(WorldRecord&, ObjectId, const std::string&) {}
void clear_cloth_forces(World&) {}
void apply_to_cloth(WorldRecord&, const std::function<bool(ObjectId, TagMask)>&,
                    const std::function<Vec3(ObjectId, const Vec3&, const Vec3&, Real)>&) {}

}  // namespace feder::lua
