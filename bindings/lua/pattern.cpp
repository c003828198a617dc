// Compiling and matching of patterns: recursive backtracking over the compiled elements, 200 levels deep at most.
#include "lua/pattern.h"

#include <algorithm>
#include <cstring>

namespace feder::lua {
namespace {

constexpr int kMaxDepth = 200;            // of the C stack; a quantifier or capture takes one level
constexpr std::size_t kStepsPerUnit = 8;  // byte comparisons that take as long as one Lua instruction

// What a class of bytes holds: pairs of first and last.
struct ByteClass {
  char name;
  std::string_view ranges;
};
constexpr ByteClass kClasses[] = {{'a', "AZaz"},     {'c', {"\0\x1f\x7f\x7f", 4}},
                                  {'d', "09"},       {'g', "!~"},
                                  {'l', "az"},       {'p', "!/:@[`{~"},
                                  {'s', "\t\r  "},   {'u', "AZ"},
                                  {'w', "09AZaz"},   {'x', "09AFaf"},
                                  {'z', {"\0\0", 2}}};

void add(CharSet& set, unsigned char c) { set[c / 64] |= std::uint64_t(1) << c % 64; }

// All from `first` to `last`.
void add(CharSet& set, char first, char last) {
  for (int c = static_cast<unsigned char>(first); c <= static_cast<unsigned char>(last); ++c)
    add(set, static_cast<unsigned char>(c));
}

// What '%' and `c` stand for: a class, all but that for its capital, or the byte itself.
void add_escaped(CharSet& set, char c) {
  const bool upper = c >= 'A' && c <= 'Z';
  const auto* found = std::ranges::find(kClasses, upper ? static_cast<char>(c - 'A' + 'a') : c, &ByteClass::name);
  if (found == std::end(kClasses)) return add(set, static_cast<unsigned char>(c));
  CharSet members = {};
  for (std::size_t k = 0; k < found->ranges.size(); k += 2) add(members, found->ranges[k], found->ranges[k + 1]);
  for (std::size_t k = 0; k < set.size(); ++k) set[k] |= upper ? ~members[k] : members[k];
}

class Compiler {
 public:
  Compiler(lua_State* L, std::string_view text) : L_(L), p_(text.data()), end_(p_ + text.size()) {}

  Pattern compile(bool anchors) {
    if (anchors && p_ < end_ && *p_ == '^') pattern_.anchored = true, ++p_;
    while (p_ < end_) element();
    if (open_.empty()) return std::move(pattern_);
    luaL_error(L_, "unfinished capture");
    return {};
  }

 private:
  using Kind = PatternItem::Kind;

  void element() {
    if (*p_ == '(') return open();
    if (*p_ == ')') return close();
    if (*p_ == '$' && p_ + 1 == end_) {
      ++p_;
      append(Kind::end);
      return;
    }
    if (*p_ == '%' && p_ + 1 < end_) {
      const char c = p_[1];
      if (c == 'b') return balance();
      if (c == 'f') return frontier();
      if (c >= '0' && c <= '9') return back_reference();
    }
    single();
  }

  PatternItem& append(Kind kind) {
    pattern_.items.emplace_back().kind = kind;
    return pattern_.items.back();
  }

  void open() {
    if (pattern_.captures >= kMaxCaptures) luaL_error(L_, "too many captures");
    const bool position = p_ + 1 < end_ && p_[1] == ')';
    append(position ? Kind::position : Kind::open).capture = static_cast<std::uint8_t>(pattern_.captures);
    if (!position) open_.push_back(pattern_.captures);
    ++pattern_.captures;
    p_ += position ? 2 : 1;
  }

  void close() {
    if (open_.empty()) luaL_error(L_, "invalid pattern capture");
    append(Kind::close).capture = static_cast<std::uint8_t>(open_.back());
    open_.pop_back();
    ++p_;
  }

  void balance() {
    if (end_ - p_ < 4) luaL_error(L_, "malformed pattern (missing arguments to '%%b')");
    PatternItem& item = append(Kind::balance);
    item.first = static_cast<unsigned char>(p_[2]), item.last = static_cast<unsigned char>(p_[3]);
    p_ += 4;
  }

  void frontier() {
    p_ += 2;
    if (p_ == end_ || *p_ != '[') luaL_error(L_, "missing '[' after '%%f' in pattern");
    const CharSet set = bracket();
    append(Kind::frontier).set = set;
  }

  void back_reference() {
    const int number = p_[1] - '0';
    bool known = number >= 1 && number <= pattern_.captures;
    for (int unfinished : open_) known = known && unfinished != number - 1;
    if (!known) luaL_error(L_, "invalid capture index %%%d", number);
    append(Kind::back).capture = static_cast<std::uint8_t>(number - 1);
    p_ += 2;
  }

  // [set]; leaves p_ behind it.
  CharSet bracket() {
    const char* const set_end = bracket_end();
    CharSet set = {};
    const char* p = p_ + 1;
    const bool inverted = p < set_end && *p == '^';
    p += inverted;
    while (p < set_end) {
      if (*p == '%') {
        add_escaped(set, p[1]);
        p += 2;
      } else if (p + 2 < set_end && p[1] == '-') {
        add(set, *p, p[2]);
        p += 3;
      } else {
        add(set, static_cast<unsigned char>(*p++));
      }
    }
    p_ = set_end + 1;
    if (inverted)
      for (std::uint64_t& word : set) word = ~word;
    return set;
  }

  // The ']' that ends the set at p_; the first element may be one itself.
  const char* bracket_end() const {
    const char* p = p_ + 1;
    if (p < end_ && *p == '^') ++p;
    do {
      if (p == end_) luaL_error(L_, "malformed pattern (missing ']')");
      if (*p++ == '%' && p < end_) ++p;
    } while (p == end_ || *p != ']');
    return p;
  }

  void single() {
    const char* const start = p_;
    CharSet set = {};
    const bool plain = *p_ != '%' && *p_ != '[' && *p_ != '.';
    if (plain) {
      add(set, static_cast<unsigned char>(*p_++));
    } else if (*p_ == '.') {
      set.fill(~std::uint64_t(0));
      ++p_;
    } else if (*p_ == '[') {
      set = bracket();
    } else {
      if (p_ + 1 == end_) luaL_error(L_, "malformed pattern (ends with '%%')");
      add_escaped(set, p_[1]);
      p_ += 2;
    }
    const char suffix = p_ < end_ ? *p_ : '\0';
    if (suffix == '*' || suffix == '+' || suffix == '-' || suffix == '?') {
      ++p_;
      PatternItem& item = append(suffix == '?' ? Kind::optional : suffix == '-' ? Kind::few : Kind::many);
      item.set = set;
      item.first = suffix == '+';
    } else if (!plain) {
      append(Kind::one).set = set;
    } else if (!pattern_.items.empty() && pattern_.items.back().kind == Kind::text &&
               pattern_.items.back().text + pattern_.items.back().size == start) {
      ++pattern_.items.back().size;
    } else {
      PatternItem& item = append(Kind::text);
      item.text = start, item.size = 1;
    }
  }

  lua_State* L_;
  const char *p_, *end_;
  Pattern pattern_;
  std::vector<int> open_;  // captures without their ')'
};

}  // namespace

Pattern compile_pattern(lua_State* L, std::string_view text, bool anchors) {
  charge(L, text.size() / 2);
  return Compiler(L, text).compile(anchors);
}

void Matcher::settle() {
  const std::size_t units = steps_ / kStepsPerUnit;
  steps_ = 0;
  charge(L_, units);
}

const char* Matcher::match(const char* s) {
  step();
  depth_ = 0;
  return run(0, s);
}

bool Matcher::has(const PatternItem& item, const char* s) {
  const auto c = static_cast<unsigned char>(*s);
  return (item.set[c / 64] >> c % 64 & 1) != 0;
}

const char* Matcher::run(std::size_t i, const char* s) {
  using Kind = PatternItem::Kind;
  if (++depth_ > kMaxDepth) luaL_error(L_, "pattern too complex");
  const char* result = nullptr;
  for (;; ++i) {
    if (i == items_.size()) {
      result = s;
      break;
    }
    const PatternItem& item = items_[i];
    step();
    bool goes_on = false;  // with the next element, from s
    switch (item.kind) {
      case Kind::text:
        goes_on = static_cast<std::size_t>(end_ - s) >= item.size && std::memcmp(s, item.text, item.size) == 0;
        if (item.size > 64) step(item.size / 8);
        if (goes_on) s += item.size;
        break;
      case Kind::one:
        goes_on = s < end_ && has(item, s);
        s += goes_on;
        break;
      case Kind::optional:
        if (s < end_ && has(item, s)) result = run(i + 1, s + 1);
        goes_on = !result;
        break;
      case Kind::many: result = greedy(i, s); break;
      case Kind::few: result = lazy(i, s); break;
      case Kind::open:
      case Kind::close:
      case Kind::position: {
        Capture& c = capture_[item.capture];
        const Capture before = c;
        if (item.kind != Kind::close) c.start = s;
        c.stop = item.kind == Kind::close ? s : nullptr;
        result = run(i + 1, s);
        if (!result) c = before;
        break;
      }
      case Kind::back: {
        const Capture& c = capture_[item.capture];
        const auto size = c.stop ? static_cast<std::size_t>(c.stop - c.start) : 0;
        goes_on =
            c.stop && static_cast<std::size_t>(end_ - s) >= size && (size == 0 || std::memcmp(s, c.start, size) == 0);
        step(size / 8);
        if (goes_on) s += size;
        break;
      }
      case Kind::balance:
        if (const char* const behind = balance(item, s)) goes_on = true, s = behind;
        break;
      case Kind::frontier: {
        // ends of the subject count as '\0'
        const char zero = '\0';
        goes_on = !has(item, s == begin_ ? &zero : s - 1) && has(item, s == end_ ? &zero : s);
        break;
      }
      case Kind::end: goes_on = s == end_; break;
    }
    if (!goes_on) break;
  }
  --depth_;
  return result;
}

const char* Matcher::greedy(std::size_t i, const char* s) {
  const PatternItem& item = items_[i];
  const char* e = s;
  while (e < end_ && has(item, e)) ++e;
  step(static_cast<std::size_t>(e - s));
  const char* const least = s + item.first;
  for (; e >= least; --e)
    if (const char* const result = run(i + 1, e)) return result;
  return nullptr;
}

const char* Matcher::lazy(std::size_t i, const char* s) {
  for (;; ++s) {
    if (const char* const result = run(i + 1, s)) return result;
    if (s == end_ || !has(items_[i], s)) return nullptr;
  }
}

const char* Matcher::balance(const PatternItem& item, const char* s) {
  if (s == end_ || static_cast<unsigned char>(*s) != item.first) return nullptr;
  std::size_t open = 1;
  for (const char* p = s + 1; p < end_; ++p) {
    const auto c = static_cast<unsigned char>(*p);
    // equal characters close each other
    if (c == item.last) {
      if (--open == 0) {
        step(static_cast<std::size_t>(p - s));
        return p + 1;
      }
    } else if (c == item.first) {
      ++open;
    }
  }
  step(static_cast<std::size_t>(end_ - s));
  return nullptr;
}

void Matcher::push_capture(int capture, const char* s, const char* e) {
  if (capture >= captures_) {
    if (capture > 0) luaL_error(L_, "invalid capture index %%%d", capture + 1);
    lua_pushlstring(L_, s, static_cast<std::size_t>(e - s));
    return;
  }
  const Capture& c = capture_[static_cast<std::size_t>(capture)];
  if (c.stop)
    lua_pushlstring(L_, c.start, static_cast<std::size_t>(c.stop - c.start));
  else
    lua_pushinteger(L_, c.start - begin_ + 1);
}

int Matcher::push_captures(const char* s, const char* e) {
  const int count = captures_ == 0 && s ? 1 : captures_;
  luaL_checkstack(L_, count, "too many captures");
  for (int k = 0; k < count; ++k) push_capture(k, s, e);
  return count;
}

}  // namespace feder::lua
