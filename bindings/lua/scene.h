// Scenes: feder.scene{...}, build, update, check, and scenes written in YAML.
#pragma once
#include "lua/records.h"

namespace feder::lua {

int feder_scene(lua_State* L);
// Takes what a file returned (on top of the stack) as the scene; false when it returned nothing: a plain script.
bool take_scene(lua_State* L, const std::string& file);
// Makes the scene's world and calls build(). Called with pcall: raises Lua errors.
int build_scene(lua_State* L);
// After a step of the scene's world.
void run_update(lua_State* L, WorldRecord& record);
CheckResult run_check(lua_State* L);
// Pushes the scene's member `name`; the copy of the scene that callbacks see.
void push_callback(lua_State* L, const char* name);
void push_scene_world(lua_State* L);
// A scene from the table that a YAML file holds (on top of the stack); replaces it by a scene table.
void yaml_to_scene(lua_State* L, const std::string& file);

std::vector<OptionInfo> scene_rows();

}  // namespace feder::lua
