// State hash and snapshots of the springs system. Loading makes all nets anew, integrators by name with their memory.
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

namespace {

// Calls f(member) for what snapshots hold of a net before its integrator, and behind that.
template <class N, class F>
void each_saved_before(N& n, F&& f) {
  for_each_of(f, n.object, n.first, n.points, n.settings, n.can_break, n.has_power, n.warned_frozen, n.frozen,
              n.warned_stiff, n.warned_unconverged, n.warned_coincident, n.coincident, n.checked_step, n.frequency,
              n.decay, n.integrator_name);
}
template <class N, class F>
void each_saved_behind(N& n, F&& f) {
  for_each_of(f, n.integrator->stats, n.integrator->memory.points, n.integrator->memory.numbers);
  SpringArrays::each_array(n.springs, f);
  for_each_of(f, n.faces, n.rest_position);
}

}  // namespace

void Springs::save(Writer& w) const {
  Particles::each_array(impl_->particles, saved_to(w));
  for_each_of(saved_to(w), impl_->attachments, impl_->removed);
  w.add(static_cast<std::uint64_t>(impl_->nets.size()));
  for (const auto& n : impl_->nets) {
    each_saved_before(std::as_const(*n), saved_to(w));
    n->integrator_options.save(w);
    each_saved_behind(std::as_const(*n), saved_to(w));
  }
}

void Springs::load(Reader& r) {
  Impl& m = *impl_;
  Particles::each_array(m.particles, loaded_from(r));
  for_each_of(loaded_from(r), m.attachments, m.removed);
  const auto count = r.get<std::uint64_t>();
  m.nets.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    auto n = m.make_net();
    each_saved_before(*n, loaded_from(r));
    Params options;
    options.load(r);
    m.attach_integrator(*n, n->integrator_name, options);
    each_saved_behind(*n, loaded_from(r));
    n->list_edges();
    m.nets.push_back(std::move(n));
  }
  m.declare_surfaces();
  *m.structure_changed = true;
}

}  // namespace feder
