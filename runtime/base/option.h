// The row of an option: what a reference says of it, and what reading it needs. No option is read without its row, so
// that reference, checks and completion are what the reader takes. Rows stand beside the reader: a variant's in its
// file, an object's of Lua with its maker. What an option means is one sentence in the options.txt of the folder,
// which a host without a reference does not link (feder_reference).
#pragma once
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/types.h"

namespace feder {

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

// A row with what its reader adds: for a reference.
struct OptionInfo {
  OptionRow row;
  const char* type = "";  // "number", "integer", "boolean", "string", "vector" ..., in Lua's words
  std::string fallback;   // what it is when nobody says, as a script would write it; "" where it is absent then
  std::string choices;    // the row's, or the names in this build's table of variants
  std::string of = {};    // the variant that alone reads it
  std::vector<OptionInfo> inner = {};  // of a value that is itself a table of options
};

// "a, b, c" in its parts.
std::vector<std::string_view> split_choices(std::string_view choices);

// What is not given: then `x >= 0` is false.
inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

// Ten digits; "nan" without a sign, which tells nobody anything.
std::string print_number(double x);

// As a script would write it; "" for what is none.
std::string print_value(double x);
inline std::string print_value(bool x) { return x ? "true" : "false"; }
template <class Whole>
requires std::is_integral_v<Whole> std::string print_value(Whole x) { return std::to_string(x); }
inline std::string print_value(const std::string& x) { return x.empty() ? "" : '"' + x + '"'; }
std::string print_value(const Vec3& x);

}  // namespace feder
