// State hash, snapshots and validation of soft bodies.
#include <cstring>

#include "soft/impl.h"

namespace feder {

void Soft::hash(Hash& h) const {
  for (const auto& b : impl_->bodies) {
    for (std::uint32_t i = 0; i < b->size(); ++i) {
      h.add(b->position[i]), h.add(b->velocity[i]), h.add(b->script_force[i]);
      h.add(b->mass[i]), h.add(b->inv_mass[i]), h.add(b->mesh.rest[i]);
      h.add(b->contact[i]), h.add(b->steady_contact[i]);
    }
    for (const TetrahedronPoints& t : b->mesh.tetrahedra)
      for (const std::uint32_t i : t) h.add(i);
    for (const Real p : b->mesh.flowed) h.add(p);
    h.add(b->settings.yield), h.add(b->settings.flow), h.add(b->settings.fracture_stress);
    h.add(b->settings.young), h.add(b->settings.poisson), h.add(b->settings.damping);
    h.add(b->state.frozen), h.add(b->state.asleep), h.add(b->state.sleep_energy), h.add(b->flight());
    h.bytes(b->solver_name.data(), b->solver_name.size());
    h.bytes(b->law->name, std::strlen(b->law->name));
  }
}

void Soft::save(Writer& w) const {
  w.add(static_cast<std::uint64_t>(impl_->force_count));
  w.add(impl_->gravity_known);
  for (int k = 0; k < 3; ++k) w.add(impl_->gravity[k]);
  w.add(static_cast<std::uint64_t>(impl_->bodies.size()));
  for (const auto& b : impl_->bodies) {
    SoftBody::each_saved(std::as_const(*b), saved_to(w));
    SoftMesh::each_saved(std::as_const(b->mesh), saved_to(w));
    w.text(b->search_name);
    w.text(b->solver_name);
    b->solver_options.save(w);
    w.text(b->law->name);
    b->solver->save(w);
  }
}

void Soft::load(Reader& r) {
  Impl& m = *impl_;
  m.force_count = r.get<std::uint64_t>();
  r.get(m.gravity_known);
  for (int k = 0; k < 3; ++k) r.get(m.gravity[k]);
  const auto count = r.get<std::uint64_t>();
  m.bodies.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    auto b = std::make_unique<SoftBody>(m.arena);
    SoftBody::each_saved(*b, loaded_from(r));
    SoftMesh::each_saved(b->mesh, loaded_from(r));
    r.text(b->search_name);
    b->find_search();
    std::string name;
    r.text(name);
    Params options;
    options.load(r);
    std::string law;
    r.text(law);
    m.attach_solver(*b, name, options, law, "soft");
    b->solver->load(r);
    b->derive();
    m.bodies.push_back(std::move(b));
  }
  m.declare_surfaces();
  m.surfaces.forget();
  *m.structure_changed = true;
}

void Soft::validate() const {
  Impl& m = *impl_;
  for (std::uint32_t n = 0; n < m.bodies.size(); ++n) {
    SoftBody& b = *m.bodies[n];
    const std::size_t size = b.size();
    FEDER_ASSERT(m.objects.alive(b.object) && m.objects.kind(b.object) == kSoftKind && m.objects.index(b.object) == n);
    FEDER_ASSERT(size >= 4 && b.velocity.size() == size && b.mass.size() == size && b.inv_mass.size() == size);
    FEDER_ASSERT(b.script_force.size() == size && b.mesh.rest.size() == size && b.mesh.visible <= size);
    FEDER_ASSERT(b.contact.size() == size && b.steady_contact.size() == size);
    FEDER_ASSERT(b.mesh.inverse.size() == 9 * b.mesh.tetrahedra.size());
    FEDER_ASSERT(b.mesh.flowed.size() == (b.settings.flows() ? b.mesh.inverse.size() : 0));
    FEDER_ASSERT(b.mesh.part_points.size() == size && b.mesh.parts() >= 1);
    FEDER_ASSERT(!(b.state.asleep && b.state.frozen) && b.state.substeps >= 1);
    for (std::uint32_t i = 0; i < size; ++i) {
      FEDER_ASSERT(b.inv_mass[i] == 0 || b.inv_mass[i] == 1 / b.mass[i]);
      FEDER_ASSERT((b.active() && b.inv_mass[i] != 0) || b.velocity[i].isZero(0));
      FEDER_ASSERT(is_finite(b.position[i]) && is_finite(b.velocity[i]));
    }
    for (const Real v : b.mesh.volume) FEDER_ASSERT(v > 0);
    b.solver->validate(m.view(b));
  }
}

}  // namespace feder
