// feder.scene{...} and what the host does with it.
#include "lua/scene.h"

#include "lua/expect.h"
#include "lua/options.h"
#include "lua/stack.h"
#include "lua/study.h"
#include "lua/world_options.h"

namespace feder::lua {
namespace {

SceneState& scene(lua_State* L) { return state(L).scene; }

struct CameraReading : SceneCamera {
  Vec3 at = Vec3::Zero();
};

constexpr Option<CameraReading> kCamera[] = {
    field<&CameraReading::at>("target", "m").unset(),
    field<&SceneCamera::distance>("distance", "m", kPositive).unset(),
    field<&SceneCamera::yaw>("yaw", "rad").unset(),
    field<&SceneCamera::pitch>("pitch", "rad", {-1.57, 1.57}).unset(),
};

// camera = { target = {x, y, z}, distance =, yaw =, pitch = }
void read_camera(Options& o, const OptionRow&, SceneState& scene) {
  if (!o.push("camera", LUA_TTABLE, "{ target =, distance =, yaw =, pitch = }")) return;
  Options inner(o.L(), -1, o.path("camera"), true);
  CameraReading c;
  inner.read(kCamera, c);
  for (int i = 0; i < 3; ++i) c.target[i] = static_cast<double>(c.at[i]);
  c.has_target = inner.has("target"), c.has_distance = inner.has("distance");
  c.has_yaw = inner.has("yaw"), c.has_pitch = inner.has("pitch");
  scene.camera = c;
  lua_pop(o.L(), 1);
}

bool has_function(Options& o, const char* key, const char* expected) {
  if (!o.push(key, LUA_TFUNCTION, expected)) return false;
  lua_pop(o.L(), 1);
  return true;
}

void read_build(Options& o, const OptionRow& row, SceneState&) {
  if (!has_function(o, row.name, "a function(world, scene)")) o.wrong(row.name, "a function(world, scene)");
}

void read_update(Options& o, const OptionRow& row, SceneState& scene) {
  scene.has_update = has_function(o, row.name, "a function(world, scene)");
}

void read_check(Options& o, const OptionRow& row, SceneState& scene) {
  scene.has_check = has_function(o, row.name, "a function(world, scene, expect)");
}

void read_world(Options& o, const OptionRow& row, SceneState&) {
  if (o.push(row.name, LUA_TTABLE, "a table of options")) lua_pop(o.L(), 1);
}

constexpr Option<GoldenWish> kGolden[] = {
    field<&GoldenWish::every>("every", "s", kPositive),
    field<&GoldenWish::position>("position", "m", kNotNegative),
    field<&GoldenWish::rotation>("rotation", "rad", kNotNegative),
    field<&GoldenWish::energy>("energy", "", kNotNegative),
    field<&GoldenWish::relative>("relative", "", kNotNegative),
};

// golden = { position = 1e-3, ... } or true
void read_golden(Options& o, const OptionRow& row, SceneState& scene) {
  lua_State* L = o.L();
  scene.golden = {};
  if (!o.push_any(row.name)) return;
  scene.golden.declared = lua_type(L, -1) == LUA_TTABLE || lua_toboolean(L, -1);
  if (lua_type(L, -1) == LUA_TTABLE)
    Options(L, lua_gettop(L), o.path(row.name)).read(kGolden, scene.golden);
  else if (lua_type(L, -1) != LUA_TBOOLEAN)
    o.wrong(row.name, "true or a table of tolerances");
  lua_pop(L, 1);
}

void read_study_table(Options& o, const OptionRow&, SceneState& scene) { scene.study = read_study(o); }

// What the host asks about.
constexpr Option<SceneState> kScene[] = {
    field<&SceneState::title>("title"),
    field<&SceneState::seconds>("seconds", "s", {0, 1e9, true}).unset(),
    field<&SceneState::picture>("picture", "s", {0, 1e9}).unset(),
    {{.name = "camera"}, "table", read_camera, nullptr, rows_of<kCamera>},
    {{.name = "world"}, "table", read_world, nullptr, world_rows},
    special("build", "function(world, scene)", read_build),
    special("update", "function(world, scene)", read_update),
    special("check", "function(world, scene, expect)", read_check),
    {{.name = "golden"}, "true or table", read_golden, nullptr, rows_of<kGolden>},
    field<&SceneState::random>("random", "", {0, 10000}).unset(),
    {{.name = "study"}, "table", read_study_table, nullptr, study_rows},
};

void read_scene(lua_State* L, int table, SceneState& out) {
  Options o(L, table, "feder.scene");
  misplace_world_options(o, state(L).options.systems, " = ");
  o.read(kScene, out);
}

// A fresh copy of the scene for build, update and check: what a build leaves there does not reach the next.
void push_scene_copy(lua_State* L) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, scene(L).table);
  lua_newtable(L);
  copy_fields(L, -2);
  lua_remove(L, -2);
}

}  // namespace

void push_callback(lua_State* L, const char* name) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, scene(L).table);
  lua_pushstring(L, name);
  lua_rawget(L, -2);
  lua_remove(L, -2);
}

// World and scene copy, as build, update and check get them.
void push_scene_world(lua_State* L) {
  push_world(L, *state(L).current());
  lua_rawgeti(L, LUA_REGISTRYINDEX, scene(L).passed);
}

std::vector<OptionInfo> scene_rows() { return describe_rows(kScene); }

int feder_scene(lua_State* L) {
  SceneState read;
  read_scene(L, 1, read);
  // the world's options are read here too, where the script's line is known
  lua_pushstring(L, "world");
  if (lua_rawget(L, 1) == LUA_TTABLE) {
    try {
      read_world_options(L, -1, "world", false);
    } catch (const SceneError& e) {
      const std::string what = e.what();
      fail(L, what.rfind("world", 0) == 0 ? what : "world: " + what);
    }
  }
  SceneState& s = scene(L);
  s.where = location(L);
  lua_settop(L, 1);
  replace_reference(L, s.last);
  return 1;
}

bool take_scene(lua_State* L, const std::string& file) {
  SceneState& s = scene(L);
  if (lua_type(L, -1) != LUA_TTABLE && s.last == LUA_NOREF) return false;  // a plain script, whatever it returns
  if (lua_isnil(L, -1))
    raise_error(L, s.where + ": the file makes a scene and does not return it; write 'return feder.scene { ... }'");
  if (lua_type(L, -1) != LUA_TTABLE)
    raise_error(L, s.where + ": expected the file to return the scene made here, got " + describe(L, -1));
  const std::string where = s.where;
  s.title.clear(), s.seconds = 0, s.picture = -1, s.camera = {}, s.random = 0;
  read_scene(L, lua_gettop(L), s);
  s.where = where.empty() ? file : where;
  lua_pushvalue(L, -1);
  s.table = luaL_ref(L, LUA_REGISTRYINDEX);
  return true;
}

int build_scene(lua_State* L) {
  State& st = state(L);
  SceneState& s = scene(L);
  lua_settop(L, 0);
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.table);
  lua_getfield(L, 1, "world");
  if (lua_isnil(L, -1)) lua_newtable(L), lua_replace(L, 2);
  WorldSettings settings;
  std::string error;
  try {
    settings = read_world_options(L, 2, "world");
  } catch (const SceneError& e) {
    error = e.what();
    if (error.rfind("--world", 0) != 0 && error.rfind("world", 0) != 0) error = "world: " + error;
  }
  // a mistake on the command line has no location in the script
  if (!error.empty()) raise_error(L, error.rfind("--world", 0) == 0 ? error : s.where + ": " + error);
  WorldRecord* old = st.current();
  WorldRecord& record = push_new_world(L, settings);  // at 3
  replace_reference(L, st.last_world_ref);
  st.last_world = record.id;
  if (s.passed != LUA_NOREF) st.checks = {};  // of the world before
  st.handler_instructions = 0;
  record.observed.on = s.has_check;
  if (s.has_check) record.world->events().set_wanted(EventKind::hit, true);  // expect.events counts them
  if (old && s.passed != LUA_NOREF) close_world(L, *old);
  push_scene_copy(L);  // at 4
  replace_reference(L, s.passed);
  push_callback(L, "build");
  lua_pushvalue(L, 3);
  lua_pushvalue(L, 4);
  lua_call(L, 2, 0);
  return 0;
}

void run_update(lua_State* L, WorldRecord& record) {
  State& st = state(L);
  SceneState& s = scene(L);
  if (!s.has_update || st.last_world != record.id || st.phase != Phase::running) return;
  push_callback(L, "update");
  const std::size_t profile = st.profile_slot(L, -1);
  push_scene_world(L);
  st.call_handler(L, profile, 2);
}

CheckResult run_check(lua_State* L) {
  State& st = state(L);
  st.checks.has_check = scene(L).has_check;
  if (!st.checks.has_check || !st.current()) return st.checks;
  push_callback(L, "check");
  push_scene_world(L);
  lua_rawgeti(L, LUA_REGISTRYINDEX, st.expect_ref);
  Failure failure;
  if (!st.call(L, 3, 0, failure)) {
    st.checks.failures.push_back({.where = failure.where, .message = failure.message});
    st.checks.limit = failure.limit;
  }
  return st.checks;
}

}  // namespace feder::lua
