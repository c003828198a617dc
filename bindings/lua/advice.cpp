#include "lua/advice.h"

#include "lua/records.h"

namespace feder::lua {
namespace {

void push_fact(lua_State* L, const Advice::Fact& fact) {
  if (const auto* whole = std::get_if<std::int64_t>(&fact)) lua_pushinteger(L, static_cast<lua_Integer>(*whole));
  if (const auto* number = std::get_if<double>(&fact)) lua_pushnumber(L, *number);
  if (const auto* text = std::get_if<std::string>(&fact)) lua_pushlstring(L, text->data(), text->size());
}

}  // namespace

std::vector<Advice> advise(std::span<const Part* const> parts, World& world) {
  std::vector<Advice> all;
  for (const Part* part : parts) {
    if (!part->advise) continue;
    std::vector<Advice> some = part->advise(world);
    std::move(some.begin(), some.end(), std::back_inserter(all));
  }
  return all;
}

int feder_advise(lua_State* L) {
  const auto* block = static_cast<const WorldBlock*>(test_class(L, 1, Class::world));
  if (!block) fail_here(L, "expected a world, got " + describe(L, 1));
  WorldRecord& record = *state(L).worlds[block->world];
  if (!record.world) fail_here(L, "the world is closed");
  lua_newtable(L);
  lua_Integer count = 0;
  for (const Advice& advice : advise(state(L).options.parts, *record.world)) {
    lua_newtable(L);
    push_handle(L, record, advice.object);
    lua_setfield(L, -2, "object");
    lua_pushlstring(L, advice.text.data(), advice.text.size());
    lua_setfield(L, -2, "text");
    for (const auto& [name, fact] : advice.facts) {
      push_fact(L, fact);
      lua_setfield(L, -2, name);
    }
    lua_rawseti(L, -2, ++count);
  }
  return 1;
}

}  // namespace feder::lua
