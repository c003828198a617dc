// Lua patterns (reference manual, 6.4.1) whose every step is charged to the script's budget: a backtracking match is
// work that no instruction counts. The pattern is compiled first, so a malformed one is an error on any subject.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lua/state.h"

namespace feder::lua {

inline constexpr int kMaxCaptures = 32;

using CharSet = std::array<std::uint64_t, 4>;  // a bit per byte value

// One element of a pattern. Trivial: gmatch keeps them in a userdata.
struct PatternItem {
  enum class Kind : std::uint8_t {
    text,
    one,
    optional,
    many,
    few,
    open,
    close,
    position,
    back,
    balance,
    frontier,
    end
  };
  Kind kind = Kind::text;
  std::uint8_t capture = 0;           // open, close, position, back: number from 0
  unsigned char first = 0, last = 0;  // balance: the pair; many: 1 in `first` for '+'
  std::uint32_t size = 0;             // text: bytes
  const char* text = nullptr;         // text: in the pattern
  CharSet set = {};                   // one, optional, many, few, frontier
};

struct Pattern {
  std::vector<PatternItem> items;
  int captures = 0;
  bool anchored = false;  // begins with '^'
};

// `anchors`: a leading '^' is an anchor (not in gmatch). Raises a Lua error for a malformed pattern.
Pattern compile_pattern(lua_State* L, std::string_view text, bool anchors);

class Matcher {
 public:
  Matcher(lua_State* L, std::span<const PatternItem> items, int captures, std::string_view subject)
      : L_(L), items_(items), captures_(captures), begin_(subject.data()), end_(begin_ + subject.size()) {}

  const char* begin() const { return begin_; }
  const char* end() const { return end_; }
  int captures() const { return captures_; }
  // End of the match that starts at `s`; null when there is none.
  const char* match(const char* s);
  // The captures of the last match, or the whole of it when there are none; how many.
  int push_captures(const char* s, const char* e);
  void push_capture(int capture, const char* s, const char* e);
  // Charges what has been counted so far.
  void settle();

 private:
  struct Capture {
    const char* start = nullptr;
    const char* stop = nullptr;  // null: a position
  };
  const char* run(std::size_t i, const char* s);
  const char* greedy(std::size_t i, const char* s);
  const char* lazy(std::size_t i, const char* s);
  const char* balance(const PatternItem& item, const char* s);
  bool has(const PatternItem& item, const char* s);
  void step(std::size_t n = 1) {
    if ((steps_ += n) >= kStepsPerCharge) settle();
  }

  static constexpr std::size_t kStepsPerCharge = 4096;
  lua_State* L_;
  std::span<const PatternItem> items_;
  int captures_, depth_ = 0;
  std::size_t steps_ = 0;
  const char *begin_, *end_;
  std::array<Capture, kMaxCaptures> capture_;
};

// string.find, match, gmatch, gsub (lua_CFunction).
int pattern_find(lua_State* L);
int pattern_match(lua_State* L);
int pattern_gmatch(lua_State* L);
int pattern_gsub(lua_State* L);

}  // namespace feder::lua
