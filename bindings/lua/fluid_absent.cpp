// In place of fluid.cpp and fluid_make.cpp where the build leaves the module out.
#include "lua/objects.h"

namespace feder::lua {

int world_fluid(lua_State* L) { fail_here(L, "this build leaves out the module 'fluid'"); }
std::span<const Method> fluid_methods() { return {}; }
std::span<const Method> emitter_methods() { return {}; }
std::span<const Method> drain_methods() { return {}; }
void destroy_fluid_object(WorldRecord&, ObjectId, const std::string&) {}

}  // namespace feder::lua
