// What a system adds to Lua: a part, one row in a file of its own (cloth_part.cpp). The binding itself knows no system;
// a host lists the parts that its scripts may use.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "lua/advice.h"
#include "lua/force.h"
#include "lua/state.h"

namespace feder::lua {

class Options;

// Objects of the world that scripts hold as handles.
struct ObjectClass {
  const char* name;                 // of the kind of its objects; of its own (region), see WorldRecord::special
  std::span<const Method> methods;  // besides those of every object
  // Takes one out of the world; reports what else went with it.
  std::vector<ObjectId> (*destroy)(WorldRecord& record, ObjectId id, const std::string& where);
  // The field of contact events that says where on it: "index" (a point) or "count".
  const char* contact_field = nullptr;
  bool takes_forces = false;                                 // `on` of world:force may name one
  Pose (*pose)(WorldRecord& record, ObjectId id) = nullptr;  // of bodies: what else may be attached to
  // Of those whose points forces may pick one by one.
  std::size_t (*point_count)(WorldRecord& record, ObjectId id) = nullptr;
};

// A list of scenes in YAML: each entry, a table on top of the stack, becomes an object and is popped.
struct YamlList {
  const char* key;
  void (*make)(lua_State* L, int world);
  // For a reference: the method of worlds whose options an entry has, and what it has besides them.
  const char* maker = nullptr;
  std::vector<OptionInfo> (*more)() = nullptr;
};

struct Part {
  const char* name;                           // of its module
  std::span<const Method> functions = {};     // of feder
  std::span<const Method> world = {};         // methods of worlds: makers, queries
  std::span<const ObjectClass> classes = {};  // of what they make
  std::span<const YamlList> yaml = {};
  void (*gravity_changed)(World& world) = nullptr;   // by a script
  void (*apply_forces)(ForceRun& forces) = nullptr;  // before a step: those of scripts
  void (*clear_forces)(World& world) = nullptr;      // a force of scripts has gone
  std::vector<Advice> (*advise)(World& world) = nullptr;
};

}  // namespace feder::lua
