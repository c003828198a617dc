// Reads an options table, or the plain numbers of a hot verb, with a message for every mistake:
//   file:line: world:body.density: expected a number above 0, got -5
//   file:line: world:body: unknown option 'frction'; did you mean 'friction'?
// Reading changes nothing, so a mistake leaves the world as it was. Raw access only: no metamethod runs.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/math.h"
#include "base/params.h"
#include "lua/state.h"

namespace feder::lua {

struct Range {
  double lo = -1e300, hi = 1e300;
  bool open = false;  // lo itself is not allowed
  std::string text() const;
};
inline constexpr double kHuge =
    1e30;  // largest size, speed, mass ... that a script may give: squares stay finite in float
inline const Range kAny{-kHuge, kHuge, false};
inline const Range kPositive{0, kHuge, true};
inline const Range kNotNegative{0, kHuge, false};

class Options {
 public:
  // `owner` is named in messages ("world:body"). A planar world lets {x, y} stand for {x, y, 0}.
  Options(lua_State* L, int index, std::string owner, bool planar = false);

  // Each remembers `key` as known and returns false, `out` untouched, when it is absent.
  bool has(const char* key);
  bool number(const char* key, double& out, const Range& range = kAny);
  bool real(const char* key, Real& out, const Range& range = kAny);
  bool integer(const char* key, std::int64_t& out, std::int64_t lo, std::int64_t hi);
  bool flag(const char* key, bool& out);
  bool text(const char* key, std::string& out);
  bool vector(const char* key, Vec3& out);
  bool unit(const char* key, Vec3& out);      // a direction: not zero; normalised
  bool rotation(const char* key, Quat& out);  // {x,y,z,w} | {axis=, angle=} | {euler=, order=, fixed=}
  // A colour as 0xrrggbb: { r, g, b } with parts of 0..1, "#rrggbb", or a name.
  bool color(const char* key, std::uint32_t& out);
  bool choice(const char* key, const std::vector<std::string>& names, int& out);
  bool words(const char* key, std::vector<std::string>& out);  // "a" or {"a", "b"}
  // Pushes the value when present and of the Lua type; the caller pops it.
  bool push(const char* key, int type, const char* expected);
  bool push_any(const char* key);  // pushes a present value
  // The remaining keys, which nobody asked for, as Params: numbers, strings, booleans, lists of numbers.
  void rest(Params& out);

  void finish();  // an error when a key was given that nobody asked for
  // Raises "owner.key: expected <expected>, got <value of key>".
  [[noreturn]] void wrong(const char* key, const std::string& expected);
  [[noreturn]] void raise(const char* key,
                          const std::string& message);  // "owner.key: message" (key null: "owner: message")

  lua_State* L() const { return L_; }
  int index() const { return index_; }
  bool planar() const { return planar_; }
  const std::string& owner() const { return owner_; }
  std::string path(const char* key) const { return owner_ + "." + key; }

 private:
  [[noreturn]] void raise_at(const std::string& key, const std::string& message);
  lua_State* L_;
  int index_;
  std::string owner_;
  bool planar_;
  std::vector<std::string> known_;
};

// Readers of a single value at `index`; `what` is named in messages.
double check_number(lua_State* L, int index, const std::string& what, const Range& range = kAny);
std::int64_t check_integer(lua_State* L, int index, const std::string& what, std::int64_t lo, std::int64_t hi);
Vec3 check_vector(lua_State* L, int index, const std::string& what, bool planar = false);  // a table {x, y, z}
Quat check_rotation(lua_State* L, int index, const std::string& what);
// Hot verbs: x, y, z as numbers from `index` on, or one table. `next` is the index after what was read.
Vec3 vector_argument(lua_State* L, int index, bool planar, int* next = nullptr);
const char* check_text(lua_State* L, int index, const std::string& what);
void set_param(lua_State* L, int index, const std::string& key, const std::string& what, Params& out);

}  // namespace feder::lua
