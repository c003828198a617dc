// string.find, match, gmatch and gsub. Values, order of checks and messages are those of the reference manual and of
// stock Lua; the match is lua/pattern.h.
#include <algorithm>
#include <cstring>

#include "lua/pattern.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

std::string_view text_argument(lua_State* L, int index) {
  std::size_t size = 0;
  const char* text = luaL_checklstring(L, index, &size);
  return {text, size};
}

// Where the search begins, from 0; more than `size` when beyond the end.
std::size_t start_argument(lua_State* L, int index, std::size_t size) {
  const lua_Integer given = luaL_optinteger(L, index, 1);
  if (given > 0) return static_cast<std::size_t>(given - 1);
  const auto length = static_cast<lua_Integer>(size);
  return given == 0 || given < -length ? 0 : static_cast<std::size_t>(length + given);
}

// The first occurrence of `what` in `in`, charged by what is compared; null when there is none.
const char* find_plain(lua_State* L, std::string_view in, std::string_view what) {
  if (what.empty()) return in.data();
  std::uint64_t compared = 0;
  const char *s = in.data(), *const end = s + in.size();
  const char* found = nullptr;
  while (!found && static_cast<std::size_t>(end - s) >= what.size()) {
    const char* const at =
        static_cast<const char*>(std::memchr(s, what[0], static_cast<std::size_t>(end - s) - what.size() + 1));
    compared += static_cast<std::uint64_t>((at ? at : end) - s) / 16;
    if (!at) break;
    const auto [there, here] = std::mismatch(what.begin(), what.end(), at);
    compared += static_cast<std::uint64_t>(there - what.begin()) / 2 + 1;
    if (there == what.end()) found = at;
    s = at + 1;
    if (compared > 4096) charge(L, compared / 4), compared = 0;
  }
  charge(L, compared / 4);
  return found;
}

int search(lua_State* L, bool find) {
  const std::string_view subject = text_argument(L, 1), pattern = text_argument(L, 2);
  const std::size_t start = start_argument(L, 3, subject.size());
  if (start > subject.size()) return push(L, nullptr);
  if (find && (lua_toboolean(L, 4) || pattern.find_first_of("^$*+?.([%-") == std::string_view::npos)) {
    const char* const at = find_plain(L, subject.substr(start), pattern);
    if (!at) return push(L, nullptr);
    const auto from = at - subject.data();
    return push(L, from + 1, from + static_cast<lua_Integer>(pattern.size()));
  }
  const Pattern compiled = compile_pattern(L, pattern, true);
  Matcher matcher(L, compiled.items, compiled.captures, subject);
  for (const char* s = matcher.begin() + start; s <= matcher.end(); ++s) {
    const char* const e = matcher.match(s);
    if (!e && !compiled.anchored) continue;
    matcher.settle();
    if (!e) break;
    if (!find) return matcher.push_captures(s, e);
    push(L, s - matcher.begin() + 1, e - matcher.begin());
    return 2 + matcher.push_captures(nullptr, nullptr);
  }
  matcher.settle();
  return push(L, nullptr);
}

// What gmatch keeps between two matches, followed by the elements of the pattern.
struct Iteration {
  std::size_t at, last;  // next start, end of the last match; from 0
  std::size_t items;
  int captures;
};
constexpr std::size_t kNoMatch = ~std::size_t(0);

int next_match(lua_State* L) {  // upvalues: subject, pattern (anchors the elements), iteration
  auto* const it = static_cast<Iteration*>(lua_touserdata(L, lua_upvalueindex(3)));
  std::size_t size = 0;
  const char* const text = lua_tolstring(L, lua_upvalueindex(1), &size);
  Matcher matcher(L, {reinterpret_cast<const PatternItem*>(it + 1), it->items}, it->captures, {text, size});
  for (; it->at <= size; ++it->at) {
    const char* const s = text + it->at;
    const char* const e = matcher.match(s);
    if (!e || static_cast<std::size_t>(e - text) == it->last) continue;
    matcher.settle();
    it->at = it->last = static_cast<std::size_t>(e - text);
    return matcher.push_captures(s, e);
  }
  matcher.settle();
  return 0;
}

// One replacement; false when the matched text stays.
class Replacer {
 public:
  Replacer(lua_State* L, Matcher& matcher, luaL_Buffer& out) : L_(L), matcher_(matcher), out_(out) {}

  bool replace(const char* s, const char* e) {
    if (lua_type(L_, 3) == LUA_TFUNCTION) {
      lua_pushvalue(L_, 3);
      const int count = matcher_.push_captures(s, e);
      lua_call(L_, count, 1);
    } else if (lua_type(L_, 3) == LUA_TTABLE) {
      matcher_.push_capture(0, s, e);
      lua_gettable(L_, 3);
    } else {
      write_template(s, e);
      return true;
    }
    if (!lua_toboolean(L_, -1)) {
      lua_pop(L_, 1);
      luaL_addlstring(&out_, s, static_cast<std::size_t>(e - s));
      return false;
    }
    if (!lua_isstring(L_, -1)) luaL_error(L_, "invalid replacement value (a %s)", luaL_typename(L_, -1));
    luaL_addvalue(&out_);
    return true;
  }

 private:
  void write_template(const char* s, const char* e) {
    std::size_t size = 0;
    const char* p = lua_tolstring(L_, 3, &size);
    const char* const end = p + size;
    while (const auto* escape = static_cast<const char*>(std::memchr(p, '%', static_cast<std::size_t>(end - p)))) {
      luaL_addlstring(&out_, p, static_cast<std::size_t>(escape - p));
      const char c = escape + 1 < end ? escape[1] : '\0';
      if (c == '%')
        luaL_addchar(&out_, '%');
      else if (c == '0')
        luaL_addlstring(&out_, s, static_cast<std::size_t>(e - s));
      else if (c >= '1' && c <= '9')
        write_capture(c - '1', s, e);
      else
        luaL_error(L_, "invalid use of '%%' in replacement string");
      p = escape + 2;
    }
    luaL_addlstring(&out_, p, static_cast<std::size_t>(end - p));
  }

  void write_capture(int capture, const char* s, const char* e) {
    if (capture >= matcher_.captures() && capture > 0) luaL_error(L_, "invalid capture index %%%d", capture + 1);
    matcher_.push_capture(capture, s, e);
    luaL_tolstring(L_, -1, nullptr);  // a position
    lua_remove(L_, -2);
    luaL_addvalue(&out_);
  }

  lua_State* L_;
  Matcher& matcher_;
  luaL_Buffer& out_;
};

}  // namespace

int pattern_find(lua_State* L) { return search(L, true); }
int pattern_match(lua_State* L) { return search(L, false); }

int pattern_gmatch(lua_State* L) {
  const std::string_view subject = text_argument(L, 1), text = text_argument(L, 2);
  const std::size_t start = start_argument(L, 3, subject.size());
  lua_settop(L, 2);
  const Pattern pattern = compile_pattern(L, text, false);
  const std::size_t bytes = pattern.items.size() * sizeof(PatternItem);
  static_assert(alignof(PatternItem) <= 8 && sizeof(Iteration) % alignof(PatternItem) == 0);
  auto* const it = static_cast<Iteration*>(lua_newuserdatauv(L, sizeof(Iteration) + bytes, 0));
  *it = {std::min(start, subject.size() + 1), kNoMatch, pattern.items.size(), pattern.captures};
  if (bytes > 0) std::memcpy(static_cast<void*>(it + 1), pattern.items.data(), bytes);
  lua_pushcclosure(L, guard<next_match>, 3);
  return 1;
}

int pattern_gsub(lua_State* L) {
  const std::string_view subject = text_argument(L, 1), text = text_argument(L, 2);
  const int type = lua_type(L, 3);
  luaL_argexpected(L, type == LUA_TNUMBER || type == LUA_TSTRING || type == LUA_TFUNCTION || type == LUA_TTABLE, 3,
                   "string/function/table");
  const lua_Integer most = luaL_optinteger(L, 4, static_cast<lua_Integer>(subject.size()) + 1);
  const Pattern pattern = compile_pattern(L, text, true);
  Matcher matcher(L, pattern.items, pattern.captures, subject);
  luaL_Buffer out;
  luaL_buffinit(L, &out);
  Replacer replacer(L, matcher, out);
  const char *s = matcher.begin(), *last = nullptr;
  lua_Integer count = 0;
  bool changed = false;
  while (count < most) {
    const char* const e = matcher.match(s);
    if (e && e != last) {
      ++count;
      changed = replacer.replace(s, e) || changed;
      s = last = e;
    } else if (s < matcher.end()) {
      luaL_addchar(&out, *s++);
    } else {
      break;
    }
    if (pattern.anchored) break;
  }
  if (changed) {
    luaL_addlstring(&out, s, static_cast<std::size_t>(matcher.end() - s));
    luaL_pushresult(&out);
  } else {
    lua_pushvalue(L, 1);
  }
  matcher.settle();
  lua_pushinteger(L, count);
  return 2;
}

}  // namespace feder::lua
