// The methods of worlds that make nothing: time, health, conserved quantities, look-up, snapshots, the report.
#include <cinttypes>
#include <cstdio>

#include "lua/method.h"
#include "lua/step.h"

namespace feder::lua {
namespace {

void world_step(WorldRecord& r, lua_State* L) {
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
}

double world_dt(WorldRecord& r) { return r.world->desc().dt; }
int world_dimension(WorldRecord& r) { return r.world->desc().dimension; }
Vec3 world_gravity(WorldRecord& r) { return r.world->desc().gravity; }

void world_set_gravity(WorldRecord& r, lua_State* L, const Vec3& gravity) {
  r.world->set_gravity(gravity);
  for (const Part* part : state(L).options.parts)
    if (part->gravity_changed) part->gravity_changed(*r.world);
}

std::array<double, 3> world_energy(WorldRecord& r) {
  const Energy e = r.world->energy();
  return {e.kinetic, e.potential, e.elastic};
}

template <double (Momentum::*Part)[3]>
std::array<double, 3> world_momentum(WorldRecord& r) {
  const Momentum m = r.world->momentum();
  return std::to_array(m.*Part);
}

int world_residuals(lua_State* L) {
  WorldRecord& r = check_world(L);
  lua_newtable(L);
  for (const Residual& x : r.world->residuals()) set_field(L, x.name.c_str(), x.value);
  return 1;
}

std::string world_hash(WorldRecord& r) { return hash_text(r.world->hash()); }

void world_restore(WorldRecord& r, lua_State* L) {
  if (lua_type(L, 2) != LUA_TSTRING)
    fail_here(L, "expected a string that world:snapshot() gave, got " + describe(L, 2));
  restore_snapshot(L, r, text_at(L, 2));
}

// The tree of passes as a list in running order.
void push_plan(lua_State* L, World& w) {
  const double steps = static_cast<double>(std::max<std::uint64_t>(1, w.step_count()));
  const StepPlan& plan = w.plan();
  push_list(L, plan.nodes(), [&](const PlanNode& node) {
    lua_newtable(L);
    set_field(L, "name", node.name);
    set_field(L, "system", node.system);
    set_field(L, "kind", node.is_loop ? "loop" : "pass");
    set_field(L, "path", plan.path(node));
    set_field(L, "ms", node.counter.total_nanoseconds() * 1e-6 / steps);
    set_field(L, node.is_loop ? "count" : "calls", node.counter.calls);
  });
}

// The work of the last step: "cloth.row_updates" among the residuals is cloth_row_updates here.
void push_work_counts(lua_State* L, const World& w) {
  constexpr std::string_view work = ".row_updates";
  lua_newtable(L);
  for (const Residual& x : w.residuals()) {
    if (!std::string_view(x.name).ends_with(work)) continue;
    std::string key = x.name;
    key[key.size() - work.size()] = '_';
    set_field(L, key.c_str(), static_cast<std::size_t>(x.value));
  }
}

int world_report(lua_State* L) {
  World& w = *check_world(L).world;
  lua_newtable(L);
  push_list(L, w.report(), [&](const SystemReport& s) {
    lua_newtable(L);
    set_field(L, "name", s.name);
    set_field(L, "count", s.count);
    set_field(L, "bytes", s.bytes);
  });
  lua_setfield(L, -2, "systems");
  push_list(L, w.absent(), [&](const std::string& name) { push(L, name); });
  lua_setfield(L, -2, "absent");
  push_plan(L, w);
  lua_setfield(L, -2, "plan");
  lua_newtable(L);
  for (const auto& arena : w.store().arenas()) set_field(L, arena->name().c_str(), arena->bytes());
  lua_setfield(L, -2, "blocks");
  push_work_counts(L, w);
  lua_setfield(L, -2, "counts");
  set_field(L, "bytes", w.bytes());
  for (const KindCount& k : w.counts()) {
    set_field(L, k.kind.plural(), k.count);
    if (k.parts) set_field(L, k.parts->units, k.part_count);
  }
  set_field(L, "steps", w.step_count());
  return 1;
}

ObjectId world_find(WorldRecord& r, lua_State* L) {
  return r.world->objects().find(check_text(L, 2, function_name(L)));
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
    {"step", method<world_step>, "world:step([n]) -> self", "n steps (1); in plain scripts only"},
    {"time", method<&World::time>, "world:time() -> number", "simulated seconds"},
    {"step_count", method<&World::step_count>, "world:step_count() -> integer", "steps done"},
    {"dt", method<world_dt>, "world:dt() -> number", "seconds per step"},
    {"dimension", method<world_dimension>, "world:dimension() -> integer", "2 or 3"},
    {"gravity", method<world_gravity>, "world:gravity() -> x, y, z", "m/s^2"},
    {"set_gravity", method<world_set_gravity>, "world:set_gravity(x, y, z) -> self", "m/s^2; wakes all bodies"},
    {"force", guard<world_force>, "world:force{ kind =, on =, ... } -> force",
     "or each = \"-k*x^3\" | { fx, fy, fz } in x y z vx vy vz m t and params = { k = .. }, or each = function(x,y,z, "
     "vx,vy,vz, mass, t) return fx, fy, fz end, asked once per step unless stages = true",
     force_rows},
    {"on", guard<world_on>, "world:on(kind, [filter], fn) -> connection", "fn(event) runs after the step"},
    {"events", guard<world_events>, "world:events(kind) -> iterator",
     "for e in world:events(kind) do: the last step's; contact_stay and hit are made from the first call on"},
    {"after", guard<world_after>, "world:after(seconds, fn) -> connection", "once, in simulated time"},
    {"every", guard<world_every>, "world:every(seconds, fn) -> connection", "again and again, at most once per step"},
    {"task", guard<world_task>, "world:task(fn) -> task", "a coroutine that may wait; it starts at once"},
    {"energy", method<world_energy>, "world:energy() -> kinetic, potential, elastic", "J"},
    {"momentum", method<world_momentum<&Momentum::linear>>, "world:momentum() -> x, y, z", "kg m/s"},
    {"angular_momentum", method<world_momentum<&Momentum::angular>>, "world:angular_momentum() -> x, y, z",
     "about the origin, kg m^2/s"},
    {"is_finite", method<&World::is_finite>, "world:is_finite() -> boolean", "no NaN and no infinity anywhere"},
    {"residuals", guard<world_residuals>, "world:residuals() -> {[name] = number}", "how well the solvers do"},
    {"hash", method<world_hash>, "world:hash() -> string", "of the state, 16 hex digits"},
    {"snapshot", method<write_snapshot>, "world:snapshot() -> string", "the state; without timers, tasks and handlers"},
    {"restore", method<world_restore>, "world:restore(snapshot) -> self", "back to a snapshot of this world"},
    {"report", guard<world_report>, "world:report() -> table",
     "systems, absent, plan (ms per step), blocks (bytes), counts (work of the last step: counts.cloth_row_updates)"},
    {"find", method<world_find>, "world:find(name) -> object", "the first with that name, or nil"},
    {"close", guard<world_close>, "world:close()", "frees the world; its handles are errors from then on"},
};

}  // namespace

std::size_t number_in(lua_State* L, int index, std::size_t count, const char* what) {
  int whole = 0;
  const lua_Integer i = lua_type(L, index) == LUA_TNUMBER ? lua_tointegerx(L, index, &whole) : 0;
  if (whole && i >= 1 && static_cast<std::uint64_t>(i) <= count) return static_cast<std::size_t>(i - 1);
  fail_here(L,
            std::string("expected a ") + what + " from 1 to " + std::to_string(count) + ", got " + describe(L, index));
}

std::span<const Method> world_methods() { return kWorldMethods; }

std::string hash_text(std::uint64_t hash) {
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

}  // namespace feder::lua
