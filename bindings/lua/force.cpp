// world:force: kinds of the runtime, formulas, or a Lua function that is asked before each step or at every stage.
#include "lua/force.h"

#include <algorithm>
#include <cmath>

#include "lua/method.h"

namespace feder::lua {
namespace {

// "a body, a net or a cloth": the classes that f accepts.
template <class F>
std::string classes_text(const State& s, F&& f) {
  std::vector<std::string> names;
  for (const ObjectClass* c : s.object_classes)
    if (f(*c)) names.push_back(std::string("a ") + c->name);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

bool has_points(const ObjectClass& c) { return c.point_count != nullptr; }

// points = {i, ...}: some of the net that `on` names, ascending and each once.
std::vector<std::uint32_t> read_points(Options& o, WorldRecord& record, ObjectId target) {
  std::vector<std::uint32_t> points;
  if (!o.push("points", LUA_TTABLE, "a list of point numbers")) return points;
  lua_State* L = o.L();
  const ObjectClass* row = target ? class_row(state(L), class_of(state(L), record, target)) : nullptr;
  if (!row || !row->point_count)
    o.raise("points", "expected on = " + classes_text(state(L), has_points) + ", whose points these are");
  const std::size_t count = row->point_count(record, target);
  if (lua_rawlen(L, -1) == 0) o.raise("points", "expected at least one point number, got none");
  each_entry(L, -1, [&](lua_Integer k) {
    points.push_back(check_index(L, -1, o.path("points") + "[" + std::to_string(k) + "]", count));
  });
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
  const State& s = state(o.L());
  bool good = type == LUA_TSTRING || type == LUA_TTABLE;
  if (type == LUA_TUSERDATA) {
    target.target = check_object(o.L(), -1, record, o.path("on"));
    const ObjectClass* row = class_row(s, class_of(s, record, target.target));
    good = row && row->takes_forces;
  }
  if (!good) o.wrong("on", "a tag, " + classes_text(s, [](const ObjectClass& c) { return c.takes_forces; }));
  lua_pop(o.L(), 1);
  target.points = read_points(o, record, target.target);
  if (type == LUA_TUSERDATA) return;
  std::vector<std::string> words;
  o.words("on", words);
  for (const std::string& w : words) target.tags |= record.world->objects().tag_bit(w);
}

struct ForceReading {
  std::string name, kind;
  bool stages = false;
};

// Of every force.
constexpr Option<ForceReading> kForce[] = {
    field<&ForceReading::name>("name"),
    field<&ForceReading::kind>("kind").of(names_of<force_kinds>),
    later<ForceReading>("each", "function, formula or list of formulas", "N"),
    later<ForceReading>("on", "tag, list of tags or object"),
    later<ForceReading>("between", "net"),
    later<ForceReading>("points", "list of point numbers"),
    later<ForceReading>("tags", kWordsType),
};

// Of those by function or formula.
constexpr Option<ForceReading> kEach[] = {
    field<&ForceReading::stages>("stages"),
    later<ForceReading>("params", "table of numbers"),
};

int add_script_force(Options& o, WorldRecord& record, const ForceReading& reading, TagMask tags) {
  lua_State* L = o.L();
  ScriptForce f;
  read_target(o, record, f);
  o.push("each", LUA_TFUNCTION, "a function, or formulas in quotes");
  o.finish();
  f.profile = state(L).profile_slot(L, -1);
  f.function = keep(L, record, -1);
  lua_pop(L, 1);
  ForceEntry entry;
  entry.all = f.all, entry.tags = f.tags, entry.target = f.target, entry.points = f.points;
  if (reading.stages) entry.force = make_stage_force(record, f.function, f.profile);
  f.object = record.world->add_force(std::move(entry), reading.name, tags);
  push_handle(L, record, f.object);
  if (!reading.stages) record.forces.push_back(std::move(f));
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
int add_formula_force(Options& o, WorldRecord& record, const ForceReading& reading, TagMask tags) {
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
  if (o.has("stages") && !reading.stages) o.raise("stages", "expected true: formulas are evaluated at every stage");
  o.finish();
  try {
    push_handle(L, record, record.world->add_force("expression", options, std::move(target), reading.name, tags));
  } catch (const SceneError& e) {
    o.raise("each", e.what());
  }
  return 1;
}

// between = net: its points attract each other.
void read_between(Options& o, WorldRecord& record, ForceEntry& target, Params& options) {
  if (o.has("on") || o.given("position")) o.raise("between", "expected neither on nor position beside it");
  const State& s = state(o.L());
  const ObjectClass* row = nullptr;
  if (object_option(o, "between", record, target.target)) row = class_row(s, class_of(s, record, target.target));
  if (!row || !row->point_count) o.raise("between", "expected " + classes_text(s, has_points));
  options.set("between", true);
}

void force_set_enabled(const Self& self, bool enabled) { self.world.set_force_enabled(self.id, enabled); }

bool force_enabled(const Self& self) { return self.world.force_enabled(self.id); }

const Method kForceMethods[] = {
    {"enabled", method<force_enabled>, "force:enabled() -> boolean", "does the force act?"},
    {"set_enabled", method<force_set_enabled>, "force:set_enabled(on) -> self", "switches the force on or off"},
};

}  // namespace

std::span<const Method> force_methods() { return kForceMethods; }

bool ask_force(lua_State* L, WorldRecord& record, int function, std::size_t profile, const MassPoint& p, double time,
               Vec3& out, Failure& failure) {
  State& s = state(L);
  push_data(L, record);
  lua_rawgeti(L, -1, function);
  lua_remove(L, -2);
  push(L, p.position, p.velocity, p.mass, time);
  if (!s.call(L, 8, 3, failure)) return false;
  bool good = true;
  for (int k = 0; k < 3 && good; ++k) {
    const int at = -3 + k;
    // nil counts as 0, so that a function may return nothing
    const double value = lua_isnil(L, at) ? 0 : lua_type(L, at) == LUA_TNUMBER ? lua_tonumber(L, at) : std::nan("");
    good = std::abs(value) <= kHuge;
    if (good)
      out[k] = static_cast<Real>(value);
    else
      failure = {s.profile[profile].where, "world:force.each: expected three finite numbers, got " + describe(L, at)};
  }
  lua_pop(L, 3);
  return good;
}

ForceRun::ForceRun(lua_State* L, WorldRecord& record, std::vector<ScriptForce> forces)
    : L_(L), record_(record), forces_(std::move(forces)), failed_(forces_.size(), 0) {}

bool ForceRun::acts(std::size_t k, ObjectId object) const {
  const ScriptForce& f = forces_[k];
  return f.all || f.target == object || (f.tags & record_.world->objects().tags(object)) != 0;
}

bool ForceRun::any(ObjectId object) const {
  bool any = false;
  for (std::size_t k = 0; k < forces_.size() && !any; ++k) any = acts(k, object);
  return any;
}

bool ForceRun::ask(std::size_t k, const Vec3& position, const Vec3& velocity, Real mass, Vec3& out) {
  out = Vec3::Zero();
  if (failed_[k]) return false;
  State& s = state(L_);
  const ScriptForce& f = forces_[k];
  const MassPoint point{.position = position, .velocity = velocity, .mass = mass};
  Failure failure;
  if (s.profiled(f.profile, [&] {
        return ask_force(L_, record_, f.function, f.profile, point, record_.world->time(), out, failure);
      }))
    return true;
  s.report(failure);
  failed_[k] = 1;
  out = Vec3::Zero();
  return false;
}

Vec3 ForceRun::sum(ObjectId object, std::uint32_t point, const Vec3& position, const Vec3& velocity, Real mass) {
  Vec3 sum = Vec3::Zero(), one = Vec3::Zero();
  for (std::size_t k = 0; k < forces_.size() && record_.world->objects().alive(object); ++k) {
    const std::vector<std::uint32_t>& some = forces_[k].points;
    if (!acts(k, object) || (!some.empty() && !std::binary_search(some.begin(), some.end(), point))) continue;
    ask(k, position, velocity, mass, one);
    sum += one;
  }
  return sum;
}

void apply_script_forces(lua_State* L, WorldRecord& record) {
  if (record.forces.empty()) return;
  luaL_checkstack(L, 16, "forces");
  std::vector<ScriptForce> enabled;
  for (const ScriptForce& f : record.forces)
    if (record.world->force_enabled(f.object)) enabled.push_back(f);
  ForceRun run(L, record, std::move(enabled));  // a copy: a function may destroy forces, its own too
  for (const Part* part : state(L).options.parts)
    if (part->apply_forces) part->apply_forces(run);
  for (ScriptForce& f : record.forces)
    for (ScriptForce& g : run.forces())
      if (g.object == f.object) f.held = std::move(g.held);
}

std::vector<OptionInfo> force_rows() {
  return join_rows(join_rows(describe_rows(kForce), describe_rows(kEach)), variant_options(force_kinds()));
}

int world_force(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  ForceReading reading;
  o.read_some(kForce, reading);
  const bool has_each = o.has("each");
  if (o.has("kind") == has_each) o.raise(nullptr, "expected either kind = \"...\" or each = function or formulas");
  const TagMask tags = tag_option(o, r);
  if (has_each) {
    o.read_some(kEach, reading);
    o.push_any("each");
    const bool function = lua_type(L, -1) == LUA_TFUNCTION;
    lua_pop(L, 1);
    if (function && o.has("params")) o.raise("params", "expected none: a function has its own variables");
    return (function ? add_script_force : add_formula_force)(o, r, reading, tags);
  }
  ForceEntry target;
  Params options;
  if (o.has("between"))
    read_between(o, r, target, options);
  else
    read_target(o, r, target);
  o.rest(options);
  push_handle(L, r, r.world->add_force(reading.kind, options, std::move(target), reading.name, tags));
  return 1;
}

}  // namespace feder::lua
