// Advice: what the systems of a world report before it runs, and feder.advise.
#include "lua/advice.h"

#include "lua/records.h"
#include "lua/stack.h"

namespace feder::lua {
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
  push_list(L, advise(state(L).options.parts, *record.world), [&](const Advice& advice) {
    lua_newtable(L);
    push_handle(L, record, advice.object);
    lua_setfield(L, -2, "object");
    set_field(L, "text", advice.text);
    for (const auto& [name, fact] : advice.facts)
      std::visit([&, key = name](const auto& x) { set_field(L, key, x); }, fact);
  });
  return 1;
}

}  // namespace feder::lua
