// A step as scripts see it, and snapshots with their owner key.
#include "lua/step.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "lua/scene.h"

namespace feder::lua {
namespace {

// SipHash-2-4 (Aumasson and Bernstein 2012), keyed per world: a script that edits a snapshot cannot make its owner key
// again.

std::uint64_t sip_hash(const SipKey& key, std::string_view text) {
  std::uint64_t v[4] = {key.a ^ 0x736f6d6570736575ull, key.b ^ 0x646f72616e646f6dull, key.a ^ 0x6c7967656e657261ull,
                        key.b ^ 0x7465646279746573ull};
  const auto round = [&v] {
    v[0] += v[1], v[1] = std::rotl(v[1], 13) ^ v[0], v[0] = std::rotl(v[0], 32);
    v[2] += v[3], v[3] = std::rotl(v[3], 16) ^ v[2];
    v[0] += v[3], v[3] = std::rotl(v[3], 21) ^ v[0];
    v[2] += v[1], v[1] = std::rotl(v[1], 17) ^ v[2], v[2] = std::rotl(v[2], 32);
  };
  const auto absorb = [&](std::uint64_t m) {
    v[3] ^= m;
    round(), round();
    v[0] ^= m;
  };
  std::size_t i = 0;
  for (; i + 8 <= text.size(); i += 8) {
    std::uint64_t m = 0;
    std::memcpy(&m, text.data() + i, 8);
    absorb(m);
  }
  std::uint64_t last = static_cast<std::uint64_t>(text.size()) << 56;
  for (int shift = 0; i < text.size(); ++i, shift += 8)
    last |= static_cast<std::uint64_t>(static_cast<unsigned char>(text[i])) << shift;
  absorb(last);
  v[2] ^= 0xff;
  for (int k = 0; k < 4; ++k) round();
  return v[0] ^ v[1] ^ v[2] ^ v[3];
}

constexpr std::string_view kHeader = "feder snapshot\n";

// Those with these functions act again, and no others.
void restore_forces(WorldRecord& record, const std::vector<int>& functions) {
  std::vector<ScriptForce>& lost = record.lost_forces;
  lost.insert(lost.end(), record.forces.begin(), record.forces.end());
  record.forces.clear();
  for (const int function : functions) {
    const auto at = std::ranges::find(lost, function, &ScriptForce::function);
    if (at == lost.end()) continue;
    record.forces.push_back(std::move(*at));
    record.forces.back().held.clear();
    lost.erase(at);
  }
}

struct Busy {
  explicit Busy(WorldRecord& r) : record(r) { record.busy = true; }
  ~Busy() { record.busy = false; }
  WorldRecord& record;
};

}  // namespace

void run_step(lua_State* L, WorldRecord& record) {
  if (record.busy) fail_here(L, "the world is in a step; handlers and forces cannot step it");
  const Busy busy(record);
  const int top = lua_gettop(L);
  apply_script_forces(L, record);
  begin_stages(L, record);
  observe_start(*record.world, record.observed);
  state(L).outside_lua([&] { record.world->step(); });
  end_stages(L, record);
  observe_step(*record.world, record.observed);
  run_timers(L, record);
  dispatch_events(L, record);
  run_tasks(L, record);
  run_update(L, record);
  lua_settop(L, top);
}

std::string write_snapshot(WorldRecord& record) {
  std::string body;
  Writer w(body);
  w.add(static_cast<std::uint64_t>(record.special.size()));
  for (const auto& [id, kind] : record.special) w.add(id), w.add(kind);
  std::vector<int> functions;
  for (const ScriptForce& f : record.forces) functions.push_back(f.function);
  w.list(functions);
  w.text(record.world->snapshot());
  record.has_snapshots = true;
  const std::uint64_t owner_key = sip_hash(record.key, body);
  std::string text(kHeader);
  text.append(reinterpret_cast<const char*>(&owner_key), sizeof owner_key);
  return text + body;
}

void restore_snapshot(lua_State* L, WorldRecord& record, std::string_view text) {
  std::uint64_t owner_key = 0;
  if (text.substr(0, kHeader.size()) != kHeader || text.size() < kHeader.size() + sizeof owner_key)
    throw SceneError("expected a string that world:snapshot() gave");
  std::memcpy(&owner_key, text.data() + kHeader.size(), sizeof owner_key);
  text.remove_prefix(kHeader.size() + sizeof owner_key);
  if (owner_key != sip_hash(record.key, text)) throw SceneError("the snapshot is another world's, or has been changed");
  Reader r(text);
  std::map<ObjectId, Class> special;
  for (auto count = r.get<std::uint64_t>(); count > 0; --count) {
    ObjectId id;
    r.get(id), r.get(special[id]);
  }
  std::vector<int> functions;
  r.list(functions);
  std::string image;
  r.text(image);
  record_names(L, record);
  record.world->restore(image);
  record.special = std::move(special);
  record.subscriptions.events.clear();
  restore_forces(record, functions);
  for (auto& s : record.subscriptions.all)
    if (s->self && !record.world->objects().alive(s->self)) unsubscribe(L, record, s->id);
  invalidate_lost(L, record, short_location(L) + " (world:restore)");
}

}  // namespace feder::lua
