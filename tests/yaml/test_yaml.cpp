// YAML text as Lua values: what each kind of value becomes, and what is refused with which line.
#include <lua.hpp>
#include <memory>

#include "feder/lua.h"
#include "feder/yaml.h"
#include "support/catch.h"
#include "yaml/document.h"

using namespace feder;

namespace {

struct Close {
  void operator()(lua_State* lua) const { lua_close(lua); }
};
using LuaState = std::unique_ptr<lua_State, Close>;

LuaState new_state() {
  LuaState lua(luaL_newstate());
  luaL_openlibs(lua.get());
  return lua;
}

// Pushes the text as the global `v` and evaluates a Lua expression about it.
bool holds(const std::string& text, const std::string& expression) {
  const LuaState lua = new_state();
  yaml::push(lua.get(), "file.yaml", text);
  lua_setglobal(lua.get(), "v");
  CHECK(lua_gettop(lua.get()) == 0);
  if (luaL_dostring(lua.get(), ("return " + expression).c_str())) {
    UNSCOPED_INFO(lua_tostring(lua.get(), -1));
    return false;
  }
  return lua_toboolean(lua.get(), -1);
}

std::string error_of(const std::string& text) {
  std::string pushed, checked;
  const LuaState lua = new_state();
  try {
    yaml::push(lua.get(), "file.yaml", text);
  } catch (const lua::ScriptError& e) {
    pushed = e.what();
  }
  try {
    yaml::check("file.yaml", text);
  } catch (const lua::ScriptError& e) {
    checked = e.what();
  }
  CHECK(pushed == checked);
  return pushed;
}

bool starts(const std::string& text, const std::string& head) { return text.compare(0, head.size(), head) == 0; }

std::string nested(int depth) {
  return std::string(static_cast<std::size_t>(depth), '[') + std::string(static_cast<std::size_t>(depth), ']');
}

}  // namespace

TEST_CASE("yaml scalars become Lua values", "[yaml]") {
  CHECK(holds("a: 12\nb: -3\nc: 0x1f\nd: 0o17",
              "v.a == 12 and math.type(v.a) == 'integer' and v.b == -3 and v.c == 31 and v.d == 15"));
  CHECK(holds("a: 1.5\nb: -2e3\nc: .5\nd: +0.25", "v.a == 1.5 and v.b == -2000 and v.c == 0.5 and v.d == 0.25"));
  CHECK(holds("a: .inf\nb: -.inf\nc: .nan", "v.a == math.huge and v.b == -math.huge and v.c ~= v.c"));
  CHECK(holds("a: true\nb: False", "v.a == true and v.b == false"));
  CHECK(holds("a: yes\nb: 1/60\nc: inf\nd: nan\ne: 1.2.3",
              "v.a == 'yes' and v.b == '1/60' and v.c == 'inf' and v.d == 'nan' and v.e == '1.2.3'"));
  CHECK(holds("a: \"12\"\nb: 'true'\nc: !!str 5\nd: !!float 5",
              "v.a == '12' and v.b == 'true' and v.c == '5' and v.d == 5.0"));
  CHECK(holds("a: ~\nb: null\nc:\nd: 1", "v.a == nil and v.b == nil and v.c == nil and v.d == 1"));
  CHECK(holds("1: one\n2: two", "v[1] == 'one' and v[2] == 'two'"));
  CHECK(holds("just text", "v == 'just text'"));
}

TEST_CASE("yaml lists and maps become tables", "[yaml]") {
  CHECK(holds("- 1\n- [2, 3]\n- {x: 4}", "#v == 3 and v[1] == 1 and v[2][2] == 3 and v[3].x == 4"));
  CHECK(holds("a: []\nb: {}", "type(v.a) == 'table' and next(v.a) == nil and next(v.b) == nil"));
}

TEST_CASE("yaml aliases and merges are expanded", "[yaml]") {
  CHECK(holds("base: &b {x: 1, y: 2}\nc: *b", "v.c.x == 1 and v.c.y == 2 and v.c ~= v.base"));
  CHECK(holds("base: &b {x: 1, y: 2}\nc: {<<: *b, y: 3}", "v.c.x == 1 and v.c.y == 3 and v.c['<<'] == nil"));
  CHECK(holds("a: &a {x: 1}\nb: &b {x: 2, z: 3}\nc: {<<: [*a, *b]}", "v.c.x == 1 and v.c.z == 3"));
}

TEST_CASE("yaml mistakes name file and line", "[yaml]") {
  CHECK(error_of("a: 1\nb: [1, 2\nc: 3\n").find("file.yaml:") == 0);
  CHECK(error_of("a: 1\nb: 2\na: 3") == "file.yaml:3: the key 'a' is here twice, first in line 1");
  CHECK(starts(error_of("a:\n  - 1\n  - ~"), "file.yaml:3: null in a list"));
  CHECK(starts(error_of("{[1, 2]: 3}"), "file.yaml:1: a key is"));
  CHECK(starts(error_of("a: 1\nb: !python/object x"), "file.yaml:2: the tag"));
  CHECK(starts(error_of("a: !!int x"), "file.yaml:1: the tag"));
  CHECK(starts(error_of("a: !thing {}"), "file.yaml:1: unknown tag"));
  CHECK(starts(error_of("a: 1\n---\nb: 2"), "file.yaml:2: expected one YAML document"));
  CHECK(starts(error_of("a: *b"), "file.yaml:1:"));
  CHECK(starts(error_of(""), "file.yaml:1: no YAML document"));
  CHECK(starts(error_of("a: 1\nb: {<<: 3}"), "file.yaml:2: << expects"));
}

TEST_CASE("yaml bombs are refused", "[yaml]") {
  std::string laughs = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string was = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    laughs += name + ": &" + name + " [";
    for (int k = 0; k < 10; ++k) laughs += (k ? ", " : "") + was;
    laughs += "]\n";
  }
  CHECK(error_of(laughs).find("more than 1000000 values") != std::string::npos);
  CHECK(starts(error_of("a: &a [1, *a]"), "file.yaml:1: an alias inside"));
  CHECK(error_of(nested(64)).empty());
  CHECK(error_of(nested(65)).find("nested deeper than 64") != std::string::npos);
  CHECK(error_of(nested(200000)).find("nested deeper than 64") != std::string::npos);
  // nesting that only aliases make
  std::string deep = "a0: &a0 [[[[[[[[[[1]]]]]]]]]]\n";
  for (int i = 1; i < 9; ++i)
    deep +=
        "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [[[[[[[[[*a" + std::to_string(i - 1) + "]]]]]]]]]\n";
  CHECK(error_of(deep).find("nested deeper than 64") != std::string::npos);
  CHECK_THROWS_AS(yaml::read("big.yaml", "abc", {.bytes = 2}), lua::ScriptError);
  CHECK_THROWS_AS(yaml::read("big.yaml", "[1, 2, 3]", {.nodes = 3}), lua::ScriptError);
  CHECK_NOTHROW(yaml::read("big.yaml", "[1, 2, 3]", {.nodes = 4}));
}

TEST_CASE("yaml tables remember where they stood", "[yaml]") {
  const LuaState lua = new_state();
  yaml::push(lua.get(), "file.yaml", "title: x\nbodies:\n  - shape: box\n    mass: -1\n");
  lua_setglobal(lua.get(), "v");
  lua_getfield(lua.get(), LUA_REGISTRYINDEX, "feder.places");
  lua_setglobal(lua.get(), "places");
  const int failed =
      luaL_dostring(lua.get(), "local p = places[v.bodies[1]]; return p.mass, p[true], places[v].bodies");
  REQUIRE(failed == 0);
  CHECK(std::string(lua_tostring(lua.get(), -3)) == "file.yaml:4");
  CHECK(std::string(lua_tostring(lua.get(), -2)) == "file.yaml:3");
  CHECK(std::string(lua_tostring(lua.get(), -1)) == "file.yaml:2");
}
