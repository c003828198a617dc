// world:force: kinds of the runtime, formulas, or a Lua function that is asked before each step or at every stage.
#include "lua/force.h"

#include <algorithm>
#include <cmath>

#include "base/profile.h"
#include "lua/objects.h"

namespace feder::lua {
namespace {

// One evaluation. False: the function failed, or answered something else than three finite numbers.
bool evaluate(lua_State* L, WorldRecord& record, const ScriptForce& f, const Vec3& x, const Vec3& v, Real mass,
              Vec3& out) {
  State& s = state(L);
  push_data(L, record);
  lua_rawgeti(L, -1, f.function);
  lua_remove(L, -2);
  for (int i = 0; i < 3; ++i) lua_pushnumber(L, x[i]);
  for (int i = 0; i < 3; ++i) lua_pushnumber(L, v[i]);
  lua_pushnumber(L, mass);
  lua_pushnumber(L, record.world->time());
  Failure failure;
  if (!s.call(L, 8, 3, failure)) {
    s.report(failure);
    return false;
  }
  for (int i = 0; i < 3; ++i) {
    const int at = -3 + i;
    // nil counts as 0, so that a function may return nothing
    const double value = lua_isnil(L, at) ? 0 : lua_type(L, at) == LUA_TNUMBER ? lua_tonumber(L, at) : std::nan("");
    if (!(std::abs(value) <= kHuge)) {
      s.report({s.profile[f.profile].where, "world:force.each: expected three finite numbers, got " + describe(L, at)});
      lua_pop(L, 3);
      return false;
    }
    out[i] = static_cast<Real>(value);
  }
  lua_pop(L, 3);
  return true;
}

bool acts(const ScriptForce& f, ObjectId object, TagMask tags) {
  return f.all || (f.tags & tags) != 0 || f.target == object;
}

// Forces are read from a copy: a function may destroy forces, its own too.
void apply_to_bodies(lua_State* L, WorldRecord& record, ScriptForce& f, bool& failed) {
  Rigid* rigid = record.world->find<Rigid>();
  if (!rigid) return;
  const Objects& objects = record.world->objects();
  for (std::uint32_t i = 0; i < rigid->bodies().size() && !failed; ++i) {
    const Bodies& b = rigid->bodies();
    if (b.type[i] != BodyType::dynamic || !acts(f, b.object[i], objects.tags(b.object[i]))) continue;
    const ObjectId id = b.object[i];
    Vec3 force = Vec3::Zero();
    failed = !evaluate(L, record, f, b.position[i], b.velocity[i], b.mass[i], force);
    if (failed || !objects.alive(id)) continue;
    Vec3& held = f.held.try_emplace(i, force).first->second;
    // a sleeping body stays asleep under a force that it fell asleep with
    if (!rigid->bodies().awake[i] && length(force - held) <= Real(1e-3) * length(held)) continue;
    held = force;
    if (dot(force, force) > 0) rigid->apply_force(id, force, nullptr);
  }
}

void apply_to_nets(lua_State* L, WorldRecord& record, std::vector<ScriptForce>& forces, std::vector<char>& failed) {
  Springs* springs = record.world->find<Springs>();
  if (!springs) return;
  springs->clear_script_forces();
  std::vector<ObjectId> nets;
  record.world->objects().for_each(ObjectKind::net, [&](ObjectId id) { nets.push_back(id); });
  std::vector<Vec3> positions;
  for (ObjectId net : nets) {
    const TagMask tags = record.world->objects().tags(net);
    bool any = false;
    for (const ScriptForce& f : forces) any = any || acts(f, net, tags);
    if (!any || !record.world->objects().alive(net)) continue;
    springs->positions(net, positions);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      Vec3 sum = Vec3::Zero(), one = Vec3::Zero();
      for (std::size_t k = 0; k < forces.size(); ++k) {
        const std::vector<std::uint32_t>& some = forces[k].points;
        if (failed[k] || !acts(forces[k], net, tags)) continue;
        if (!some.empty() && !std::binary_search(some.begin(), some.end(), static_cast<std::uint32_t>(i))) continue;
        failed[k] =
            !evaluate(L, record, forces[k], positions[i], springs->velocity(net, i), springs->point_mass(net, i), one);
        if (!failed[k]) sum += one;
        if (!record.world->objects().alive(net)) break;
      }
      if (!record.world->objects().alive(net)) break;
      if (dot(sum, sum) > 0) springs->set_script_force(net, i, sum);
    }
  }
}

void apply_to_cloths(lua_State* L, WorldRecord& record, std::vector<ScriptForce>& forces, std::vector<char>& failed) {
  apply_to_cloth(
      record,
      [&](ObjectId id, TagMask tags) {
        bool any = false;
        for (const ScriptForce& f : forces) any = any || acts(f, id, tags);
        return any;
      },
      [&](ObjectId id, const Vec3& x, const Vec3& v, Real mass) {
        const TagMask tags = record.world->objects().tags(id);
        Vec3 sum = Vec3::Zero(), one = Vec3::Zero();
        for (std::size_t k = 0; k < forces.size(); ++k) {
          if (failed[k] || !acts(forces[k], id, tags)) continue;
          failed[k] = !evaluate(L, record, forces[k], x, v, mass, one);
          if (!failed[k]) sum += one;
        }
        return sum;
      });
}

// points = {i, ...}: some of the net that `on` names, ascending and each once.
std::vector<std::uint32_t> read_points(Options& o, WorldRecord& record, ObjectId target) {
  std::vector<std::uint32_t> points;
  if (!o.push("points", LUA_TTABLE, "a list of point numbers")) return points;
  lua_State* L = o.L();
  if (!record.world->objects().alive(target) || record.world->objects().kind(target) != ObjectKind::net)
    o.raise("points", "expected on = a net, whose points these are");
  const auto last = static_cast<std::int64_t>(record.springs().point_count(target));
  const auto count = static_cast<lua_Integer>(lua_rawlen(L, -1));
  if (count == 0) o.raise("points", "expected at least one point number, got none");
  for (lua_Integer k = 1; k <= count; ++k) {
    lua_rawgeti(L, -1, k);
    const std::string what = o.path("points") + "[" + std::to_string(k) + "]";
    points.push_back(static_cast<std::uint32_t>(check_integer(L, -1, what, 1, last) - 1));
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

// on = tag, list of tags, or object; everything when absent.
template <class Target>
void read_target(Options& o, WorldRecord& record, Target& target) {
  if (!o.push_any("on")) {
    target.all = true;
    target.points = read_points(o, record, {});
    return;
  }
  const int type = lua_type(o.L(), -1);
  if (type == LUA_TUSERDATA) {
    target.target = check_object(o.L(), -1, record, o.path("on"));
    const ObjectKind kind = record.world->objects().kind(target.target);
    if (kind != ObjectKind::body && kind != ObjectKind::net && kind != ObjectKind::cloth)
      o.wrong("on", "a tag, a body, a net or a cloth");
  } else if (type != LUA_TSTRING && type != LUA_TTABLE) {
    o.wrong("on", "a tag, a body, a net or a cloth");
  }
  lua_pop(o.L(), 1);
  target.points = read_points(o, record, target.target);
  if (type == LUA_TUSERDATA) return;
  std::vector<std::string> words;
  o.words("on", words);
  for (const std::string& w : words) target.tags |= record.world->objects().tag_bit(w);
}

ForceEntry entry_of(const ScriptForce& f) {
  ForceEntry entry;
  entry.all = f.all, entry.tags = f.tags, entry.target = f.target, entry.points = f.points;
  return entry;
}

int add_script_force(Options& o, WorldRecord& record, std::string name, TagMask tags) {
  lua_State* L = o.L();
  ScriptForce f;
  read_target(o, record, f);
  bool stages = false;
  o.flag("stages", stages);
  o.push("each", LUA_TFUNCTION, "a function, or formulas in quotes");
  o.finish();
  f.profile = state(L).profile_slot(L, -1);
  f.function = keep(L, record, -1);
  lua_pop(L, 1);
  ForceEntry entry = entry_of(f);
  if (stages) entry.force = make_stage_force(record, f.function, f.profile);
  f.object = record.world->add_force(std::move(entry), std::move(name), tags);
  push_handle(L, record, f.object);
  if (!stages) record.forces.list.push_back(std::move(f));
  return 1;
}

// params = { k = 100, ... }: what formulas name beside the variables.
void read_formula_params(Options& o, Params& options) {
  if (!o.push("params", LUA_TTABLE, "a table of numbers")) return;
  lua_State* L = o.L();
  for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
    if (lua_type(L, -2) != LUA_TSTRING) o.raise("params", "expected names, got the key " + describe(L, -2));
    const std::string name = lua_tostring(L, -2);
    if (name == "x" || name == "y" || name == "z")
      o.raise("params", "expected a name that is no variable or function, got '" + name + "'");
    options.set(name, check_number(L, -1, o.path("params") + "." + name));
  }
  lua_pop(L, 1);
}

// each = "formula" (along x) or { "formula", "formula", "formula" }.
int add_formula_force(Options& o, WorldRecord& record, std::string name, TagMask tags) {
  lua_State* L = o.L();
  static const char* const axes[] = {"x", "y", "z"};
  Params options;
  o.push_any("each");
  const bool list = lua_type(L, -1) == LUA_TTABLE;
  const lua_Integer count = list ? static_cast<lua_Integer>(lua_rawlen(L, -1)) : 1;
  if (count < 1 || count > 3) o.raise("each", "expected one to three formulas, got " + std::to_string(count));
  for (int k = 0; k < count; ++k) {
    if (list) lua_rawgeti(L, -1, k + 1);
    if (lua_type(L, -1) == LUA_TNUMBER)
      options.set(axes[k], print_number(lua_tonumber(L, -1)));
    else if (lua_type(L, -1) == LUA_TSTRING)
      options.set(axes[k], std::string(lua_tostring(L, -1)));
    else
      o.raise("each", "expected formulas in quotes, got " + describe(L, -1));
    if (list) lua_pop(L, 1);
  }
  lua_pop(L, 1);
  read_formula_params(o, options);
  ForceEntry target;
  read_target(o, record, target);
  bool stages = true;
  if (o.flag("stages", stages) && !stages) o.raise("stages", "expected true: formulas are evaluated at every stage");
  o.finish();
  try {
    push_handle(L, record, record.world->add_force("expression", options, std::move(target), std::move(name), tags));
  } catch (const SceneError& e) {
    o.raise("each", e.what());
  }
  return 1;
}

// between = net: its points attract each other.
void read_between(Options& o, WorldRecord& record, ForceEntry& target, Params& options) {
  if (o.has("on") || o.has("position")) o.raise("between", "expected neither on nor position beside it");
  if (!object_option(o, "between", record, target.target) ||
      record.world->objects().kind(target.target) != ObjectKind::net)
    o.raise("between", "expected a net");
  options.set("between", true);
}

// The entry of a force; null when the world has none.
ForceEntry* find_entry(World& world, ObjectId id) {
  if (Forces* forces = world.store().find<Forces>())
    for (ForceEntry& e : forces->list)
      if (e.object == id) return &e;
  return nullptr;
}

int force_set_enabled(lua_State* L) {
  Self self = check_self(L);
  if (lua_type(L, 2) != LUA_TBOOLEAN) fail_here(L, "expected true or false, got " + describe(L, 2));
  if (ForceEntry* e = find_entry(self.world, self.id)) e->enabled = lua_toboolean(L, 2) != 0;
  lua_settop(L, 1);
  return 1;
}

int force_enabled(lua_State* L) {
  Self self = check_self(L);
  const ForceEntry* e = find_entry(self.world, self.id);
  lua_pushboolean(L, e && e->enabled);
  return 1;
}

const Method kForceMethods[] = {
    {"enabled", guard<force_enabled>, "force:enabled() -> boolean", "does the force act?"},
    {"set_enabled", guard<force_set_enabled>, "force:set_enabled(on) -> self", "switches the force on or off"},
};

}  // namespace

std::span<const Method> force_methods() { return kForceMethods; }

void apply_script_forces(lua_State* L, WorldRecord& record) {
  if (record.forces.list.empty()) return;
  luaL_checkstack(L, 16, "forces");
  std::vector<ScriptForce> forces;
  for (ScriptForce& f : record.forces.list) {
    const ForceEntry* e = find_entry(*record.world, f.object);
    if (e && e->enabled) forces.push_back(f);
  }
  std::vector<char> failed(forces.size(), 0);
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const std::uint64_t start = clock_nanoseconds();
    bool bad = false;
    apply_to_bodies(L, record, forces[k], bad);
    failed[k] = bad;
    auto& profile = state(L).profile[forces[k].profile];
    profile.calls += 1, profile.nanoseconds += clock_nanoseconds() - start;
  }
  apply_to_nets(L, record, forces, failed);
  apply_to_cloths(L, record, forces, failed);
  for (ScriptForce& f : record.forces.list)
    for (ScriptForce& g : forces)
      if (g.object == f.object) f.held = std::move(g.held);
}

int world_force(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  std::string name, kind;
  o.text("name", name);
  const bool has_kind = o.text("kind", kind), has_each = o.has("each");
  if (has_kind == has_each) o.raise(nullptr, "expected either kind = \"...\" or each = function or formulas");
  const TagMask tags = tag_option(o, r);
  if (has_each) {
    o.push_any("each");
    const bool function = lua_type(L, -1) == LUA_TFUNCTION;
    lua_pop(L, 1);
    return (function ? add_script_force : add_formula_force)(o, r, std::move(name), tags);
  }
  ForceEntry target;
  Params options;
  if (o.has("between"))
    read_between(o, r, target, options);
  else
    read_target(o, r, target);
  o.rest(options);
  push_handle(L, r, r.world->add_force(kind, options, std::move(target), std::move(name), tags));
  return 1;
}

}  // namespace feder::lua
