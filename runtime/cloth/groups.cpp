// Groups of cloths: connected over pairs that may touch in this step, and over dynamic bodies that two of them act on
// (couplings tell both); static and kinematic bodies connect nothing. A group takes the largest count of small steps
// of its members, so the hungriest cloth of a scene does not make all pay. Cloths of different groups do not meet
// within a step: pairs and candidates are found for the whole of it.
#include <algorithm>

#include "cloth/impl.h"

namespace feder {

// The first cloth of those that n has been joined with.
std::uint32_t Cloth::Impl::first_of(std::uint32_t n) {
  while (joined_to[n] != n) n = joined_to[n] = joined_to[joined_to[n]];
  return n;
}

void Cloth::Impl::join(std::uint32_t a, std::uint32_t b) {
  a = first_of(a), b = first_of(b);
  joined_to[std::max(a, b)] = std::min(a, b);
}

void Cloth::Impl::form_groups(StepContext& c) {
  const std::uint32_t count = static_cast<std::uint32_t>(sheets.size());
  joined_to.resize(count);
  for (std::uint32_t n = 0; n < count; ++n) joined_to[n] = n;
  for (const Between& k : between) join(k.a, k.b);
  mover_cloth.assign(movers ? movers->state.size() : 0, kNone);
  for (const Connection& l : connections) {
    if (l.mover == 0) {
      join(l.a, l.b);
      continue;
    }
    FEDER_ASSERT(l.mover < mover_cloth.size());
    std::uint32_t& first = mover_cloth[l.mover];
    if (first == kNone) first = l.a;
    join(first, l.a);
  }
  connections.clear();

  group_count = 0;
  for (std::uint32_t n = 0; n < count; ++n) {
    Sheet& s = *sheets[n];
    const std::uint32_t first = first_of(n);
    FEDER_ASSERT(first <= n);
    s.group = first == n ? static_cast<std::uint32_t>(group_count) : sheets[first]->group;
    if (first == n && ++group_count > groups.size()) groups.push_back(std::make_unique<ClothGroup>(arena));
    ClothGroup& g = *groups[s.group];
    if (first == n) g.begin();
    g.sheets.push_back(n);
    if (s.active()) g.steps = std::max(g.steps, static_cast<int>(s.state.substeps));
  }
  for (std::size_t k = 0; k < group_count; ++k)
    if (groups[k]->steps > 0) groups[k]->step = c.h / static_cast<Real>(groups[k]->steps);
  for (auto& s : sheets)  // read with the step of its own count
    if (s->active() && groups[s->group]->steps != s->state.substeps) gather(*s, groups[s->group]->step);
}

}  // namespace feder
