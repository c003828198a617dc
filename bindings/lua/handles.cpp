// Handles and worlds as userdata.
#include <random>

#include "lua/method.h"

namespace feder::lua {
namespace {

lua_Integer cache_key(ObjectId id) {
  return static_cast<lua_Integer>(static_cast<std::uint64_t>(id.generation) << 32 | id.slot);
}

WorldRecord* record_of(lua_State* L, std::uint32_t id) {
  State& s = state(L);
  return id < s.worlds.size() ? s.worlds[id].get() : nullptr;
}

// Pushes the name; "" when nobody remembers.
void push_name(lua_State* L, int index, const Handle& h) {
  index = lua_absindex(L, index);
  if (h.dead) {
    lua_getiuservalue(L, index, 2);
    return;
  }
  const WorldRecord* r = record_of(L, h.world);
  lua_pushstring(L, r && r->world ? r->world->objects().name(h.id).c_str() : "");
}

std::string describe_handle(lua_State* L, int index, const Handle& h) {
  push_name(L, index, h);
  const std::string name(text_at(L, -1));
  lua_pop(L, 1);
  const std::string kind = class_name(state(L), h.kind);
  return name.empty() ? kind + " #" + std::to_string(h.id.slot) : kind + " \"" + name + "\"";
}

bool is_alive(lua_State* L, const Handle& h) {
  const WorldRecord* r = record_of(L, h.world);
  return !h.dead && r && r->world && r->world->objects().alive(h.id);
}

[[noreturn]] void fail_dead(lua_State* L, int index, const Handle& h, const std::string& before) {
  index = lua_absindex(L, index);
  const WorldRecord* r = record_of(L, h.world);
  const std::string what = before + describe_handle(L, index, h);
  if (!r || !r->world) fail(L, what + " belongs to a closed world");
  std::string where;
  if (h.dead) {
    lua_getiuservalue(L, index, 3);
    where = text_at(L, -1);
    lua_pop(L, 1);
  } else {
    where = r->world->objects().destroyed_at(h.id);
  }
  fail(L, what + " was destroyed" + (where.empty() ? "" : " at " + where));
}

// Leaves name and location in the handle, if a script holds one.
void invalidate(lua_State* L, WorldRecord& record, ObjectId id, const std::string& name, const std::string& where) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, record.cache_ref);
  if (lua_rawgeti(L, -1, cache_key(id)) == LUA_TUSERDATA) {
    static_cast<Handle*>(lua_touserdata(L, -1))->dead = true;
    lua_pushstring(L, name.c_str());
    lua_setiuservalue(L, -2, 2);
    lua_pushstring(L, where.c_str());
    lua_setiuservalue(L, -2, 3);
  }
  lua_pop(L, 2);
}

int world_collected(lua_State* L) {
  const auto* block = static_cast<const WorldBlock*>(lua_touserdata(L, 1));
  if (WorldRecord* r = block ? record_of(L, block->world) : nullptr) close_world(L, *r);
  return 0;
}

std::string handle_tostring(lua_State* L) {
  const Handle* h = test_handle(L, 1);
  return h ? describe_handle(L, 1, *h) : "?";
}

std::string world_tostring(lua_State* L) {
  const auto* block = static_cast<const WorldBlock*>(test_class(L, 1, Class::world));
  return block ? "world #" + std::to_string(block->world + 1) : "?";
}

Handle& self_handle(lua_State* L) {
  void* block = self_block(L);
  if (!block) {
    const std::string name = function_name(L);
    wrong_self(L, name.substr(0, name.find(':')).c_str());
  }
  return *static_cast<Handle*>(block);
}

bool object_alive(lua_State* L) { return is_alive(L, self_handle(L)); }
const char* object_kind(lua_State* L) { return class_name(state(L), self_handle(L).kind); }

int object_name(lua_State* L) {
  push_name(L, 1, self_handle(L));
  return 1;
}

int object_destroy(lua_State* L) {
  Self self = check_self(L);
  destroy_object(L, self.record, self.id, short_location(L));
  return 0;
}

int object_on(lua_State* L) {
  Self self = check_self(L);
  return push_subscription(L, self.record, self.id);
}

int object_tags(lua_State* L) {
  Self self = check_self(L);
  const Objects& objects = self.world.objects();
  const TagMask tags = objects.tags(self.id);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < objects.tag_names().size(); ++i)
    if (tags >> i & 1) names.push_back(objects.tag_names()[i]);
  push_list(L, names, [&](const std::string& name) { push(L, name); });
  return 1;
}

const Method kObjectMethods[] = {
    {"alive", method<object_alive>, "h:alive() -> boolean", "is the object still there?"},
    {"kind", method<object_kind>, "h:kind() -> string", "the name of its class: \"body\", \"force\" ..."},
    {"name", guard<object_name>, "h:name() -> string", "the name it was made with, or \"\"; also of the destroyed"},
    {"destroy", guard<object_destroy>, "h:destroy()", "takes the object, and what hangs on it, out of the world"},
    {"on", guard<object_on>, "h:on(kind, [filter], fn) -> connection", "events of this object; it is e.a in contacts"},
    {"tags", guard<object_tags>, "h:tags() -> {string, ...}", "the tags it was made with"},
};

}  // namespace

Class class_of(const State& s, const WorldRecord& record, ObjectId id) {
  if (const auto found = record.special.find(id); found != record.special.end()) return found->second;
  return object_class(s, record.world->objects().kind(id).text());
}

std::span<const Method> object_methods() { return kObjectMethods; }

WorldRecord& push_new_world(lua_State* L, const WorldSettings& settings) {
  State& s = state(L);
  std::size_t open = 0;
  for (const auto& r : s.worlds) open += r->world != nullptr;
  // the collector does not see how large a world is
  if (open >= 8) lua_gc(L, LUA_GCCOLLECT, 0);
  if (open >= 1000) fail_here(L, "expected at most 1000 open worlds");
  auto record = std::make_unique<WorldRecord>();
  record->id = static_cast<std::uint32_t>(s.worlds.size());
  record->settings = settings;
  std::random_device random;
  const auto word = [&random] { return static_cast<std::uint64_t>(random()) << 32 | random(); };
  record->key.a = word(), record->key.b = word();
  record->world = std::make_unique<World>(settings.desc, s.options.systems, s.options.executor);
  if (s.options.made) s.options.made(*record->world);

  WorldBlock& block = push_userdata(L, Class::world, WorldBlock{kNone}, 1);
  lua_newtable(L);
  lua_setiuservalue(L, -2, 1);
  push_weak_table(L, "v");
  record->cache_ref = luaL_ref(L, LUA_REGISTRYINDEX);
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.worlds_ref);
  lua_pushvalue(L, -2);
  lua_rawseti(L, -2, static_cast<lua_Integer>(record->id) + 1);
  lua_pop(L, 1);
  block.world = record->id;
  s.worlds.push_back(std::move(record));
  return *s.worlds.back();
}

void push_world(lua_State* L, const WorldRecord& record) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, state(L).worlds_ref);
  lua_rawgeti(L, -1, static_cast<lua_Integer>(record.id) + 1);
  lua_remove(L, -2);
}

void push_data(lua_State* L, const WorldRecord& record) {
  push_world(L, record);
  lua_getiuservalue(L, -1, 1);
  lua_remove(L, -2);
}

int keep(lua_State* L, WorldRecord& record, int index) {
  index = lua_absindex(L, index);
  push_data(L, record);
  lua_pushvalue(L, index);
  const int key = luaL_ref(L, -2);
  lua_pop(L, 1);
  return key;
}

void drop(lua_State* L, WorldRecord& record, int key) {
  if (!key) return;
  push_data(L, record);
  if (lua_type(L, -1) == LUA_TTABLE) luaL_unref(L, -1, key);
  lua_pop(L, 1);
}

void close_world(lua_State* L, WorldRecord& record) {
  if (!record.world) return;
  luaL_unref(L, LUA_REGISTRYINDEX, record.cache_ref);
  record.cache_ref = LUA_NOREF;
  record.subscriptions = {};
  record.timers = {};
  record.tasks = {};
  record.forces = record.lost_forces = {};
  record.special.clear();
  record.world.reset();
}

// A force with stages = true is asked in the middle of a step.
static void check_not_asked(lua_State* L, const WorldRecord& r) {
  if (r.read_only && !answers_in_step(function_name(L)))
    fail_here(L, "the world is read-only while a force with stages = true is asked");
}

WorldRecord& check_world(lua_State* L) {
  const auto* block = static_cast<const WorldBlock*>(self_block(L));
  if (!block) wrong_self(L, "world");
  WorldRecord* r = record_of(L, block->world);
  if (!r || !r->world) fail_here(L, "the world is closed");
  check_not_asked(L, *r);
  return *r;
}

Self check_self(lua_State* L) {
  const Handle& h = self_handle(L);
  WorldRecord* r = record_of(L, h.world);
  if (h.dead || !r || !r->world || !r->world->objects().alive(h.id))
    fail_dead(L, 1, h, std::string(function_name(L)) + ": ");
  check_not_asked(L, *r);
  return {*r, *r->world, h.id};
}

// Calls f(class) for the classes whose userdata are handles, until it says true.
template <class F>
static void find_handle_class(const State& s, F&& f) {
  for (int c = 0; c < static_cast<int>(s.class_ref.size()); ++c) {
    const bool own = c < kOwnClasses;
    const auto kind = static_cast<Class>(c);
    if ((!own || kind == Class::force || kind == Class::object) && f(kind)) return;
  }
}

Handle* test_handle(lua_State* L, int index) {
  void* block = nullptr;
  find_handle_class(state(L), [&](Class c) { return (block = test_class(L, index, c)) != nullptr; });
  return static_cast<Handle*>(block);
}

ObjectId check_object(lua_State* L, int index, WorldRecord& record, const std::string& what) {
  const Handle* h = test_handle(L, index);
  if (!h) fail(L, what + ": expected an object of the world, got " + describe(L, index));
  if (!is_alive(L, *h)) fail_dead(L, index, *h, what + ": ");
  if (h->world != record.id) fail(L, what + ": " + describe_handle(L, index, *h) + " belongs to another world");
  return h->id;
}

ObjectId check_object(lua_State* L, int index, WorldRecord& record, const std::string& what, const char* name) {
  const Handle* h = test_handle(L, index);
  if (!h || h->kind == Class::object || h->kind != object_class(state(L), name))
    fail(L, what + ": expected a " + name + ", got " + describe(L, index));
  return check_object(L, index, record, what);
}

bool object_option(Options& o, const char* key, WorldRecord& record, ObjectId& out) {
  if (!o.push_any(key)) return false;
  out = check_object(o.L(), -1, record, o.path(key));
  lua_pop(o.L(), 1);
  return true;
}

void push_handle(lua_State* L, WorldRecord& record, ObjectId id) {
  if (!id) {
    lua_pushnil(L);
    return;
  }
  lua_rawgeti(L, LUA_REGISTRYINDEX, record.cache_ref);
  if (lua_rawgeti(L, -1, cache_key(id)) == LUA_TUSERDATA) {
    lua_remove(L, -2);
    return;
  }
  lua_pop(L, 1);
  const Class kind = class_of(state(L), record, id);
  push_userdata(L, kind, Handle{record.id, kind, false, id}, 3);
  push_world(L, record);
  lua_setiuservalue(L, -2, 1);
  lua_pushvalue(L, -1);
  lua_rawseti(L, -3, cache_key(id));
  lua_remove(L, -2);
}

static void destroy_force(lua_State* L, WorldRecord& record, ObjectId id, const std::string& where) {
  record.world->remove_force(id, where);
  std::erase_if(record.forces, [&](const ScriptForce& f) {
    if (f.object != id) return false;
    if (record.has_snapshots)
      record.lost_forces.push_back(f);
    else
      drop(L, record, f.function);
    return true;
  });
  for (const Part* part : state(L).options.parts)
    if (part->clear_forces) part->clear_forces(*record.world);
}

void destroy_object(lua_State* L, WorldRecord& record, ObjectId id, const std::string& where) {
  const Objects& objects = record.world->objects();
  const std::string name = objects.name(id);
  std::vector<ObjectId> others;
  if (const ObjectClass* row = class_row(state(L), class_of(state(L), record, id)))
    others = row->destroy(record, id, where);
  else if (objects.kind(id) == kForceKind)
    destroy_force(L, record, id, where);
  else
    fail_here(L, "this host has no part that destroys " + objects.describe(id));
  invalidate(L, record, id, name, where);
  record.special.erase(id);
  for (ObjectId other : others) invalidate(L, record, other, objects.name(other), where);
}

// Calls f(handle) for what scripts hold, each on top of the stack meanwhile.
template <class F>
static void each_handle(lua_State* L, const WorldRecord& record, F&& f) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, record.cache_ref);
  for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) f(*static_cast<Handle*>(lua_touserdata(L, -1)));
  lua_pop(L, 1);
}

void record_names(lua_State* L, WorldRecord& record) {
  each_handle(L, record, [&](const Handle& h) {
    if (h.dead) return;
    push(L, record.world->objects().name(h.id));
    lua_setiuservalue(L, -2, 2);
  });
}

void invalidate_lost(lua_State* L, WorldRecord& record, const std::string& where) {
  const Objects& objects = record.world->objects();
  std::vector<ObjectId> lost;
  each_handle(L, record, [&](Handle& h) {
    const bool alive = objects.alive(h.id);
    if (!alive) lost.push_back(h.id);
    if (!alive && !h.dead) {
      push(L, where);
      lua_setiuservalue(L, -2, 3);
    }
    h.dead = !alive;
  });
  // ids of the lost are given again: their handles must never be found under them
  lua_rawgeti(L, LUA_REGISTRYINDEX, record.cache_ref);
  for (ObjectId id : lost) {
    lua_pushnil(L);
    lua_rawseti(L, -2, cache_key(id));
  }
  lua_pop(L, 1);
}

std::string describe_object(lua_State* L, int index, Class c) {
  if (const Handle* h = test_handle(L, index)) return describe_handle(L, index, *h);
  return std::string(c == Class::event ? "an " : "a ") + class_name(state(L), c);
}

TagMask tag_option(Options& o, WorldRecord& record) {
  std::vector<std::string> words;
  if (!o.words("tags", words)) return 0;
  for (const std::string& w : words)
    if (w.empty() || w.size() > 64)
      o.raise("tags", "expected words of 1 to 64 characters, got '" + w.substr(0, 64) + "'");
  // the world learns a tag only when there is room for all of them
  std::size_t fresh = 0;
  for (const std::string& w : words) fresh += record.world->objects().known_tag(w) == 0;
  if (record.world->objects().tag_names().size() + fresh > 64)
    o.raise("tags", "a world knows at most 64 different tags");
  TagMask mask = 0;
  for (const std::string& w : words) mask |= record.world->objects().tag_bit(w);
  return mask;
}

void open_classes(lua_State* L) {
  find_handle_class(state(L), [L](Class c) {
    set_metamethods(L, c, {{"__tostring", method<handle_tostring>}});
    return false;
  });
  set_metamethods(L, Class::world, {{"__tostring", method<world_tostring>}, {"__gc", world_collected}});
}

}  // namespace feder::lua
