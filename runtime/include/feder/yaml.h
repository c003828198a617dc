// YAML text as Lua values, for lua::HostOptions::load_yaml. In the library feder::yaml
// (find_package(feder COMPONENTS yaml)). Keeps nothing between calls.
#pragma once
#include <string>

namespace feder::yaml {

// Pushes the document as one Lua value on the stack of `lua_state` (a lua_State*). Maps become tables, lists become
// tables counting from 1, null becomes nil; anchors, aliases and `<<` merges are expanded.
// Throws lua::ScriptError "file:line: message" for anything that is no plain data: syntax, duplicate or non-scalar
// keys, null in a list, unknown tags, several documents, and texts beyond the limits in document.h.
//
// Source positions are kept for later messages: registry["feder.places"] is a table with weak keys from a
// pushed table to { [key] = "file:line", [true] = "file:line of the table itself" }.
void push(void* lua_state, const std::string& file, const std::string& text);

// Checks a text without a Lua state: only the errors.
void check(const std::string& file, const std::string& text);

}  // namespace feder::yaml
