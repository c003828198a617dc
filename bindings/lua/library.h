// Files of scripts: require and feder.load. Names cannot leave the library folders and the scene's own folder.
#pragma once
#include "lua/options.h"
#include "lua/state.h"

namespace feder::lua {

// "feder.cloth": a module of feder's own that this build lacks?
bool is_left_out(const std::string& name);
int lua_require(lua_State* L);
int feder_load(lua_State* L);
int feder_load_mesh(lua_State* L);
std::vector<OptionInfo> load_mesh_rows();
// Pushes what the text of a YAML file says, by the host's reader; its error has the location in the file.
void push_yaml(lua_State* L, const std::string& file, const std::string& text);
// Remembers that the script reads this file, for Script::files.
void record_file(State& s, const std::filesystem::path& file);
// Reads a file of at most 64 MB; SceneError when it cannot.
std::string read_text(const std::filesystem::path& file);
// The name of a file in messages: as short as it can be said from here, at most 58 characters.
std::string chunk_name(const std::filesystem::path& file);

}  // namespace feder::lua
