// The options of a world, from a script and from the command line.
#pragma once
#include "lua/options.h"
#include "lua/records.h"

namespace feder::lua {

// Reads feder.world's table (or a scene's `world`) at `index`, then the host's overrides if wanted, and checks the
// result: every named system is made once in a world that is thrown away, so that a wrong option is an error here and
// not later.
WorldSettings read_world_options(lua_State* L, int index, const std::string& owner, bool overrides = true);

std::vector<OptionInfo> world_rows();
// Keys of a scene that belong into its world: options of worlds, and systems. `is`: " = " or, in YAML, ": ".
void misplace_world_options(Options& scene, Catalog systems, const std::string& is);
std::vector<std::string> material_names(const WorldSettings& settings);

// key = number | { static =, dynamic = }, of which one may be missing; and that table alone.
void friction_table(Options& o, Real& fixed, Real& dynamic);
bool friction_option(Options& o, const char* key, Real& fixed, Real& dynamic);
std::vector<OptionInfo> friction_rows();

}  // namespace feder::lua
