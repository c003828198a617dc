// Options by name, from a script, a YAML file or the command line. Remembers which keys were read, so that a misspelt
// one becomes an error that names the nearest known key, and the option rows they were read by.
#pragma once
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "feder/error.h"
#include "feder/types.h"

namespace feder {

class Arena;
class Writer;
class Reader;

// Option row: the documented properties of an option, which reading it needs. No option is read without its row, so
// that reference, checks and completion agree with the reader. Rows stand beside the reader: a variant's in its file,
// that of a Lua object with its maker. The meaning of an option is one sentence in the options.txt of the folder, which
// a host without a reference does not link (feder_reference).
struct Range {
  double lo = -1e300, hi = 1e300;
  bool open = false;  // lo itself is not allowed

  bool holds(double x) const { return x >= lo && x <= hi && !(open && x <= lo); }
  std::string text() const;   // "a number above 0 and at most 1"
  std::string whole() const;  // "a whole number from 1 to 100"
};

// The largest size, speed, mass ... that a script may give: its square is finite in float.
inline constexpr double kHuge = 1e30;
inline constexpr Range kAny{-kHuge, kHuge}, kPositive{0, kHuge, true}, kNotNegative{0, kHuge}, kUnitRange{0, 1};
inline constexpr Range kBits{0, 4294967295.0};  // of a group or a mask

// Text of rows is literal: rows are copied freely.
struct OptionRow {
  const char* name;
  const char* unit = "";      // SI, "" where it has none
  Range range = {};           // of numbers
  const char* choices = "";   // words that it may be: "auto, direct, cg"; "" for any
  const char* since = "0.4";  // version of feder; the first that has rows is 0.4
};

// An option row with what its reader adds, for a reference.
struct OptionInfo {
  OptionRow row;
  const char* type = "";               // "number", "integer", "boolean", "string", "vector" ..., in Lua's words
  std::string fallback;                // its default, as a script would write it; "" where it is absent then
  std::string choices;                 // the row's, or the names in this build's table of variants
  std::string of = {};                 // the variant that alone reads it
  std::vector<OptionInfo> inner = {};  // of a value that is itself a table of options
};

// "a, b, c" in its parts.
std::vector<std::string_view> split_choices(std::string_view choices);

// Default of options that are absent when not given: `x >= 0` is false.
inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

// Ten digits; "nan" without its meaningless sign.
std::string print_number(double x);

// As a script would write it; "" for what is none.
std::string print_value(double x);
std::string print_value(float x);  // with as many digits as tell it from its neighbours
inline std::string print_value(bool x) { return x ? "true" : "false"; }
template <class Whole>
requires std::is_integral_v<Whole> std::string print_value(Whole x) { return std::to_string(x); }
inline std::string print_value(const std::string& x) { return x.empty() ? "" : '"' + x + '"'; }
std::string print_value(const Vec3& x);

class Params {
 public:
  using Value = std::variant<bool, double, std::string, std::vector<double>>;

  void set(std::string key, Value value) { values_[std::move(key)] = std::move(value); }
  bool has(std::string_view key) const { return values_.find(std::string(key)) != values_.end(); }
  bool empty() const { return values_.empty(); }
  const std::map<std::string, Value>& values() const { return values_; }

  // The value of the row's option, or `fallback` when absent. Wrong kind, NaN or out of the row's range: SceneError.
  double number(const OptionRow& row, double fallback) const;
  Real real(const OptionRow& row, double fallback) const { return static_cast<Real>(number(row, fallback)); }
  int integer(const OptionRow& row, int fallback) const;
  bool flag(const OptionRow& row, bool fallback) const;
  // `choices`: of a family that checks the name itself.
  std::string text(const OptionRow& row, std::string fallback, std::string choices = "") const;
  // Index of the word among the row's choices; the first when absent.
  std::size_t choice(const OptionRow& row) const;
  // Three finite numbers.
  Vec3 vector(const OptionRow& row, const Vec3& fallback) const;
  // Numbers under names that the user makes up: all but those of `rows`.
  std::vector<std::pair<std::string, double>> others(std::span<const OptionRow> rows) const;
  // Rows read so far, by name. Reading empty options lists all that a maker knows.
  std::vector<OptionInfo> rows() const;

  void save(Writer& w) const;
  void load(Reader& r);  // in place of what is there

  // SceneError when a key was given that nothing has read. `owner` is named in the message.
  void check_all_read(std::string_view owner) const;

 private:
  const Value* find(const OptionRow& row, const char* type, std::string fallback, std::string choices = "") const;

  std::map<std::string, Value> values_;
  mutable std::map<std::string, OptionInfo, std::less<>> asked_;
};

// kernels = "auto" | "plain": whether loops may use the vector instructions of the processor. Results are the same.
bool wide_kernels(const Params& options);

// The member of `known` closest to `word` by edit distance, of several the one that ends most like it; "" when none is
// near.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);

// One row of a variant table. Tables are generated by CMake from the feder_variant lines.
template <class T>
struct Variant {
  const char* name;     // the name in Lua and on the command line
  const char* summary;  // one line for help texts
  std::unique_ptr<T> (*make)(Arena&, const Params&);
};

// The row of a class that is made from the arena and the options, or from the one of them that its constructor takes.
template <class T, class Made>
Variant<T> variant_of(const char* name, const char* summary) {
  return {name, summary, []([[maybe_unused]] Arena& arena, [[maybe_unused]] const Params& p) -> std::unique_ptr<T> {
            if constexpr (std::is_constructible_v<Made, Arena&, const Params&>)
              return std::make_unique<Made>(arena, p);
            else if constexpr (std::is_constructible_v<Made, Arena&>)
              return std::make_unique<Made>(arena);
            else
              return std::make_unique<Made>(p);
          }};
}

// The names of a table: "auto, direct".
template <class Row>
std::string variant_names(std::span<const Row> table) {
  std::string names;
  for (const Row& row : table) names += (names.empty() ? "" : ", ") + std::string(row.name);
  return names;
}

// The row called `name`, or a SceneError that lists the known names. `what` is the word for the family.
template <class Row>
const Row& find_variant(std::span<const Row> table, std::string_view name, const char* what) {
  for (const Row& row : table)
    if (name == row.name) return row;
  throw SceneError(std::string("unknown ") + what + " '" + std::string(name) + "'; " +
                   (table.empty() ? "this build has none" : "known: " + variant_names(table)));
}

// The default of a family: `name` where this build has it, else the first that it has.
template <class Row>
std::string default_variant(std::span<const Row> table, std::string_view name) {
  for (const Row& row : table)
    if (name == row.name) return row.name;
  return table.empty() ? std::string(name) : table[0].name;
}

}  // namespace feder
