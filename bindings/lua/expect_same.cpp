// expect.same_as: the same scene run again beside the tested one, with other options of its world. What must not change
// a result (threads) is tested by it.
#include <cmath>

#include "lua/expect.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

// The same file in a Lua state of its own, built.
std::unique_ptr<Script> other_run(const State& s, const std::map<std::string, std::string>& world) {
  HostOptions options = s.options;
  for (const auto& [key, value] : world) options.world.insert_or_assign(key, value);
  options.print = [](std::string_view) {};
  options.coverage = nullptr;
  auto script = std::make_unique<Script>(std::move(options));
  script->load_file(s.files.front());
  script->build();
  return script;
}

// KEY = value, as on the command line.
std::map<std::string, std::string> world_argument(lua_State* L) {
  if (lua_type(L, 1) != LUA_TTABLE) fail_here(L, "expected a table of options of the world, got " + describe(L, 1));
  std::map<std::string, std::string> world;
  for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1)) {
    const int type = lua_type(L, -1);
    if (lua_type(L, -2) != LUA_TSTRING || (type != LUA_TNUMBER && type != LUA_TSTRING && type != LUA_TBOOLEAN))
      fail_here(L, "expected { KEY = value, ... } with numbers, texts and booleans");
    const std::string key = lua_tostring(L, -2);
    world[key] = type == LUA_TBOOLEAN  ? (lua_toboolean(L, -1) ? "true" : "false")
                 : type == LUA_TNUMBER ? print_number(lua_tonumber(L, -1))
                                       : lua_tostring(L, -1);
  }
  return world;
}

void step_aside(lua_State* L, Script& script) {
  charge_step(L);
  state(L).outside_lua([&] { script.step(); });
}

double apart(const ObjectSample& x, const ObjectSample& y) {
  return std::hypot(x.position[0] - y.position[0], x.position[1] - y.position[1], x.position[2] - y.position[2]);
}

// Where two runs part: the first step after which their hashes differ, and the object that is farthest off then.
std::string first_difference(lua_State* L, Script& a, Script& b, std::uint64_t steps) {
  while (a.world()->hash() == b.world()->hash() && a.world()->step_count() < steps) step_aside(L, a), step_aside(L, b);
  if (a.world()->hash() == b.world()->hash()) return "the check has changed the state";
  std::string text =
      "they part at step " + std::to_string(a.world()->step_count()) + " (" + print_number(a.world()->time()) + " s)";
  const std::vector<ObjectSample> x = a.sample(), y = b.sample();
  if (x.size() != y.size())
    return text + ", with " + std::to_string(x.size()) + " and " + std::to_string(y.size()) + " objects";
  std::size_t worst = 0;
  for (std::size_t i = 1; i < x.size(); ++i)
    if (apart(x[i], y[i]) > apart(x[worst], y[worst])) worst = i;
  if (!x.empty()) text += ", " + x[worst].name + " is " + print_number(apart(x[worst], y[worst])) + " m off";
  return text;
}

}  // namespace

int expect_same_as(lua_State* L) {
  const State& s = state(L);
  if (!s.is_scene || s.phase != Phase::checking || s.files.empty())
    fail_here(L, "only the check of a scene that is a file may run it again");
  const std::map<std::string, std::string> options = world_argument(L);
  const World& world = *tested_world(L).world;
  const auto other = other_run(s, options);
  while (other->world()->step_count() < world.step_count()) step_aside(L, *other);
  // what is said of it
  std::string with;
  for (const auto& [key, value] : options) with += (with.empty() ? "" : ", ") + key + " = " + value;
  const std::string hash = hash_text(other->world()->hash()), own = hash_text(world.hash());
  CheckFailure f = failure_of("state", "hash " + hash + " as with " + with, own);
  if (hash != own) {
    const auto again = other_run(s, {}), parted = other_run(s, options);
    f.delta = first_difference(L, *again, *parted, world.step_count());
    f.message += "; " + f.delta;
  }
  return push(L, expected(L, hash == own, f));
}

}  // namespace feder::lua
