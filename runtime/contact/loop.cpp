// Contact's passes in the loop of solver substeps, and what they need before it. Surfaces that coast (nets) have been
// moved by their own solver before the loop: within it their points move uniformly between contacts, and their owner
// reads back what contact changed when the loop is over.
#include <algorithm>

#include "contact/impl.h"

namespace feder {

void SurfaceContact::Impl::begin_substep(StepContext& c) {
  // no group iterates where nothing is active
  std::vector<int>& counts = c.counts(Loop::surface).count;
  counts.clear();
  bool any = false;
  for (const Surface& s : list) any = any || s.active;
  if (!any) return;
  gained_momentum.assign(list.size(), Vec3::Zero());
  const std::size_t solver_bodies =
      std::max<std::size_t>(surfaces.solver_bodies ? surfaces.solver_bodies->state.size() : 1, 1);
  surfaces.body_delta_position.assign(solver_bodies, Vec3::Zero()),
      surfaces.body_delta_rotation.assign(solver_bodies, Vec3::Zero());
  surfaces.body_rounding.assign(solver_bodies, Vec3::Zero());
  for (std::size_t k = 0; k < surfaces.group_count; ++k) {
    SurfaceGroup& g = *surfaces.groups[k];
    counts.push_back(g.steps);
    // the bodies that its rows may name, each once
    g.solver_indices.swap(g.named);
    g.named.clear();
    std::sort(g.solver_indices.begin(), g.solver_indices.end());
    g.solver_indices.erase(std::unique(g.solver_indices.begin(), g.solver_indices.end()), g.solver_indices.end());
    if (g.steps == 0) continue;
    // in how many parts the substep is searched and projected
    NearSearch& near = *searches[k];
    near.near = near_wanted(g);
    const int parts = near.near ? search_count(g, c) : 1;
    near.near_every = (g.steps + parts - 1) / parts;
  }
}

// Contact rows between surfaces for the coming part of the substep.
void SurfaceContact::Impl::find_near(StepContext& c) {
  SurfaceGroup& g = group(c);
  NearSearch& near = search(c);
  const int k = c.inner.index;
  const Real part = g.step * static_cast<Real>(std::min(near.near_every, g.steps - k));
  if (near.near && k % near.near_every == 0)
    make_near_rows(g, near, c.dt - static_cast<Real>(c.substep) * c.h - static_cast<Real>(k) * g.step, part);
  if (k == 0) g.crowded = near.near && !g.near_rows.empty();
}

// Calls f(point, solver substep) for the points of active surfaces that coast.
template <class F>
void SurfaceContact::Impl::each_coasting(const SurfaceGroup& g, F&& f) {
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    if (!s.coasts || !s.active) continue;
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i) f(i, g.step);
  }
}

void SurfaceContact::Impl::coast(StepContext& c) {
  each_coasting(group(c), [&](std::uint32_t i, Real h) {
    if (delta_position[i].w != 0) delta_position[i].add(h * velocity[i].vec());
    before[i] = {delta_position[i].x, delta_position[i].y, delta_position[i].z, 1};
  });
}

// Velocities of what coasts change by its contact corrections over the solver substep.
void SurfaceContact::Impl::read_velocities(StepContext& c) {
  each_coasting(group(c),
                [&](std::uint32_t i, Real h) { velocity[i].add((delta_position[i].vec() - before[i].vec()) / h); });
}

void SurfaceContact::Impl::project(StepContext& c) {
  const SurfaceGroup& g = group(c);
  NearSearch& near = search(c);
  const int k = c.inner.index;
  if (!near.near || (!c.inner.last() && (k + 1) % near.near_every != 0)) return;
  project_pairs(g, near, g.step * static_cast<Real>(k % near.near_every + 1));
  collect_near(g);
  if (c.inner.last()) remove_gained_momentum(g);
}

}  // namespace feder
