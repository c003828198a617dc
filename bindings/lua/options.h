// Reads an options table by its rows (feder/params.h), or the plain numbers of a hot verb, with a message for every
// mistake:
//   file:line: world:body.density: expected a number above 0, got -5
//   file:line: world:body: unknown option 'frction'; did you mean 'friction'?
// Reading changes nothing, so a mistake leaves the world as it was. Raw access only: no metamethod runs.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/registry.h"
#include "feder/params.h"
#include "feder/types.h"
#include "lua/state.h"

namespace feder::lua {

inline constexpr Range kGravityScale{-1e6, 1e6};  // by more, a float has no room for the speed

class Options;

// What the description T of a thing takes from one key.
template <class T>
struct Option {
  OptionRow row;
  const char* type;                              // for a reference, in Lua's words
  void (*read)(Options&, const OptionRow&, T&);  // may do nothing: of what is read when all else is right
  std::string (*fallback)(const T&) = nullptr;   // of a T as it is made
  std::vector<OptionInfo> (*inner)() = nullptr;  // of a value that is itself a table of options
  std::string (*names)() = nullptr;              // "a, b": of a table of variants
};

class Options {
 public:
  // `owner` is named in messages ("world:body"). A planar world lets {x, y} stand for {x, y, 0}.
  Options(lua_State* L, int index, std::string owner, bool planar = false);

  // Reads by rows, all of them, in their order. A key without a row is a mistake unless rest() takes it.
  template <class T, std::size_t N>
  void read_some(const Option<T> (&rows)[N], T& out) {
    for (const Option<T>& r : rows) {
      known_.push_back(r.row.name);
      if (r.inner) inner_.emplace_back(r.row.name, r.inner);
    }
    for (const Option<T>& r : rows) r.read(*this, r.row, out);
  }
  template <class T, std::size_t N>
  void read(const Option<T> (&rows)[N], T& out) {
    read_some(rows, out);
    finish();
  }

  // The first `count` values by number are no options: {"ice", "rubber", friction = 0.1}.
  void skip_entries(lua_Integer count) { entries_ = count; }

  // By key, which must have a row. Each returns false, `out` untouched, when it is absent.
  bool has(const char* key);
  bool given(const char* key) const;  // of a key whose row is elsewhere: a variant's
  bool number(const char* key, double& out, const Range& range = kAny);
  template <class Number>
  bool real(const char* key, Number& out, const Range& range = kAny) {
    double x = 0;
    if (!number(key, x, range)) return false;
    out = static_cast<Number>(x);
    return true;
  }
  template <class Whole>
  bool integer(const char* key, Whole& out, const Range& range) {
    std::int64_t n = 0;
    if (!whole(key, n, range)) return false;
    out = static_cast<Whole>(n);
    return true;
  }
  bool flag(const char* key, bool& out);
  bool text(const char* key, std::string& out);
  bool vector(const char* key, Vec3& out);
  bool unit(const char* key, Vec3& out);      // a direction: not zero; normalised
  bool rotation(const char* key, Quat& out);  // {x,y,z,w} | {axis=, angle=} | {euler=, order=, fixed=}
  // A colour as 0xrrggbb: { r, g, b } with parts of 0..1, "#rrggbb", or a name.
  bool color(const char* key, std::uint32_t& out);
  // The index of the word in "a, b, c".
  template <class Enum>
  bool choice(const char* key, const char* choices, Enum& out) {
    int index = 0;
    if (!word(key, choices, index)) return false;
    out = static_cast<Enum>(index);
    return true;
  }
  bool words(const char* key, std::vector<std::string>& out);  // "a" or {"a", "b"}
  void know(const char* key) { known_.push_back(key); }        // by another's list: a system's, a part's
  // Pushes the value when present and of the Lua type; the caller pops it.
  bool push(const char* key, int type, const char* expected);
  bool push_any(const char* key);             // pushes a present value
  bool params(const char* key, Params& out);  // a table, all of it
  // The remaining keys, which have no row, as Params: numbers, strings, booleans, lists of numbers.
  void rest(Params& out);

  // Keys that have no row because they belong elsewhere: `place`, as a script writes it.
  void belongs(std::vector<std::string> keys, std::string place) {
    misplaced_.emplace_back(std::move(keys), std::move(place));
  }
  void finish();  // an error when a key was given that has no row
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
  bool whole(const char* key, std::int64_t& out, const Range& range);
  bool word(const char* key, const char* choices, int& out);
  [[noreturn]] void raise_at(const std::string& key, const std::string& message);
  lua_State* L_;
  int index_;
  std::string owner_;
  bool planar_;
  lua_Integer entries_ = 0;
  std::vector<std::string_view> known_;
  std::vector<std::pair<std::vector<std::string>, std::string>> misplaced_;
  std::vector<std::pair<const char*, std::vector<OptionInfo> (*)()>>
      inner_;  // keys whose tables have rows of their own
};

inline constexpr const char* kWordsType = "string or list of strings";

// Rows. field<&BodyDesc::density>("density", "kg/m3", kPositive): a member, by its type. unset(): what it is when
// nobody says is no value that a script could write.
template <auto Member>
struct Field {
  OptionRow row;
  bool shown = true;
  std::string (*names)() = nullptr;
  std::vector<OptionInfo> (*inner)() = nullptr;

  constexpr Field unset() const { return {row, false, names, inner}; }
  // Of a table of variants: names_of<integrators>, options_of<integrators>.
  constexpr Field of(std::string (*all)()) const { return {row, shown, all, inner}; }
  constexpr Field with(std::vector<OptionInfo> (*rows)()) const { return {row, shown, names, rows}; }
  template <class T>
  constexpr operator Option<T>() const {
    using Value = std::remove_reference_t<decltype(std::declval<T&>().*Member)>;
    Option<T> option{row, "rotation", nullptr, nullptr, inner, names};
    if constexpr (std::is_same_v<Value, bool>)
      option.type = "boolean", option.read = [](Options& o, const OptionRow& r, T& t) { o.flag(r.name, t.*Member); };
    else if constexpr (std::is_integral_v<Value>)
      option.type = "integer",
      option.read = [](Options& o, const OptionRow& r, T& t) { o.integer(r.name, t.*Member, r.range); };
    else if constexpr (std::is_floating_point_v<Value>)
      option.type = "number",
      option.read = [](Options& o, const OptionRow& r, T& t) { o.real(r.name, t.*Member, r.range); };
    else if constexpr (std::is_same_v<Value, std::string>)
      option.type = "string", option.read = [](Options& o, const OptionRow& r, T& t) { o.text(r.name, t.*Member); };
    else if constexpr (std::is_same_v<Value, Params>)
      option.type = "table", option.read = [](Options& o, const OptionRow& r, T& t) { o.params(r.name, t.*Member); };
    else if constexpr (std::is_same_v<Value, std::vector<std::string>>)
      option.type = kWordsType, option.read = [](Options& o, const OptionRow& r, T& t) { o.words(r.name, t.*Member); };
    else if constexpr (std::is_same_v<Value, Vec3>)
      option.type = "vector", option.read = [](Options& o, const OptionRow& r, T& t) { o.vector(r.name, t.*Member); };
    else
      option.read = [](Options& o, const OptionRow& r, T& t) { o.rotation(r.name, t.*Member); };
    if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string> || std::is_same_v<Value, Vec3>)
      if (shown) option.fallback = [](const T& made) { return print_value(made.*Member); };
    return option;
  }
};
template <auto Member>
constexpr Field<Member> field(const char* name, const char* unit = "", const Range& range = kAny) {
  return {{.name = name, .unit = unit, .range = range}};
}

template <auto Table>
std::string names_of() {
  return variant_names(Table());
}
template <auto Table>
std::vector<OptionInfo> options_of() {
  return variant_options(Table());
}

template <class T, Vec3 T::*Member>
constexpr Option<T> direction(const char* name) {
  return {{.name = name}, "direction", [](Options& o, const OptionRow& r, T& t) { o.unit(r.name, t.*Member); }};
}

// Read by a function; without one, by whoever reads the rows.
template <class T>
constexpr Option<T> special(const char* name, const char* type, void (*read)(Options&, const OptionRow&, T&),
                            const char* unit = "") {
  return {{.name = name, .unit = unit}, type, read};
}
template <class T>
constexpr Option<T> later(const char* name, const char* type, const char* unit = "") {
  return {{.name = name, .unit = unit}, type, [](Options&, const OptionRow&, T&) {}};
}

// What a reference says of rows: describe_rows(kBody), or as a function: rows_of<kBody>.
template <class T, std::size_t N>
std::vector<OptionInfo> describe_rows(const Option<T> (&rows)[N]) {
  std::vector<OptionInfo> out;
  const T made{};
  for (const Option<T>& r : rows)
    out.push_back({.row = r.row,
                   .type = r.type,
                   .fallback = r.fallback ? r.fallback(made) : "",
                   .choices = r.names ? r.names() : r.row.choices,
                   .inner = r.inner ? r.inner() : std::vector<OptionInfo>{}});
  return out;
}

// Where a table that was read from a YAML file, or one of its keys, stands there: "scene.yaml:12"; "" when unknown.
std::string yaml_location(lua_State* L, int table, std::string_view key = {});

template <auto& Rows>
std::vector<OptionInfo> rows_of() {
  return describe_rows(Rows);
}

inline std::vector<OptionInfo> join_rows(std::vector<OptionInfo> rows, const std::vector<OptionInfo>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

// Readers of a single value at `index`; `what` is named in messages.
double check_number(lua_State* L, int index, const std::string& what, const Range& range = kAny);
std::int64_t check_integer(lua_State* L, int index, const std::string& what, std::int64_t lo, std::int64_t hi);
// A whole number from 1 to `count` as an index from 0.
std::uint32_t check_index(lua_State* L, int index, const std::string& what, std::size_t count);
// A list of `least` to `most` of them: their indices behind those in `out`.
void check_indices(lua_State* L, int index, const std::string& what, const char* expected, std::size_t least,
                   std::size_t most, std::size_t count, std::vector<std::uint32_t>& out);
Vec3 check_vector(lua_State* L, int index, const std::string& what, bool planar = false);  // a table {x, y, z}
Quat check_rotation(lua_State* L, int index, const std::string& what);
// Hot verbs: x, y, z as numbers from `index` on, or one table. `next` is the index after what was read.
Vec3 vector_argument(lua_State* L, int index, bool planar, int* next = nullptr);
const char* check_text(lua_State* L, int index, const std::string& what);
// Arguments of the running API function, under its name in messages.
bool flag_argument(lua_State* L, int index);
Real number_argument(lua_State* L, int index, const Range& range);
void set_param(lua_State* L, int index, const std::string& key, const std::string& what, Params& out);

}  // namespace feder::lua
