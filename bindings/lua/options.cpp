// Options tables and arguments: types and ranges, messages of mistakes, and where they stand.
#include "lua/options.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "feder/error.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

[[noreturn]] void wrong_value(lua_State* L, int index, const std::string& what, const std::string& expected) {
  fail(L, what + ": expected " + expected + ", got " + describe(L, index));
}

// What the number at `index` should have been; empty when it is right.
std::string expected_number(lua_State* L, int index, const Range& range) {
  if (lua_type(L, index) != LUA_TNUMBER) return range.text();
  const double x = lua_tonumber(L, index);
  if (!std::isfinite(x)) return "a finite number";
  // an open bound is compared in Real: what is positive in double may be zero in float
  if (x >= range.lo && x <= range.hi && (!range.open || static_cast<Real>(x) > static_cast<Real>(range.lo))) return {};
  return std::abs(x) > kHuge && range.hi >= kHuge ? "a number of at most 1e30" : range.text();
}

// The table at `index` for messages: "a table of 2 values", "a table with the keys d, h, w".
std::string describe_table(lua_State* L, int index) {
  index = lua_absindex(L, index);
  if (const auto size = lua_rawlen(L, index))
    return "a table of " + std::to_string(size) + (size == 1 ? " value" : " values");
  std::vector<std::string> keys;
  for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1))
    if (lua_type(L, -2) == LUA_TSTRING) keys.emplace_back(text_at(L, -2).substr(0, 20));
  if (keys.empty()) return "an empty table";
  std::sort(keys.begin(), keys.end());
  if (keys.size() > 8) keys.resize(8), keys.emplace_back("...");
  return std::string("a table with the key") + (keys.size() == 1 ? " " : "s ") + join(keys);
}

// The vector at `index`. wrong(i, expected, got) raises what is none: component i from 1 on, or the whole of it (0).
template <class F>
Vec3 read_vector(lua_State* L, int index, bool planar, F&& wrong) {
  index = lua_absindex(L, index);
  const char* expected = planar ? "{x, y} or {x, y, z}" : "{x, y, z}";
  if (lua_type(L, index) != LUA_TTABLE) wrong(0, expected, describe(L, index));
  const auto size = lua_rawlen(L, index);
  if (size != 3 && !(planar && size == 2)) wrong(0, expected, describe_table(L, index));
  Vec3 v = Vec3::Zero();
  each_entry(L, index, [&](lua_Integer i) {
    const double x = lua_type(L, -1) == LUA_TNUMBER ? lua_tonumber(L, -1) : std::nan("");
    if (!(std::abs(x) <= kHuge)) wrong(static_cast<int>(i), "a finite number", describe(L, -1));
    v[i - 1] = static_cast<Real>(x);
  });
  return v;
}

constexpr double kQuaternionTolerance = 1e-3;  // of its length: a few digits written by hand, no other quantity

struct RotationOptions {
  Vec3 axis = Vec3::Zero(), euler = Vec3::Zero();
  Real angle = 0;
  std::string order = "xyz";
  bool fixed = false;
};

constexpr Option<RotationOptions> kRotation[] = {
    direction<RotationOptions, &RotationOptions::axis>("axis"),
    field<&RotationOptions::angle>("angle", "rad").unset(),
    field<&RotationOptions::euler>("euler", "rad").unset(),
    field<&RotationOptions::order>("order"),
    field<&RotationOptions::fixed>("fixed"),
};

Quat euler_rotation(Options& o, const RotationOptions& rotation) {
  if (rotation.order.size() != 3 || rotation.order.find_first_not_of("xyz") != std::string::npos)
    o.raise("order", "expected three of the letters x, y, z, got '" + rotation.order + "'");
  // rotating about the body's own axes multiplies on the right, about the fixed axes on the left
  Quat q;
  for (int k = 0; k < 3; ++k) {
    Vec3 axis = Vec3::Zero();
    axis[rotation.order[static_cast<std::size_t>(k)] - 'x'] = 1;
    const Quat one = from_axis_angle(axis, rotation.euler[k]);
    q = rotation.fixed ? one * q : q * one;
  }
  return normalized(q);
}

}  // namespace

double check_number(lua_State* L, int index, const std::string& what, const Range& range) {
  const std::string expected = expected_number(L, index, range);
  if (!expected.empty()) wrong_value(L, index, what, expected);
  return lua_tonumber(L, index);
}

std::int64_t check_integer(lua_State* L, int index, const std::string& what, std::int64_t lo, std::int64_t hi) {
  const std::string expected = "a whole number from " + std::to_string(lo) + " to " + std::to_string(hi);
  if (lua_type(L, index) != LUA_TNUMBER) wrong_value(L, index, what, expected);
  int whole = 0;
  const lua_Integer i = lua_tointegerx(L, index, &whole);
  if (!whole || i < lo || i > hi) wrong_value(L, index, what, expected);
  return i;
}

std::uint32_t check_index(lua_State* L, int index, const std::string& what, std::size_t count) {
  return static_cast<std::uint32_t>(check_integer(L, index, what, 1, static_cast<std::int64_t>(count)) - 1);
}

void check_indices(lua_State* L, int index, const std::string& what, const char* expected, std::size_t least,
                   std::size_t most, std::size_t count, std::vector<std::uint32_t>& out) {
  if (lua_type(L, index) != LUA_TTABLE || lua_rawlen(L, index) < least || lua_rawlen(L, index) > most)
    wrong_value(L, index, what, expected);
  each_entry(L, index, [&](lua_Integer) { out.push_back(check_index(L, -1, what, count)); });
}

const char* check_text(lua_State* L, int index, const std::string& what) {
  if (lua_type(L, index) != LUA_TSTRING) wrong_value(L, index, what, "a string");
  return lua_tostring(L, index);
}

bool flag_argument(lua_State* L, int index) {
  if (lua_type(L, index) != LUA_TBOOLEAN) fail_here(L, "expected true or false, got " + describe(L, index));
  return lua_toboolean(L, index) != 0;
}

Real number_argument(lua_State* L, int index, const Range& range) {
  return static_cast<Real>(check_number(L, index, function_name(L), range));
}

Vec3 check_vector(lua_State* L, int index, const std::string& what, bool planar) {
  return read_vector(L, index, planar, [&](int i, const char* expected, const std::string& got) {
    if (i > 0) check_number(L, -1, what + "." + "xyz"[i - 1]);
    fail(L, what + ": expected " + expected + ", got " + got);
  });
}

Quat check_rotation(lua_State* L, int index, const std::string& what) {
  index = lua_absindex(L, index);
  const std::string expected = "{x, y, z, w}, {axis =, angle =} or {euler = {..}}";
  if (lua_type(L, index) != LUA_TTABLE) wrong_value(L, index, what, expected);
  const auto count = lua_rawlen(L, index);
  if (count > 0 && count != 4) fail(L, what + ": expected " + expected + ", got " + describe_table(L, index));
  if (count == 4) {
    double q[4] = {}, n = 0;
    each_entry(L, index, [&](lua_Integer i) {
      q[i - 1] = check_number(L, -1, what + "." + "xyzw"[i - 1]);
      n += q[i - 1] * q[i - 1];
    });
    if (!(std::abs(std::sqrt(n) - 1) <= kQuaternionTolerance))
      fail(L, what + ": expected a quaternion of length 1, got one of length " + print_number(std::sqrt(n)));
    return normalized(
        {static_cast<Real>(q[0]), static_cast<Real>(q[1]), static_cast<Real>(q[2]), static_cast<Real>(q[3])});
  }
  Options o(L, index, what);
  RotationOptions rotation;
  o.read(kRotation, rotation);
  if (o.has("euler")) return euler_rotation(o, rotation);
  if (!o.has("axis") || !o.has("angle")) fail(L, what + ": expected " + expected + ", got " + describe_table(L, index));
  return from_axis_angle(rotation.axis, rotation.angle);
}

Vec3 vector_argument(lua_State* L, int index, bool planar, int* next) {
  if (lua_type(L, index) == LUA_TTABLE) {
    if (next) *next = index + 1;
    return check_vector(L, index, function_name(L), planar);
  }
  static const char* const names[] = {".x", ".y", ".z"};
  const int count = planar && lua_isnoneornil(L, index + 2) ? 2 : 3;
  Vec3 v = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    // the fast path of every hot verb: no strings are made unless something is wrong
    const double x = lua_type(L, index + i) == LUA_TNUMBER ? lua_tonumber(L, index + i) : std::nan("");
    if (!(std::abs(x) <= kHuge)) check_number(L, index + i, std::string(function_name(L)) + names[i]);
    v[i] = static_cast<Real>(x);
  }
  if (next) *next = index + 3;
  return v;
}

void set_param(lua_State* L, int index, const std::string& key, const std::string& what, Params& out) {
  index = lua_absindex(L, index);
  switch (lua_type(L, index)) {
    case LUA_TBOOLEAN: out.set(key, lua_toboolean(L, index) != 0); return;
    case LUA_TNUMBER: out.set(key, check_number(L, index, what, Range{})); return;
    case LUA_TSTRING: out.set(key, std::string(lua_tostring(L, index))); return;
    case LUA_TTABLE: {
      const auto size = lua_rawlen(L, index);
      if (size > 1024) fail(L, what + ": expected a list of at most 1024 numbers, got " + std::to_string(size));
      std::vector<double> list;
      each_entry(L, index, [&](lua_Integer i) {
        list.push_back(check_number(L, -1, what + "[" + std::to_string(i) + "]", Range{}));
      });
      out.set(key, std::move(list));
      return;
    }
    default: wrong_value(L, index, what, "a number, a string, true or false, or a list of numbers");
  }
}

Options::Options(lua_State* L, int index, std::string owner, bool planar)
    : L_(L), index_(lua_absindex(L, index)), owner_(std::move(owner)), planar_(planar) {
  luaL_checkstack(L, 12, "options");
  if (lua_type(L, index_) != LUA_TTABLE) wrong_value(L, index_, owner_, "a table of options { ... }");
}

std::string yaml_location(lua_State* L, int table, std::string_view key) {
  const int top = lua_gettop(L);
  table = lua_absindex(L, table);
  std::string at;
  if (lua_getfield(L, LUA_REGISTRYINDEX, "feder.places") == LUA_TTABLE) {
    lua_pushvalue(L, table);
    if (lua_rawget(L, -2) == LUA_TTABLE) {
      // of the key; else of the table, under true
      push(L, key);
      if (lua_rawget(L, -2) != LUA_TSTRING) {
        push(L, true);
        lua_rawget(L, top + 2);
      }
      if (lua_type(L, -1) == LUA_TSTRING) at = lua_tostring(L, -1);
    }
  }
  lua_settop(L, top);
  return at;
}

void Options::raise_at(const std::string& key, const std::string& message) {
  const std::string at = yaml_location(L_, index_, key);
  if (at.empty()) fail(L_, message);
  raise_error(L_, at + ": " + message);
}

void Options::raise(const char* key, const std::string& message) {
  raise_at(key ? key : "", (key ? path(key) : owner_) + ": " + message);
}

void Options::wrong(const char* key, const std::string& expected) {
  lua_pushstring(L_, key);
  lua_rawget(L_, index_);
  raise(key, "expected " + expected + ", got " + describe(L_, -1));
}

bool Options::push_any(const char* key) {
  FEDER_ASSERT(std::find(known_.begin(), known_.end(), key) != known_.end());  // its row
  lua_pushstring(L_, key);
  if (lua_rawget(L_, index_) != LUA_TNIL) return true;
  lua_pop(L_, 1);
  return false;
}

bool Options::push(const char* key, int type, const char* expected) {
  if (!push_any(key)) return false;
  if (lua_type(L_, -1) != type) wrong(key, expected);
  return true;
}

bool Options::given(const char* key) const {
  lua_pushstring(L_, key);
  const bool there = lua_rawget(L_, index_) != LUA_TNIL;
  lua_pop(L_, 1);
  return there;
}

bool Options::has(const char* key) {
  FEDER_ASSERT(std::find(known_.begin(), known_.end(), key) != known_.end());  // its row
  return given(key);
}

bool Options::number(const char* key, double& out, const Range& range) {
  if (!push_any(key)) return false;
  const std::string expected = expected_number(L_, -1, range);
  if (!expected.empty()) wrong(key, expected);
  out = lua_tonumber(L_, -1);
  lua_pop(L_, 1);
  return true;
}

bool Options::whole(const char* key, std::int64_t& out, const Range& range) {
  if (!push_any(key)) return false;
  int is_whole = 0;
  const lua_Integer i = lua_type(L_, -1) == LUA_TNUMBER ? lua_tointegerx(L_, -1, &is_whole) : 0;
  if (!is_whole || !range.holds(static_cast<double>(i))) wrong(key, range.whole());
  lua_pop(L_, 1);
  out = i;
  return true;
}

bool Options::flag(const char* key, bool& out) {
  if (!push(key, LUA_TBOOLEAN, "true or false")) return false;
  out = lua_toboolean(L_, -1) != 0;
  lua_pop(L_, 1);
  return true;
}

bool Options::text(const char* key, std::string& out) {
  if (!push(key, LUA_TSTRING, "a string")) return false;
  std::size_t size = 0;
  const char* s = lua_tolstring(L_, -1, &size);
  if (size > 1000) raise(key, "expected at most 1000 characters, got " + std::to_string(size));
  if (std::strlen(s) != size) raise(key, "expected text without zero bytes");
  out.assign(s, size);
  lua_pop(L_, 1);
  return true;
}

bool Options::vector(const char* key, Vec3& out) {
  if (!push_any(key)) return false;
  out = read_vector(L_, -1, planar_, [&](int i, const char* expected, const std::string& got) {
    const std::string what = i > 0 ? path(key) + "." + "xyz"[i - 1] : path(key);
    raise_at(key, what + ": expected " + expected + ", got " + got);
  });
  lua_pop(L_, 1);
  return true;
}

bool Options::unit(const char* key, Vec3& out) {
  Vec3 v = Vec3::Zero();
  if (!vector(key, v)) return false;
  const Vec3 n = normalized_or(v / std::max(Real(1e-20), std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])})),
                               Vec3::Zero());
  if (!(length(n) > Real(0.5))) raise(key, "expected a direction, got {0, 0, 0}");
  out = n;
  return true;
}

bool Options::rotation(const char* key, Quat& out) {
  if (!push_any(key)) return false;
  out = check_rotation(L_, -1, path(key));
  lua_pop(L_, 1);
  return true;
}

bool Options::word(const char* key, const char* choices, int& out) {
  if (!push(key, LUA_TSTRING, (std::string("one of ") + choices).c_str())) return false;
  const std::vector<std::string_view> known = split_choices(choices);
  const auto found = std::find(known.begin(), known.end(), lua_tostring(L_, -1));
  if (found == known.end()) wrong(key, std::string("one of ") + choices);
  out = static_cast<int>(found - known.begin());
  lua_pop(L_, 1);
  return true;
}

bool Options::words(const char* key, std::vector<std::string>& out) {
  if (!push_any(key)) return false;
  std::vector<std::string> list;
  if (lua_type(L_, -1) == LUA_TSTRING) {
    list.emplace_back(lua_tostring(L_, -1));
  } else {
    if (lua_type(L_, -1) != LUA_TTABLE) wrong(key, "a string or a list of strings");
    const auto size = lua_rawlen(L_, -1);
    if (size > 64) raise(key, "expected at most 64 strings, got " + std::to_string(size));
    each_entry(L_, -1, [&](lua_Integer i) {
      if (lua_type(L_, -1) != LUA_TSTRING)
        raise(key, "expected a list of strings, got " + describe(L_, -1) + " at " + std::to_string(i));
      list.emplace_back(lua_tostring(L_, -1));
    });
  }
  lua_pop(L_, 1);
  out = std::move(list);
  return true;
}

bool Options::params(const char* key, Params& out) {
  if (!push(key, LUA_TTABLE, "a table of options")) return false;
  Options(L_, -1, path(key), planar_).rest(out);
  lua_pop(L_, 1);
  return true;
}

void Options::rest(Params& out) {
  lua_pushnil(L_);
  while (lua_next(L_, index_)) {
    if (lua_type(L_, -2) == LUA_TSTRING) {
      const std::string key = lua_tostring(L_, -2);
      if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
        set_param(L_, -1, key, path(key.c_str()), out);
        if (const auto* list = std::get_if<std::vector<double>>(&out.values().at(key));
            planar_ && list && list->size() == 2)
          out.set(key, std::vector<double>{(*list)[0], (*list)[1], 0});
      }
    } else {
      raise(nullptr, "expected options by name, got the key " + describe(L_, -2));
    }
    lua_pop(L_, 1);
  }
}

void Options::finish() {
  // of several unknown keys the first in alphabetical order is named, so that the message is always the same
  std::string unknown;
  bool found = false;
  lua_pushnil(L_);
  while (lua_next(L_, index_)) {
    lua_pop(L_, 1);
    if (lua_isinteger(L_, -1) && lua_tointeger(L_, -1) >= 1 && lua_tointeger(L_, -1) <= entries_) continue;
    if (lua_type(L_, -1) != LUA_TSTRING) raise(nullptr, "expected options by name, got the key " + describe(L_, -1));
    const std::string key = lua_tostring(L_, -1);
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    if (!found || key < unknown) unknown = key;
    found = true;
  }
  if (!found) return;
  for (const auto& [name, rows] : inner_) {
    std::vector<std::string> keys;
    for (const OptionInfo& o : rows()) keys.emplace_back(o.row.name);
    belongs(std::move(keys), std::string(name) + " = { ... }");
  }
  for (const auto& [keys, place] : misplaced_)
    if (std::find(keys.begin(), keys.end(), unknown) != keys.end())
      raise_at(unknown, owner_ + ": '" + unknown + "' belongs into `" + place + "`");
  const std::vector<std::string> names(known_.begin(), known_.end());
  raise_at(unknown, owner_ + ": unknown option '" + unknown.substr(0, 60) + "'" + did_you_mean_or(unknown, names));
}

}  // namespace feder::lua
