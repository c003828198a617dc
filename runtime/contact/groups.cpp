// Groups of surfaces: the connected components (union-find) of the graph whose edges are candidate pairs of this step
// and dynamic bodies that two surfaces act on, as couplings report them; static and kinematic bodies connect nothing.
// A group takes the largest number of solver substeps of its members, so that the most demanding cloth of a scene does
// not set the cost of all. Surfaces of different groups do not interact within a step: candidates hold for all of it.
#include <algorithm>

#include "contact/impl.h"

namespace feder {

// Root of n, the first surface of its group; with path halving.
std::uint32_t SurfaceContact::Impl::first_of(std::uint32_t n) {
  while (joined_to[n] != n) n = joined_to[n] = joined_to[joined_to[n]];
  return n;
}

void SurfaceContact::Impl::join(std::uint32_t a, std::uint32_t b) {
  a = first_of(a), b = first_of(b);
  joined_to[std::max(a, b)] = std::min(a, b);
}

void SurfaceContact::Impl::form_groups(StepContext& c) {
  // unite over candidate pairs, then over connections of couplings
  const std::uint32_t count = static_cast<std::uint32_t>(list.size());
  joined_to.resize(count);
  for (std::uint32_t n = 0; n < count; ++n) joined_to[n] = n;
  for (const SurfacePair& k : surface_pairs) join(k.a, k.b);
  surface_of_body.assign(surfaces.solver_bodies ? surfaces.solver_bodies->state.size() : 0, kNone);
  for (const Surfaces::Connection& l : surfaces.connections) {
    if (l.solver_index == 0) {
      join(l.a, l.b);
      continue;
    }
    FEDER_ASSERT(l.solver_index < surface_of_body.size());
    std::uint32_t& first = surface_of_body[l.solver_index];
    if (first == kNone) first = l.a;
    join(first, l.a);
  }
  surfaces.connections.clear();

  // number the groups in the order of their first members, which come before the others
  std::size_t& groups = surfaces.group_count;
  groups = 0;
  for (std::uint32_t n = 0; n < count; ++n) {
    Surface& s = list[n];
    const std::uint32_t first = first_of(n);
    FEDER_ASSERT(first <= n);
    s.loop = first == n ? static_cast<std::uint32_t>(groups) : list[first].loop;
    if (first == n && ++groups > surfaces.groups.size())
      surfaces.groups.push_back(std::make_unique<SurfaceGroup>(surfaces.arena));
    if (groups > searches.size()) searches.push_back(std::make_unique<NearSearch>(arena));
    SurfaceGroup& g = *surfaces.groups[s.loop];
    if (first == n) g.begin(), searches[s.loop]->begin();
    g.members.push_back(n);
    if (s.active) g.steps = std::max(g.steps, static_cast<int>(s.steps));
  }
  for (std::size_t k = 0; k < groups; ++k)
    if (SurfaceGroup& g = *surfaces.groups[k]; g.steps > 0) g.step = c.h / static_cast<Real>(g.steps);
  check_kept();
}

}  // namespace feder
