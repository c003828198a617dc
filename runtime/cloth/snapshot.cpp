// State hash and snapshots. Batches, ties, trees and pairs are not saved: they follow from the mesh and are made anew.
#include "cloth/impl.h"

namespace feder {
void Cloth::hash(Hash& h) const {
  const ClothVertices& p = impl_->vertices;
  for (const auto& s : impl_->sheets)
    for (std::uint32_t k = 0; k < s->total; ++k) {
      // hidden vertices have no script force; ghosts have their offset instead
      const std::uint32_t i = s->first + k, ghost = k - s->points;
      const bool hidden = k >= s->points && ghost < s->mesh.ghosts.size();
      h.add(p.position[i]), h.add(p.velocity[i]), h.add(hidden ? s->mesh.ghosts[ghost].offset : p.script_force[i]);
      h.add(p.mass[i]), h.add(p.inv_mass[i]);
    }
  for (const auto& s : impl_->sheets) {
    h.add(s->points), h.add(s->state.frozen), h.add(s->state.asleep), h.add(s->state.sleep_energy);
    h.add(s->flight()), h.add(s->state.load), h.add(s->state.substeps);
    h.bytes(s->solver_name.data(), s->solver_name.size());
    for (const std::uint32_t v : s->mesh.triangles) h.add(v);
  }
  for (const Attachment& a : impl_->attachments) h.add(a.vertex), h.add(a.body.slot), h.add(a.local);
}

void Cloth::save(Writer& w) const {
  ClothVertices::each_array(impl_->vertices, [&](const auto& array) { w.list(array); });
  w.list(impl_->attachments);
  w.add(static_cast<std::uint64_t>(impl_->force_count));
  w.add(impl_->gravity_known);
  for (int k = 0; k < 3; ++k) w.add(impl_->gravity[k]);
  w.add(static_cast<std::uint64_t>(impl_->sheets.size()));
  for (const auto& s : impl_->sheets) {
    w.add(s->object), w.add(s->first), w.add(s->points), w.add(s->total), w.add(s->version);
    w.add(s->settings);
    w.add(s->state);
    w.add(s->mass), w.add(s->mesh.grid);
    w.text(s->solver_name);
    s->solver_options.save(w);
    s->solver->save(w);
    w.list(s->mesh.triangles), w.list(s->mesh.edges), w.list(s->mesh.links), w.list(s->mesh.hinges);
    w.list(s->mesh.ghosts);
  }
}

void Cloth::load(Reader& r) {
  Impl& m = *impl_;
  ClothVertices::each_array(m.vertices, [&](auto& array) { r.list(array); });
  r.list(m.attachments);
  m.force_count = r.get<std::uint64_t>();
  r.get(m.gravity_known);
  for (int k = 0; k < 3; ++k) r.get(m.gravity[k]);
  const auto count = r.get<std::uint64_t>();
  m.sheets.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    auto s = std::make_unique<Sheet>(m.arena);
    r.get(s->object), r.get(s->first), r.get(s->points), r.get(s->total), r.get(s->version);
    r.get(s->settings);
    r.get(s->state);
    r.get(s->mass), r.get(s->mesh.grid);
    std::string name;
    r.text(name);
    Params options;
    options.load(r);
    m.attach_solver(*s, name, options);
    s->solver->load(r);
    r.list(s->mesh.triangles), r.list(s->mesh.edges), r.list(s->mesh.links), r.list(s->mesh.hinges);
    r.list(s->mesh.ghosts);
    m.sheets.push_back(std::move(s));
  }
  m.declare_surfaces();
  m.surfaces.forget();
  *m.structure_changed = true;
}

}  // namespace feder
