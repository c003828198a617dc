// pairs, next and table.sort with an order that is the same in every run. Lua's own order of keys depends on addresses
// and on a seed that is drawn per process; its sort draws pivots from the clock.
// Order of keys: numbers by size, strings by bytes, false, true, objects of worlds by age, then all else by the number
// that tostring shows. Cost: pairs sorts the keys once, n log n; lists skip the sort. next(t, key) looks at all keys.
#include <algorithm>

#include "lua/records.h"
#include "lua/sandbox.h"

namespace feder::lua {
namespace {

struct Key {
  int rank = 0;  // number, string, boolean, object, else
  bool is_integer = false;
  lua_Integer integer = 0;  // also: boolean, age, id
  lua_Integer second = 0;
  double number = 0;
  std::string_view text;  // anchored by the table
  int at = 0;             // place in the list of keys
};

// a < b for a mix of integers and floats, exactly.
bool number_less(const Key& a, const Key& b) {
  if (a.is_integer && b.is_integer) return a.integer < b.integer;
  // 64 bits of mantissa hold both kinds
  const long double x = a.is_integer ? static_cast<long double>(a.integer) : static_cast<long double>(a.number);
  const long double y = b.is_integer ? static_cast<long double>(b.integer) : static_cast<long double>(b.number);
  return x < y;
}

bool less(const Key& a, const Key& b) {
  if (a.rank != b.rank) return a.rank < b.rank;
  if (a.rank == 0) return number_less(a, b);
  if (a.rank == 1) return a.text < b.text;
  return a.integer != b.integer ? a.integer < b.integer : a.second < b.second;
}

Key read_key(lua_State* L, int index) {
  Key k;
  switch (lua_type(L, index)) {
    case LUA_TNUMBER:
      k.is_integer = lua_isinteger(L, index);
      k.integer = k.is_integer ? lua_tointeger(L, index) : 0;
      k.number = lua_tonumber(L, index);
      return k;
    case LUA_TSTRING: {
      std::size_t size = 0;
      const char* text = lua_tolstring(L, index, &size);
      k.rank = 1, k.text = {text, size};
      return k;
    }
    case LUA_TBOOLEAN:
      k.rank = 2, k.integer = lua_toboolean(L, index);
      return k;
    default:
      break;
  }
  if (const Handle* h = test_handle(L, index)) {
    k.rank = 3, k.integer = h->world;
    k.second = static_cast<lua_Integer>(static_cast<std::uint64_t>(h->id.slot) << 32 | h->id.generation);
    return k;
  }
  k.rank = 4, k.integer = value_id(L, index);
  return k;
}

// Leaves a table of the sorted keys on the stack and returns their number.
lua_Integer push_keys(lua_State* L, int table) {
  table = lua_absindex(L, table);
  std::vector<Key> keys;
  lua_newtable(L);
  const int list = lua_gettop(L);
  bool sorted = true;
  for (lua_pushnil(L); lua_next(L, table); lua_pop(L, 1)) {
    Key k = read_key(L, -2);
    k.at = static_cast<int>(keys.size()) + 1;
    if (!keys.empty() && !less(keys.back(), k)) sorted = false;
    keys.push_back(k);
    lua_pushvalue(L, -2);
    lua_rawseti(L, list, k.at);
  }
  charge(L, 4 * keys.size());
  if (sorted) return static_cast<lua_Integer>(keys.size());
  std::sort(keys.begin(), keys.end(), less);
  lua_createtable(L, static_cast<int>(keys.size()), 0);
  lua_Integer n = 0;
  for (const Key& k : keys) {
    lua_rawgeti(L, list, k.at);
    lua_rawseti(L, -2, ++n);
  }
  lua_remove(L, list);
  return n;
}

int pairs_step(lua_State* L) {  // upvalues: keys, position, table
  lua_Integer i = lua_tointeger(L, lua_upvalueindex(2));
  for (;;) {
    lua_settop(L, 0);
    if (lua_rawgeti(L, lua_upvalueindex(1), ++i) == LUA_TNIL) return 1;
    lua_pushvalue(L, 1);
    if (lua_rawget(L, lua_upvalueindex(3)) == LUA_TNIL) continue;  // removed meanwhile
    lua_pushinteger(L, i);
    lua_replace(L, lua_upvalueindex(2));
    return 2;
  }
}

int finish_pairs(lua_State*, int, lua_KContext) {
  return 3;
}

int ordered_pairs(lua_State* L) {
  luaL_checkany(L, 1);
  if (luaL_getmetafield(L, 1, "__pairs") != LUA_TNIL) {
    lua_pushvalue(L, 1);
    lua_callk(L, 1, 3, 0, finish_pairs);
    return 3;
  }
  luaL_checktype(L, 1, LUA_TTABLE);
  push_keys(L, 1);
  lua_pushinteger(L, 0);
  lua_pushvalue(L, 1);
  lua_pushcclosure(L, pairs_step, 3);
  lua_pushvalue(L, 1);
  lua_pushnil(L);
  return 3;
}

int ordered_next(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_settop(L, 2);
  const bool first = lua_isnil(L, 2);
  const Key after = first ? Key{} : read_key(L, 2);
  bool found = false;
  Key best;
  lua_pushnil(L);
  lua_pushnil(L);  // 3: best key, 4: value
  std::uint64_t looked = 0;
  for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1), ++looked) {
    const Key k = read_key(L, -2);
    if ((!first && !less(after, k)) || (found && !less(k, best))) continue;
    found = true, best = k;
    lua_pushvalue(L, -2);
    lua_replace(L, 3);
    lua_pushvalue(L, -1);
    lua_replace(L, 4);
  }
  charge(L, looked);
  if (!found) {
    lua_pushnil(L);
    return 1;
  }
  lua_pushvalue(L, 3);
  lua_pushvalue(L, 4);
  return 2;
}

constexpr lua_Integer kMaxLength = 50000000;  // of lists

// Merge sort: stable, n log n comparisons whatever the comparison says.
int stable_sort(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  const lua_Integer count = luaL_len(L, 1);
  if (count > kMaxLength) fail(L, "table.sort: expected at most 50 million values, got " + std::to_string(count));
  const bool custom = !lua_isnoneornil(L, 2);
  if (custom) luaL_checktype(L, 2, LUA_TFUNCTION);
  lua_settop(L, 2);
  lua_newtable(L);
  for (lua_Integer i = 1; i <= count; ++i) lua_geti(L, 1, i), lua_rawseti(L, 3, i);
  const auto before = [&](int a, int b) {
    if (custom) lua_pushvalue(L, 2);
    lua_rawgeti(L, 3, a), lua_rawgeti(L, 3, b);
    if (!custom) {
      if (lua_type(L, -1) == LUA_TSTRING && lua_rawlen(L, -1) > 64) charge(L, lua_rawlen(L, -1) / 16);
      const bool yes = lua_compare(L, -2, -1, LUA_OPLT);
      lua_pop(L, 2);
      return yes;
    }
    lua_call(L, 2, 1);
    const bool yes = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return yes;
  };
  const int n = static_cast<int>(std::max<lua_Integer>(count, 0));
  std::vector<int> order(static_cast<std::size_t>(n)), merged(order.size());
  for (int i = 0; i < n; ++i) order[static_cast<std::size_t>(i)] = i + 1;
  charge(L, order.size());
  for (std::size_t width = 1; width < order.size(); width *= 2) {
    charge(L, 4 * order.size());
    for (std::size_t lo = 0; lo < order.size(); lo += 2 * width) {
      const std::size_t mid = std::min(lo + width, order.size()), hi = std::min(lo + 2 * width, order.size());
      std::size_t a = lo, b = mid;
      for (std::size_t k = lo; k < hi; ++k) {
        const bool second = a == mid || (b < hi && before(order[b], order[a]));
        merged[k] = second ? order[b++] : order[a++];
      }
    }
    order.swap(merged);
  }
  for (int i = 0; i < n; ++i) lua_rawgeti(L, 3, order[static_cast<std::size_t>(i)]), lua_seti(L, 1, i + 1);
  return 0;
}

// How many integers from..to holds; 0 when none.
std::uint64_t count_between(lua_Integer from, lua_Integer to) {
  return to < from ? 0 : static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from) + 1;
}

// The list at 1 is as long as it says it is: at most 50 million values.
void check_length(lua_State* L, const char* name) {
  if (lua_type(L, 1) != LUA_TTABLE || luaL_getmetafield(L, 1, "__len") == LUA_TNIL) return;
  lua_pop(L, 1);
  if (luaL_len(L, 1) > kMaxLength) fail(L, std::string("table.") + name + ": the list is too long");
}

// Charges the values from argument `first` (default `from`) to argument `first` + 1 (default the length).
void charge_range(lua_State* L, const char* name, int first, bool list) {
  if (list) check_length(L, name);
  const bool given = lua_isinteger(L, first + 1);
  const lua_Integer from = lua_isinteger(L, first) ? lua_tointeger(L, first) : 1;
  const lua_Integer to = given ? lua_tointeger(L, first + 1)
                               : lua_type(L, 1) == LUA_TTABLE ? static_cast<lua_Integer>(lua_rawlen(L, 1)) : 0;
  const std::uint64_t count = count_between(from, to);
  if (count > static_cast<std::uint64_t>(kMaxLength))
    fail(L, std::string("table.") + name + ": expected at most 50 million values");
  charge(L, count);
}

// insert, remove, move, concat and unpack walk as far as lengths and arguments say: what they walk over is charged, then
// the library's function runs in this one's place, so that its errors are those of stock Lua.
enum class Walk { shift, move, range };
template <Walk kWalk>
int bounded_list(lua_State* L) {  // upvalues: the library's function, its name
  const char* const name = lua_tostring(L, lua_upvalueindex(2));
  if constexpr (kWalk == Walk::move) {
    charge_range(L, name, 2, false);
  } else if constexpr (kWalk == Walk::range) {
    charge_range(L, name, name[0] == 'c' ? 3 : 2, true);
  } else {
    check_length(L, name);
    // the values behind the place move
    const int least = name[0] == 'i' ? 3 : 2;
    if (lua_type(L, 1) == LUA_TTABLE && lua_gettop(L) >= least && lua_isinteger(L, 2))
      charge(L, count_between(lua_tointeger(L, 2), static_cast<lua_Integer>(lua_rawlen(L, 1))) / 2);
  }
  return lua_tocfunction(L, lua_upvalueindex(1))(L);
}

}  // namespace

void open_ordered(lua_State* L) {
  lua_register(L, "pairs", guard<ordered_pairs>);
  lua_register(L, "next", guard<ordered_next>);
  lua_getglobal(L, "table");
  lua_pushcfunction(L, guard<stable_sort>);
  lua_setfield(L, -2, "sort");
  static constexpr luaL_Reg kWalks[] = {{"insert", guard<bounded_list<Walk::shift>>},
                                        {"remove", guard<bounded_list<Walk::shift>>},
                                        {"move", guard<bounded_list<Walk::move>>},
                                        {"concat", guard<bounded_list<Walk::range>>},
                                        {"unpack", guard<bounded_list<Walk::range>>}};
  for (const luaL_Reg& walk : kWalks) {
    lua_getfield(L, -1, walk.name);
    lua_pushstring(L, walk.name);
    lua_pushcclosure(L, walk.func, 2);
    lua_setfield(L, -2, walk.name);
  }
  lua_pop(L, 1);
}

}  // namespace feder::lua
