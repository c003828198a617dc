// State hash and snapshots of fluids. Particles are saved in their stored order, which is the order of sums.
#include "fluid/impl.h"

namespace feder {
namespace {

template <class P, class F>
void each_state(P& p, F&& f) {
  f(p.object), f(p.count), f(p.next_id), f(p.last_h), f(p.sound), f(p.excess), f(p.too_dense), f(p.unsolved),
      f(p.frozen), f(p.asleep), f(p.calm), f(p.rest_center), f(p.rest_key), f(p.fresh), f(p.layered);
  f(p.warned_budget), f(p.warned_full), f(p.warned_viscosity), f(p.warned_spacing), f(p.warned_density),
      f(p.filled_width);
}

}  // namespace

void Fluid::hash(Hash& h) const {
  for (const auto& p : impl_->pools) {
    h.add(p->count), h.add(p->next_id);
    if (p->sound > 0) h.add(p->sound);
    h.add(p->asleep);
    for (std::uint32_t i = 0; i < p->count; ++i) {
      h.add(p->id[i]);
      h.add(p->x[i].vec()), h.add(p->v[i].vec()), h.add(p->lambda[i]);
      if (!p->script_force.empty()) h.add(p->script_force[i].vec());
    }
  }
  for (const FluidEmitter& e : impl_->emitters) h.add(e.made), h.add(e.clock), h.add(e.running);
  for (const FluidDrain& d : impl_->drains) h.add(d.taken);
}

void Fluid::save(Writer& w) const {
  w.add(static_cast<std::uint64_t>(impl_->pools.size()));
  for (const auto& p : impl_->pools) {
    FluidDesc::each_field(p->desc, saved_to(w));
    each_state(*p, [&](const auto& x) { w.add(x); });
    for (std::uint32_t i = 0; i < p->count; ++i)
      w.add(p->x[i]), w.add(p->v[i]), w.add(p->lambda[i]), w.add(p->ratio[i]), w.add(p->id[i]);
    w.add(!p->script_force.empty());
    for (std::uint32_t i = 0; i < p->count && !p->script_force.empty(); ++i) w.add(p->script_force[i]);
  }
  w.list(impl_->emitters), w.list(impl_->drains), w.list(impl_->interfaces);
  w.add(impl_->lost);
}

void Fluid::load(Reader& r) {
  Impl& m = *impl_;
  m.pools.clear();
  const auto pools = r.get<std::uint64_t>();
  for (std::uint64_t k = 0; k < pools; ++k) {
    FluidDesc d;
    FluidDesc::each_field(d, loaded_from(r));
    auto p = std::make_unique<FluidPool>(m.arena, d, m.dimension);
    each_state(*p, [&](auto& x) { r.get(x); });
    const std::uint32_t count = p->count;
    p->count = 0;
    p->grow(count);
    p->count = count;
    for (std::uint32_t i = 0; i < count; ++i)
      r.get(p->x[i]), r.get(p->v[i]), r.get(p->lambda[i]), r.get(p->ratio[i]), r.get(p->id[i]);
    if (r.get<bool>()) {
      p->keep_script_forces();
      for (std::uint32_t i = 0; i < count; ++i) r.get(p->script_force[i]);
    }
    p->put_sentinel();
    m.solver_of(*p).keep(*p);
    if constexpr (kAsserts) p->ids_there = p->id_sum();
    p->kinetic = p->kinetic_energy();
    p->crowded = kScriptWindow;
    m.pools.push_back(std::move(p));
  }
  r.list(m.emitters), r.list(m.drains), r.list(m.interfaces);
  r.get(m.lost);
  *m.structure_changed = true;
}

}  // namespace feder
