// The methods of worlds that make nothing: time, health, conserved quantities, look-up, snapshots, the report.
#include <cinttypes>
#include <cstdio>

#include "lua/objects.h"
#include "lua/step.h"
#include "lua/world_options.h"

namespace feder::lua {
namespace {

int world_step(lua_State* L) {
  WorldRecord& r = check_world(L);
  State& s = state(L);
  const std::int64_t n = lua_isnoneornil(L, 2) ? 1 : check_integer(L, 2, function_name(L), 0, 1000000000);
  if (r.busy) fail_here(L, "the world is in a step; handlers, timers and tasks cannot step it");
  if (s.task_world == &r) fail_here(L, "a task cannot step its world; use feder.wait");
  if (s.phase == Phase::building || s.phase == Phase::checking || (s.is_scene && s.phase != Phase::loading))
    fail_here(L, "a scene does not step worlds; the host steps it (only plain scripts step)");
  for (std::int64_t i = 0; i < n; ++i) {
    charge(L, 100);
    run_step(L, r);
    if (s.on_step) s.on_step(*r.world);
  }
  return return_self(L);
}

int world_time(lua_State* L) {
  lua_pushnumber(L, check_world(L).world->time());
  return 1;
}

int world_step_count(lua_State* L) {
  lua_pushinteger(L, static_cast<lua_Integer>(check_world(L).world->step_count()));
  return 1;
}

int world_dt(lua_State* L) {
  lua_pushnumber(L, check_world(L).world->desc().dt);
  return 1;
}

int world_dimension(lua_State* L) {
  lua_pushinteger(L, check_world(L).world->desc().dimension);
  return 1;
}

int world_gravity(lua_State* L) { return push_vector(L, check_world(L).world->desc().gravity); }

int world_set_gravity(lua_State* L) {
  WorldRecord& r = check_world(L);
  r.world->set_gravity(vector_argument(L, 2, r.planar()));
  for (const Part* part : state(L).options.parts)
    if (part->gravity_changed) part->gravity_changed(*r.world);
  return return_self(L);
}

int world_energy(lua_State* L) {
  const Energy e = check_world(L).world->energy();
  lua_pushnumber(L, e.kinetic), lua_pushnumber(L, e.potential), lua_pushnumber(L, e.elastic);
  return 3;
}

int world_momentum(lua_State* L) {
  const Momentum m = check_world(L).world->momentum();
  for (double x : m.linear) lua_pushnumber(L, x);
  return 3;
}

int world_angular_momentum(lua_State* L) {
  const Momentum m = check_world(L).world->momentum();
  for (double x : m.angular) lua_pushnumber(L, x);
  return 3;
}

int world_is_finite(lua_State* L) {
  lua_pushboolean(L, check_world(L).world->is_finite());
  return 1;
}

int world_residuals(lua_State* L) {
  WorldRecord& r = check_world(L);
  lua_newtable(L);
  for (const Residual& x : r.world->residuals()) {
    lua_pushnumber(L, x.value);
    lua_setfield(L, -2, x.name.c_str());
  }
  return 1;
}

int world_hash(lua_State* L) {
  char text[20];
  std::snprintf(text, sizeof text, "%016" PRIx64, check_world(L).world->hash());
  lua_pushstring(L, text);
  return 1;
}

int world_snapshot(lua_State* L) {
  const std::string image = seal_snapshot(check_world(L));
  lua_pushlstring(L, image.data(), image.size());
  return 1;
}

int world_restore(lua_State* L) {
  WorldRecord& r = check_world(L);
  if (lua_type(L, 2) != LUA_TSTRING)
    fail_here(L, "expected a string that world:snapshot() gave, got " + describe(L, 2));
  std::size_t size = 0;
  const char* text = lua_tolstring(L, 2, &size);
  restore_snapshot(L, r, {text, size});
  return return_self(L);
}

void number_field(lua_State* L, const char* key, double value) {
  lua_pushnumber(L, value);
  lua_setfield(L, -2, key);
}

void count_field(lua_State* L, const char* key, std::size_t value) {
  lua_pushinteger(L, static_cast<lua_Integer>(value));
  lua_setfield(L, -2, key);
}

void text_field(lua_State* L, const char* key, const char* value) {
  lua_pushstring(L, value);
  lua_setfield(L, -2, key);
}

int world_report(lua_State* L) {
  WorldRecord& r = check_world(L);
  World& w = *r.world;
  lua_newtable(L);
  lua_newtable(L);
  lua_Integer n = 0;
  for (const SystemReport& s : w.report()) {
    lua_newtable(L);
    text_field(L, "name", s.name.c_str());
    count_field(L, "count", s.count);
    count_field(L, "bytes", s.bytes);
    lua_rawseti(L, -2, ++n);
  }
  lua_setfield(L, -2, "systems");
  lua_newtable(L);
  n = 0;
  for (const std::string& name : w.absent()) {
    lua_pushstring(L, name.c_str());
    lua_rawseti(L, -2, ++n);
  }
  lua_setfield(L, -2, "absent");
  lua_newtable(L);
  n = 0;
  const double steps = static_cast<double>(std::max<std::uint64_t>(1, w.step_count()));
  const StepPlan& plan = w.plan();
  for (const PlanNode& node : plan.nodes()) {
    lua_newtable(L);
    text_field(L, "name", node.name);
    text_field(L, "system", node.system);
    text_field(L, "kind", node.is_loop ? "loop" : "pass");
    text_field(L, "path", plan.path(node).c_str());
    number_field(L, "ms", node.counter.total_nanoseconds() * 1e-6 / steps);
    count_field(L, node.is_loop ? "count" : "calls", node.counter.calls);
    lua_rawseti(L, -2, ++n);
  }
  lua_setfield(L, -2, "plan");
  lua_newtable(L);
  for (const auto& arena : w.store().arenas()) count_field(L, arena->name().c_str(), arena->bytes());
  lua_setfield(L, -2, "blocks");
  lua_newtable(L);
  constexpr std::string_view work = ".row_updates";
  for (const Residual& x : w.residuals()) {
    if (x.name.size() < work.size() || x.name.substr(x.name.size() - work.size()) != work) continue;
    std::string key = x.name;
    key[key.size() - work.size()] = '_';
    count_field(L, key.c_str(), static_cast<std::size_t>(x.value));
  }
  lua_setfield(L, -2, "counts");
  count_field(L, "bytes", w.bytes());
  for (const KindCount& k : w.counts()) {
    count_field(L, k.kind.plural(), k.count);
    if (k.parts) count_field(L, k.parts->units, k.part_count);
  }
  count_field(L, "steps", w.step_count());
  return 1;
}

int world_find(lua_State* L) {
  WorldRecord& r = check_world(L);
  push_handle(L, r, r.world->objects().find(check_text(L, 2, function_name(L))));
  return 1;
}

int world_close(lua_State* L) {
  const auto* block = static_cast<const WorldBlock*>(self_block(L));
  if (!block) wrong_self(L, "world");
  State& s = state(L);
  WorldRecord& r = *s.worlds[block->world];
  if (r.busy || r.tasks.running > 0) fail_here(L, "the world is in use: its handlers and tasks cannot close it");
  if (s.is_scene && s.last_world == r.id) fail_here(L, "the host owns a scene's world");
  close_world(L, r);
  return 0;
}

const Method kWorldMethods[] = {
    {"step", guard<world_step>, "world:step([n]) -> self", "n steps (1); in plain scripts only"},
    {"time", guard<world_time>, "world:time() -> number", "simulated seconds"},
    {"step_count", guard<world_step_count>, "world:step_count() -> integer", "steps done"},
    {"dt", guard<world_dt>, "world:dt() -> number", "seconds per step"},
    {"dimension", guard<world_dimension>, "world:dimension() -> integer", "2 or 3"},
    {"gravity", guard<world_gravity>, "world:gravity() -> x, y, z", "m/s^2"},
    {"set_gravity", guard<world_set_gravity>, "world:set_gravity(x, y, z) -> self", "m/s^2; wakes all bodies"},
    {"force", guard<world_force>, "world:force{ kind =, on =, ... } -> force",
     "or each = \"-k*x^3\" | { fx, fy, fz } in x y z vx vy vz m t and params = { k = .. }, or each = function(x,y,z, "
     "vx,vy,vz, mass, t) return fx, fy, fz end, asked once per step unless stages = true",
     force_rows},
    {"on", guard<world_on>, "world:on(kind, [filter], fn) -> connection", "fn(event) runs after the step"},
    {"events", guard<world_events>, "for e in world:events(kind) do",
     "the last step's events; contact_stay and hit are made from the first call on"},
    {"after", guard<world_after>, "world:after(seconds, fn) -> connection", "once, in simulated time"},
    {"every", guard<world_every>, "world:every(seconds, fn) -> connection", "again and again, at most once per step"},
    {"task", guard<world_task>, "world:task(fn) -> task", "a coroutine that may wait; it starts at once"},
    {"energy", guard<world_energy>, "world:energy() -> kinetic, potential, elastic", "J"},
    {"momentum", guard<world_momentum>, "world:momentum() -> x, y, z", "kg m/s"},
    {"angular_momentum", guard<world_angular_momentum>, "world:angular_momentum() -> x, y, z",
     "about the origin, kg m^2/s"},
    {"is_finite", guard<world_is_finite>, "world:is_finite() -> boolean", "no NaN and no infinity anywhere"},
    {"residuals", guard<world_residuals>, "world:residuals() -> {[name] = number}", "how well the solvers do"},
    {"hash", guard<world_hash>, "world:hash() -> string", "of the state, 16 hex digits"},
    {"snapshot", guard<world_snapshot>, "world:snapshot() -> string", "the state; without timers, tasks and handlers"},
    {"restore", guard<world_restore>, "world:restore(snapshot) -> self", "back to a snapshot of this world"},
    {"report", guard<world_report>, "world:report() -> table",
     "systems, absent, plan (ms per step), blocks (bytes), counts (work of the last step: counts.cloth_row_updates)"},
    {"find", guard<world_find>, "world:find(name) -> object", "the first with that name, or nil"},
    {"close", guard<world_close>, "world:close()", "frees the world; its handles are errors from then on"},
};

}  // namespace

int push_vector(lua_State* L, const Vec3& v) {
  for (int k = 0; k < 3; ++k) lua_pushnumber(L, v[k]);
  return 3;
}

std::size_t number_in(lua_State* L, int index, std::size_t count, const char* what) {
  int whole = 0;
  const lua_Integer i = lua_type(L, index) == LUA_TNUMBER ? lua_tointegerx(L, index, &whole) : 0;
  if (whole && i >= 1 && static_cast<std::uint64_t>(i) <= count) return static_cast<std::size_t>(i - 1);
  fail_here(L,
            std::string("expected a ") + what + " from 1 to " + std::to_string(count) + ", got " + describe(L, index));
}

std::span<const Method> world_methods() { return kWorldMethods; }

}  // namespace feder::lua
