// Invariants between steps, asserted where asserts are on: surfaces own consecutive runs of points, each is in one
// group, pairs and rows name points and surfaces that exist.
#include <algorithm>

#include "contact/impl.h"

namespace feder {

void SurfaceContact::Impl::validate_group(std::size_t k) const {
  const SurfaceGroup& g = *surfaces.groups[k];
  const NearSearch& near = *searches[k];
  int most = 0;
  for (std::size_t i = 0; i < g.members.size(); ++i) {
    FEDER_ASSERT(g.members[i] < list.size() && (i == 0 || g.members[i - 1] < g.members[i]));
    FEDER_ASSERT(list[g.members[i]].loop == k);
    most = std::max(most, static_cast<int>(list[g.members[i]].steps));
  }
  FEDER_ASSERT(g.steps <= most);
  const std::uint32_t size = surfaces.size();
  for (const SurfaceAttachment& a : g.attachments) FEDER_ASSERT(a.vertex < size);
  for (const SurfaceRow& r : g.rows)
    for (const std::uint32_t i : r.vertex) FEDER_ASSERT(i < size);
  for (std::size_t i = 1; i < near.near_vertex.size(); ++i)
    FEDER_ASSERT(near.pairs.empty() || near.near_vertex[i - 1] < near.near_vertex[i]);
  for (const NearPair& p : near.pairs) {
    FEDER_ASSERT(p.edges <= 1);
    FEDER_ASSERT(p.surface_pair == kNone || p.surface_pair < surface_pairs.size());
    for (const std::uint32_t i : p.v) {
      FEDER_ASSERT(i < size && near_surface[i] < list.size() && list[near_surface[i]].loop == k);
      FEDER_ASSERT(i - list[near_surface[i]].first < list[near_surface[i]].count);
    }
  }
}

void SurfaceContact::validate() const {
  const Impl& m = *impl_;
  std::uint32_t next = 0;
  for (const Surface& s : m.list) {
    FEDER_ASSERT(s.first == next && s.count <= s.total && s.steps >= 1 && s.thickness > 0);
    FEDER_ASSERT(s.loop < m.surfaces.group_count);
    next += s.total;
  }
  FEDER_ASSERT(next == m.surfaces.size() && m.delta_position.size() == next && m.velocity.size() == next);
  for (std::size_t k = 0; k < m.surface_pairs.size(); ++k) {
    const SurfacePair& b = m.surface_pairs[k];
    FEDER_ASSERT(b.a < m.list.size() && b.b < m.list.size() && m.list[b.a].object < m.list[b.b].object);
    FEDER_ASSERT(k == 0 || std::minmax(m.surface_pairs[k - 1].a, m.surface_pairs[k - 1].b) < std::minmax(b.a, b.b));
  }
  std::size_t members = 0;
  for (std::size_t k = 0; k < m.surfaces.group_count; ++k) {
    members += m.surfaces.groups[k]->members.size();
    m.validate_group(k);
  }
  FEDER_ASSERT(members == m.list.size());  // each surface in one
}

}  // namespace feder
