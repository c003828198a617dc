// What the binding keeps per world, and the handles of scripts: full userdata that hold ids and generations, cached
// weakly so that == is identity. The world owns; collecting a handle destroys nothing.
#pragma once
#include <map>
#include <string>

#include "feder/lua.h"
#include "feder/world.h"
#include "lua/events.h"
#include "lua/force.h"
#include "lua/observe.h"
#include "lua/options.h"
#include "lua/part.h"
#include "lua/state.h"
#include "lua/tasks.h"

namespace feder::lua {

struct Material {
  bool has_friction = false, has_restitution = false, has_density = false, has_rolling = false;
  Real friction_static = 0, friction_dynamic = 0, restitution = 0, density = 0, rolling_friction = 0;
  bool has_color = false;
  std::uint32_t color = 0;  // 0xrrggbb
};

struct NamedMaterialPair {
  std::string a, b;
  bool has_friction = false;
  Real friction_static = -1, friction_dynamic = -1, restitution = -1;
};

// How to make a world.
struct WorldSettings {
  WorldDesc desc;
  std::map<std::string, Material> materials;
  std::vector<NamedMaterialPair> material_pairs;
};

// Of the owner keys of snapshots: random, and never part of a result.
struct SipKey {
  std::uint64_t a = 0, b = 0;
};

struct WorldRecord {
  std::uint32_t id = 0;
  SipKey key;
  std::unique_ptr<World> world;         // null when closed
  int cache_ref = LUA_NOREF;            // weak table: object -> handle
  bool busy = false;                    // a step or its handlers run
  bool read_only = false;               // a stage of a step asks a script: nothing may be edited
  lua_State* stepping = nullptr;        // while the world steps: what forces call
  std::vector<Failure> stage_failures;  // of this step, to be raised behind it
  bool has_pairs = false;               // material pairs were given to the system that uses them
  WorldSettings settings;
  Subscriptions subscriptions;
  Timers timers;
  Tasks tasks;
  std::vector<ScriptForce> forces;
  std::vector<ScriptForce> lost_forces;  // that snapshots may bring back
  bool has_snapshots = false;
  std::map<ObjectId, Class> special;  // objects whose class has another name than their kind: regions are bodies
  Appearance appearance;
  Observed observed;

  bool planar() const { return settings.desc.dimension == 2; }
};

struct WorldBlock {
  std::uint32_t world;
};

struct Handle {
  std::uint32_t world = 0;
  Class kind = Class::force;
  bool dead = false;  // destroyed for sure: name and location are in user values 2 and 3
  ObjectId id;
};

// A living object in its world.
struct Self {
  WorldRecord& record;
  World& world;
  ObjectId id;
};

std::string hash_text(std::uint64_t hash);  // 16 hex digits

// Makes a world and pushes its userdata.
WorldRecord& push_new_world(lua_State* L, const WorldSettings& settings);
void push_world(lua_State* L, const WorldRecord& record);
// The world's table of callbacks: integer -> function or coroutine.
void push_data(lua_State* L, const WorldRecord& record);
int keep(lua_State* L, WorldRecord& record, int index);  // stores the value at `index` there; returns its key
void drop(lua_State* L, WorldRecord& record, int key);
void close_world(lua_State* L, WorldRecord& record);

// `self` of a world method; an error when it is something else or closed.
WorldRecord& check_world(lua_State* L);
// The same for objects; an error that names a destroyed one.
Self check_self(lua_State* L);
// Any object handle at `index`, dead or alive; null when it is none.
Handle* test_handle(lua_State* L, int index);
// A living object of that world at `index`. `what` is named in messages.
ObjectId check_object(lua_State* L, int index, WorldRecord& record, const std::string& what);
// The same, of that class.
ObjectId check_object(lua_State* L, int index, WorldRecord& record, const std::string& what, const char* name);
// Reads an option that holds an object.
bool object_option(Options& o, const char* key, WorldRecord& record, ObjectId& out);

void push_handle(lua_State* L, WorldRecord& record, ObjectId id);
// Destroys the object, with whatever depends on it; handles learn name and location.
void destroy_object(lua_State* L, WorldRecord& record, ObjectId id, const std::string& where);
// Before and after restore: handles learn their names, and which objects are no more.
void record_names(lua_State* L, WorldRecord& record);
void invalidate_lost(lua_State* L, WorldRecord& record, const std::string& where);
std::string describe_object(lua_State* L, int index, Class c);
Class class_of(const State& s, const WorldRecord& record, ObjectId id);

TagMask tag_option(Options& o, WorldRecord& record);  // "tags"
void open_classes(lua_State* L);

std::span<const Method> object_methods();  // of every object

}  // namespace feder::lua
