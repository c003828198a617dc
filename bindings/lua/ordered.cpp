// pairs, next and table.sort with an order that is the same in every run. Lua's own order of keys depends on addresses
// and on a seed that is drawn per process; its sort draws pivots from the clock.
// Order of keys: numbers by size, strings by bytes, false, true, objects of worlds by age, then all else by the number
// that tostring shows. Cost: pairs sorts the keys once, n log n; lists skip the sort.
#include <algorithm>

#include "lua/records.h"
#include "lua/sandbox.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

struct Key {
  int rank = 0;  // number, string, boolean, object, else
  bool is_integer = false;
  lua_Integer integer = 0;  // also: boolean, age, id
  lua_Integer second = 0;
  double number = 0;
  std::string_view text;  // anchored by the table
  int at = 0;             // index in the list of keys
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
    case LUA_TSTRING: k.rank = 1, k.text = text_at(L, index); return k;
    case LUA_TBOOLEAN: k.rank = 2, k.integer = lua_toboolean(L, index); return k;
    default: break;
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

int finish_pairs(lua_State*, int, lua_KContext) { return 3; }

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

const char kWalks = 0;  // registry key of a weak table: table -> its walk

// What next remembers of a table: a list {keys, index of each key, first index that may be alive, stale}.
enum WalkField : int { kKeys = 1, kIndices, kFirst, kStale };

lua_Integer get_integer(lua_State* L, int table, int field) {
  lua_rawgeti(L, table, field);
  const lua_Integer x = lua_tointeger(L, -1);
  lua_pop(L, 1);
  return x;
}

void set_integer(lua_State* L, int table, int field, lua_Integer x) {
  lua_pushinteger(L, x);
  lua_rawseti(L, table, field);
}

// What the table at `indices` says of the key at `key`; 0 where it has none.
lua_Integer index_in(lua_State* L, int indices, int key) {
  indices = lua_absindex(L, indices);
  lua_pushvalue(L, key);
  lua_rawget(L, indices);
  const lua_Integer index = lua_tointeger(L, -1);
  lua_pop(L, 1);
  return index;
}

// Fills the walk at `walk` with the sorted keys of the table at 1 that `missing` accepts, behind those it has.
template <class F>
void list_keys(lua_State* L, int walk, F&& missing) {
  lua_rawgeti(L, walk, kKeys), lua_rawgeti(L, walk, kIndices);
  const int keys = lua_gettop(L) - 1, indices = keys + 1;
  push_keys(L, 1);
  auto n = static_cast<lua_Integer>(lua_rawlen(L, keys));
  for (lua_Integer i = 1; lua_rawgeti(L, indices + 1, i) != LUA_TNIL; ++i) {
    if (missing(indices)) {
      lua_pushvalue(L, -1);
      lua_rawseti(L, keys, ++n);
      lua_pushvalue(L, -1);
      lua_pushinteger(L, n);
      lua_rawset(L, indices);
    }
    lua_pop(L, 1);
  }
  lua_settop(L, keys - 1);
}

// A new walk at index `walk` of the stack, and in the registry.
void start_walk(lua_State* L, int walks, int walk) {
  lua_createtable(L, 4, 0);
  lua_newtable(L), lua_rawseti(L, -2, kKeys);
  lua_newtable(L), lua_rawseti(L, -2, kIndices);
  lua_replace(L, walk);
  set_integer(L, walk, kFirst, 1), set_integer(L, walk, kStale, 0);
  list_keys(L, walk, [](int) { return true; });
  lua_pushvalue(L, 1), lua_pushvalue(L, walk);
  lua_rawset(L, walks);
}

// Pushes the first key from index `at` on that has a value, and the value; its index, or 0 behind the last.
lua_Integer push_alive(lua_State* L, int walk, lua_Integer at) {
  lua_rawgeti(L, walk, kKeys);
  const int keys = lua_gettop(L);
  for (; lua_rawgeti(L, keys, at) != LUA_TNIL; ++at) {
    lua_pushvalue(L, -1);
    if (lua_rawget(L, 1) != LUA_TNIL) {
      lua_remove(L, keys);
      return at;
    }
    lua_settop(L, keys);
  }
  lua_settop(L, keys - 1);
  return 0;
}

// next in the order of pairs, in constant time on average: the keys are sorted when a table is first asked for, and
// again when a walk from the start finds that keys came in. Keys that came in since the last listing come last.
int ordered_next(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_settop(L, 2);
  lua_rawgetp(L, LUA_REGISTRYINDEX, &kWalks);  // 3
  lua_pushvalue(L, 1);
  const bool known = lua_rawget(L, 3) != LUA_TNIL;  // 4: the walk
  const bool first = lua_isnil(L, 2);
  if (!known || (first && get_integer(L, 4, kStale) != 0)) start_walk(L, 3, 4);
  // where it goes on: at the first key, or behind the key that was given
  lua_Integer at = get_integer(L, 4, kFirst);
  if (!first) {
    const auto index_of_key = [L] {
      lua_rawgeti(L, 4, kIndices);
      const lua_Integer index = index_in(L, -1, 2);
      lua_pop(L, 1);
      return index;
    };
    lua_Integer index = index_of_key();
    if (index == 0) {
      lua_pushvalue(L, 2);
      if (lua_rawget(L, 1) == LUA_TNIL) return luaL_error(L, "invalid key to 'next'");
      start_walk(L, 3, 4);
      index = index_of_key();
    }
    at = index + 1;
  }
  lua_settop(L, 4);
  lua_Integer found = push_alive(L, 4, at);
  if (found == 0) {
    // behind the last: what is alive and not in the list, or before its first index, has come in meanwhile
    const lua_Integer before = get_integer(L, 4, kFirst);
    lua_rawgeti(L, 4, kKeys);
    const auto end = static_cast<lua_Integer>(lua_rawlen(L, -1));
    lua_pop(L, 1);
    list_keys(L, 4, [L, before](int indices) { return index_in(L, indices, -1) < before; });
    found = push_alive(L, 4, end + 1);
    if (found != 0) set_integer(L, 4, kStale, 1);
  }
  if (found == 0) {
    lua_pushnil(L);
    return 1;
  }
  if (first) set_integer(L, 4, kFirst, found);
  return 2;
}

constexpr lua_Integer kMaxLength = 50000000;  // of lists

// Merge sort: stable, n log n comparisons whatever the comparison says.
int stable_sort(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  const lua_Integer count = luaL_len(L, 1);
  if (count > kMaxLength) fail(L, "table.sort: expected at most 50 million values, got " + std::to_string(count));
  const bool custom = !lua_isnoneornil(L, 2);
  if (custom && count > 1) luaL_checktype(L, 2, LUA_TFUNCTION);
  // the values are copied, so that a comparison may do to the list what it wants
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
  // runs of doubling width are merged
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
  // sorted by a consistent order, no value belongs before the one in front of it
  for (std::size_t i = 1; custom && i < order.size(); ++i)
    if (before(order[i], order[i - 1])) return luaL_error(L, "invalid order function for sorting");
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
  int has_from = 0, has_to = 0;
  lua_Integer from = lua_tointegerx(L, first, &has_from), to = lua_tointegerx(L, first + 1, &has_to);
  if (!has_from) from = 1;
  if (!has_to) to = lua_type(L, 1) == LUA_TTABLE ? static_cast<lua_Integer>(lua_rawlen(L, 1)) : 0;
  const std::uint64_t count = count_between(from, to);
  if (count > static_cast<std::uint64_t>(kMaxLength))
    fail(L, std::string("table.") + name + ": expected at most 50 million values");
  charge(L, count);
}

// insert, remove, move, concat and unpack walk as far as lengths and arguments say: what they walk over is charged,
// then the library's function runs in this one's place, so that its errors are those of stock Lua.
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
    // the values behind the index move
    const int least = name[0] == 'i' ? 3 : 2;
    int has_index = 0;
    const lua_Integer index = lua_tointegerx(L, 2, &has_index);
    if (lua_type(L, 1) == LUA_TTABLE && lua_gettop(L) >= least && has_index && index > 0)
      charge(L, count_between(index, static_cast<lua_Integer>(lua_rawlen(L, 1))) / 2);
  }
  return lua_tocfunction(L, lua_upvalueindex(1))(L);
}

}  // namespace

void open_ordered(lua_State* L) {
  lua_register(L, "pairs", guard<ordered_pairs>);
  lua_register(L, "next", guard<ordered_next>);
  push_weak_table(L, "k");
  lua_rawsetp(L, LUA_REGISTRYINDEX, &kWalks);
  lua_getglobal(L, "table");
  set_field(L, "sort", guard<stable_sort>);
  lua_pop(L, 1);
  wrap(L, "table", {"insert", "remove"}, guard<bounded_list<Walk::shift>>, true);
  wrap(L, "table", {"move"}, guard<bounded_list<Walk::move>>, true);
  wrap(L, "table", {"concat", "unpack"}, guard<bounded_list<Walk::range>>, true);
}

}  // namespace feder::lua
