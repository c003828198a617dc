// Colours in options tables.
#include <charconv>
#include <cmath>

#include "lua/options.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

struct NamedColor {
  const char* name;
  std::uint32_t rgb;
};

// Muted versions of the plain words, so that several in a scene appear of one piece.
constexpr NamedColor kNames[] = {
    {"white", 0xf2f2ee},  {"grey", 0x9a9a98},   {"gray", 0x9a9a98},  {"black", 0x33363b}, {"red", 0xd1495b},
    {"orange", 0xe8893c}, {"yellow", 0xe9c46a}, {"green", 0x5aa469}, {"teal", 0x2a9d8f},  {"cyan", 0x4fb3c8},
    {"blue", 0x4779c4},   {"purple", 0x8a6fb0}, {"pink", 0xe08aa8},  {"brown", 0x9c6b4a}, {"gold", 0xc9a227},
    {"wood", 0xb98a5a},   {"stone", 0xa3a097},  {"steel", 0x8796a5}, {"ice", 0xb5dbe8},   {"rubber", 0x4a4a4f},
    {"glass", 0xa9cfd6},  {"sand", 0xd9c29a},   {"water", 0x3f8fd0},
};

bool parse_hex(const std::string& text, std::uint32_t& out) {
  if (text.size() != 7 || text[0] != '#') return false;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 7, out, 16);
  return error == std::errc() && end == text.data() + 7;
}

std::uint32_t parse_word(Options& o, const char* key, const std::string& text) {
  std::uint32_t rgb = 0;
  if (parse_hex(text, rgb)) return rgb;
  std::vector<std::string> known;
  for (const NamedColor& c : kNames) {
    if (text == c.name) return c.rgb;
    known.emplace_back(c.name);
  }
  const std::string near = did_you_mean(text, known);
  o.raise(key,
          "unknown colour '" + text + "'" + (near.empty() ? "; known: " + join(known) + ", or \"#rrggbb\"" : near));
}

}  // namespace

bool Options::color(const char* key, std::uint32_t& out) {
  if (!push_any(key)) return false;
  if (lua_type(L_, -1) == LUA_TSTRING) {
    out = parse_word(*this, key, lua_tostring(L_, -1));
  } else if (lua_type(L_, -1) == LUA_TTABLE && lua_rawlen(L_, -1) == 3) {
    out = 0;
    each_entry(L_, -1, [&](lua_Integer i) {
      const double part = check_number(L_, -1, path(key) + "[" + std::to_string(i) + "]", Range{0, 1});
      out = out << 8 | static_cast<std::uint32_t>(std::lround(255 * part));
    });
  } else {
    wrong(key, "{r, g, b} of numbers from 0 to 1, \"#rrggbb\" or a name");
  }
  lua_pop(L_, 1);
  return true;
}

}  // namespace feder::lua
