// Parameters: declarations by feder.param, and values of the command line in their place.
#include "lua/params.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "lua/options.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

std::string value_text(lua_State* L, int index) {
  if (lua_type(L, index) == LUA_TBOOLEAN) return lua_toboolean(L, index) ? "true" : "false";
  if (lua_type(L, index) == LUA_TSTRING) return lua_tostring(L, index);
  return print_number(lua_tonumber(L, index));
}

bool parse(const std::string& text, double& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error == std::errc() && end == text.data() + text.size()) return std::isfinite(out);
  const std::size_t slash = text.find('/');  // 1/240
  double over = 0, under = 0;
  if (slash == std::string::npos || !parse(text.substr(0, slash), over) || !parse(text.substr(slash + 1), under) ||
      under == 0)
    return false;
  out = over / under;
  return std::isfinite(out);
}

void check_range(lua_State* L, const ParamInfo& p, double x, const std::string& what) {
  if ((p.has_min && x < p.min) || (p.has_max && x > p.max)) {
    const std::string expected = p.has_min && p.has_max ? "from " + print_number(p.min) + " to " + print_number(p.max)
                                 : p.has_min            ? "of at least " + print_number(p.min)
                                                        : "of at most " + print_number(p.max);
    fail(L, what + ": expected a number " + expected + ", got " + print_number(x));
  }
}

void check_choice(lua_State* L, const ParamInfo& p, const std::string& text, const std::string& what) {
  if (p.choices.empty() || std::find(p.choices.begin(), p.choices.end(), text) != p.choices.end()) return;
  fail(L, what + ": expected one of " + join(p.choices) + ", got '" + text + "'");
}

constexpr Option<ParamInfo> kParam[] = {
    field<&ParamInfo::min>("min").unset(),
    field<&ParamInfo::max>("max").unset(),
    field<&ParamInfo::step>("step", "", kPositive).unset(),
    field<&ParamInfo::help>("help"),
    later<ParamInfo>("choices", "list"),
};

ParamInfo read_options(lua_State* L, const std::string& name) {
  ParamInfo p;
  p.name = name;
  if (lua_isnoneornil(L, 3)) return p;
  Options o(L, 3, "feder.param(\"" + name + "\")");
  o.read(kParam, p);
  p.has_min = o.has("min"), p.has_max = o.has("max"), p.has_step = o.has("step");
  if (o.push("choices", LUA_TTABLE, "a list")) {
    const auto count = lua_rawlen(L, -1);
    if (count == 0 || count > 1000) o.raise("choices", "expected 1 to 1000 values, got " + std::to_string(count));
    each_entry(L, -1, [&](lua_Integer) {
      if (lua_type(L, -1) != lua_type(L, 2))
        o.raise("choices", "expected values of the default's type, got " + describe(L, -1));
      p.choices.push_back(value_text(L, -1));
    });
    lua_pop(L, 1);
  }
  if (p.has_min && p.has_max && p.min > p.max) o.raise("min", "expected at most max, got " + print_number(p.min));
  if (lua_type(L, 2) != LUA_TNUMBER && (p.has_min || p.has_max || p.has_step))
    o.raise(nullptr, "expected min, max and step with a number only");
  return p;
}

// Pushes the value of --set, checked against the default's kind.
void push_override(lua_State* L, const ParamInfo& p, const std::string& text) {
  const std::string what = "--set " + p.name + "=" + text;
  switch (lua_type(L, 2)) {
    case LUA_TBOOLEAN:
      if (text != "true" && text != "false") fail(L, what + ": expected true or false, got '" + text + "'");
      lua_pushboolean(L, text == "true");
      return;
    case LUA_TSTRING:
      check_choice(L, p, text, what);
      lua_pushstring(L, text.c_str());
      return;
    default: break;
  }
  double x = 0;
  if (!parse(text, x)) fail(L, what + ": expected a number, got '" + text + "'");
  check_range(L, p, x, what);
  check_choice(L, p, print_number(x), what);
  // a whole number stays an integer when the default is one: names and loops stay the same
  if (lua_isinteger(L, 2) && x == std::floor(x) && std::abs(x) < 1e15)
    lua_pushinteger(L, static_cast<lua_Integer>(x));
  else
    lua_pushnumber(L, x);
}

}  // namespace

std::vector<OptionInfo> param_rows() { return describe_rows(kParam); }

int feder_param(lua_State* L) {
  State& s = state(L);
  // name and default
  const std::string name = check_text(L, 1, "feder.param: name");
  const bool word = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!word) fail_here(L, "expected a name of letters, digits and _, got " + describe(L, 1));
  const int type = lua_type(L, 2);
  if (type != LUA_TNUMBER && type != LUA_TSTRING && type != LUA_TBOOLEAN)
    fail_here(L, "expected a number, a string or a boolean as default of '" + name + "', got " + describe(L, 2));
  const std::string call = "feder.param(\"" + name + "\")";
  if (type == LUA_TNUMBER) check_number(L, 2, call);
  ParamInfo p = read_options(L, name);
  p.fallback = value_text(L, 2);
  if (type == LUA_TNUMBER) check_range(L, p, lua_tonumber(L, 2), call + ": default");
  check_choice(L, p, p.fallback, call + ": default");
  // a parameter that is known has its value
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.params_ref);
  for (const ParamInfo& known : s.params) {
    if (known.name != name) continue;
    if (known.fallback != p.fallback)
      fail_here(L, "'" + name + "' has been declared before, with the default " + known.fallback);
    lua_getfield(L, -1, name.c_str());
    return 1;
  }
  if (s.phase != Phase::loading)
    fail_here(L, "parameters are declared while the file loads, not in build() or later; got '" + name + "'");
  // its value: the default, or that of --set
  const auto set = s.options.set.find(name);
  if (set == s.options.set.end()) {
    lua_pushvalue(L, 2);
  } else {
    // what fails from here to there is the value's fault
    s.wrong_option = true;
    push_override(L, p, set->second);
    s.wrong_option = false;
  }
  p.value = value_text(L, -1);
  lua_pushvalue(L, -1);
  lua_setfield(L, -3, name.c_str());
  s.params.push_back(std::move(p));
  return 1;
}

void check_set_names(const State& s) {
  std::vector<std::string> known;
  for (const ParamInfo& p : s.params) known.push_back(p.name);
  for (const auto& [name, value] : s.options.set) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw OptionError("--set " + name + "=" + value + ": unknown parameter '" + name + "'" + did_you_mean(name, known) +
                      (known.empty() ? "; the script has none" : "; known: " + join(known)));
  }
}

}  // namespace feder::lua
