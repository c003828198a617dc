// State hash, snapshots and validation of ropes.
#include "rope/impl.h"

namespace feder {

void Rope::hash(Hash& h) const {
  for (const auto& l : impl_->lines) {
    for (std::uint32_t i = 0; i < l->size(); ++i) {
      h.add(l->position[i]), h.add(l->velocity[i]), h.add(l->script_force[i]);
      h.add(l->mass[i]), h.add(l->inv_mass[i]);
    }
    for (const Real x : l->rest_length) h.add(x);
    for (const Vec3& f : l->point_force) h.add(f);
    for (const Vec3& f : l->segment_force) h.add(f);
    h.add(l->state.frozen), h.add(l->state.asleep), h.add(l->state.sleep_energy), h.add(l->flight());
    h.add(l->state.clamped[0]), h.add(l->state.clamped[1]);
  }
}

void Rope::save(Writer& w) const {
  w.add(static_cast<std::uint64_t>(impl_->force_count));
  w.add(impl_->gravity_known);
  for (int k = 0; k < 3; ++k) w.add(impl_->gravity[k]);
  w.add(static_cast<std::uint64_t>(impl_->lines.size()));
  for (const auto& l : impl_->lines) Line::each_saved(std::as_const(*l), saved_to(w));
}

void Rope::load(Reader& r) {
  Impl& m = *impl_;
  m.force_count = r.get<std::uint64_t>();
  r.get(m.gravity_known);
  for (int k = 0; k < 3; ++k) r.get(m.gravity[k]);
  const auto count = r.get<std::uint64_t>();
  m.lines.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    auto l = std::make_unique<Line>(m.arena);
    Line::each_saved(*l, loaded_from(r));
    l->derive();
    m.lines.push_back(std::move(l));
  }
  m.declare_surfaces();
  m.surfaces.forget();
  *m.structure_changed = true;
}

void Rope::validate() const {
  const Impl& m = *impl_;
  for (std::uint32_t n = 0; n < m.lines.size(); ++n) {
    const Line& l = *m.lines[n];
    const std::size_t size = l.size();
    FEDER_ASSERT(m.objects.alive(l.object) && m.objects.kind(l.object) == kRopeKind && m.objects.index(l.object) == n);
    FEDER_ASSERT(size >= 2 && l.velocity.size() == size && l.mass.size() == size && l.inv_mass.size() == size);
    FEDER_ASSERT(l.point_force.size() == size && l.segment_force.size() + 1 == size);
    FEDER_ASSERT(l.script_force.size() == size && l.rest_length.size() + 1 == size && l.edges.size() + 1 == size);
    FEDER_ASSERT(!(l.state.asleep && l.state.frozen) && l.state.substeps >= 1);
    FEDER_ASSERT(!l.state.clamped[0] || l.inv_mass[0] == 0);
    FEDER_ASSERT(!l.state.clamped[1] || l.inv_mass[size - 1] == 0);
    for (std::uint32_t i = 0; i < size; ++i) {
      FEDER_ASSERT(l.inv_mass[i] == 0 || l.inv_mass[i] == 1 / l.mass[i]);
      FEDER_ASSERT((l.active() && l.inv_mass[i] != 0) || l.velocity[i].isZero(0));
      FEDER_ASSERT(is_finite(l.position[i]) && is_finite(l.velocity[i]));
    }
    for (const Real x : l.rest_length) FEDER_ASSERT(x > 0);
  }
}

}  // namespace feder
