// State hash and snapshots of the springs system. A net that was destroyed or made since is undone: integrators are
// made again by name and get back what they remembered.
#include "springs/impl.h"

namespace feder {
void Springs::hash(Hash& h) const {
  const Particles& p = impl_->particles;
  for (std::uint32_t i = 0; i < p.size(); ++i) {
    h.add(p.position[i]), h.add(p.position_low[i]), h.add(p.velocity[i]), h.add(p.script_force[i]);
    h.add(p.mass[i]), h.add(p.inv_mass[i]);
  }
  for (const auto& n : impl_->nets) {
    h.add(n->points), h.add(n->frozen);
    h.bytes(n->integrator_name.data(), n->integrator_name.size());
    for (const Vec3& x : n->integrator->memory.points) h.add(x);
    for (const double d : n->integrator->memory.numbers) h.add(d);
    for (std::uint32_t k = 0; k < n->springs.size(); ++k) {
      h.add(n->springs.i[k]), h.add(n->springs.j[k]), h.add(n->springs.alive[k]), h.add(n->springs.tension_only[k]);
      h.add(n->springs.power[k]);
      h.add(n->springs.stiffness[k]), h.add(n->springs.damping[k]), h.add(n->springs.rest_length[k]);
    }
  }
  for (const Attachment& a : impl_->attachments) h.add(a.point), h.add(a.body.slot), h.add(a.local);
}

void Springs::save(Writer& w) const {
  Particles::each_array(impl_->particles, [&](const auto& array) { w.list(array); });
  w.list(impl_->attachments), w.list(impl_->removed);
  w.add(static_cast<std::uint64_t>(impl_->nets.size()));
  for (const auto& n : impl_->nets) {
    w.add(n->object), w.add(n->first), w.add(n->points), w.add(n->settings);
    w.add(n->can_break), w.add(n->has_power), w.add(n->warned_frozen);
    w.add(n->frozen), w.add(n->warned_stiff), w.add(n->warned_unconverged);
    w.add(n->warned_coincident), w.add(n->coincident), w.add(n->checked_step), w.add(n->frequency), w.add(n->decay);
    w.text(n->integrator_name);
    n->integrator_options.save(w);
    w.add(n->integrator->stats);
    w.list(n->integrator->memory.points), w.list(n->integrator->memory.numbers);
    SpringArrays::each_array(n->springs, [&](const auto& array) { w.list(array); });
    w.list(n->faces), w.list(n->rest_position);
  }
}

void Springs::load(Reader& r) {
  Impl& m = *impl_;
  Particles::each_array(m.particles, [&](auto& array) { r.list(array); });
  r.list(m.attachments), r.list(m.removed);
  const auto count = r.get<std::uint64_t>();
  m.nets.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    auto n = m.make_net();
    r.get(n->object), r.get(n->first), r.get(n->points), r.get(n->settings);
    r.get(n->can_break), r.get(n->has_power), r.get(n->warned_frozen);
    r.get(n->frozen), r.get(n->warned_stiff), r.get(n->warned_unconverged);
    r.get(n->warned_coincident), r.get(n->coincident), r.get(n->checked_step), r.get(n->frequency), r.get(n->decay);
    std::string name;
    r.text(name);
    Params options;
    options.load(r);
    m.attach_integrator(*n, name, options);
    r.get(n->integrator->stats);
    r.list(n->integrator->memory.points), r.list(n->integrator->memory.numbers);
    SpringArrays::each_array(n->springs, [&](auto& array) { r.list(array); });
    r.list(n->faces), r.list(n->rest_position);
    n->list_edges();
    m.nets.push_back(std::move(n));
  }
  m.declare_surfaces();
  *m.structure_changed = true;
}

}  // namespace feder
