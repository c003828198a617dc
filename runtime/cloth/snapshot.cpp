// State hash and snapshots. Batches, ties, trees and pairs are not saved: they follow from the mesh and are made anew.
#include "cloth/impl.h"

namespace feder {
namespace {

// Calls number(field) for what is saved as bytes before the solver of a cloth, and list(array) for its mesh behind it.
template <class S, class F>
void each_number(S& s, F&& number) {
  number(s.object), number(s.first), number(s.points), number(s.total), number(s.version);
  number(s.settings), number(s.state), number(s.mass), number(s.mesh.grid);
}
template <class M, class F>
void each_list(M& mesh, F&& list) {
  list(mesh.triangles), list(mesh.edges), list(mesh.links), list(mesh.hinges), list(mesh.ghosts);
}

}  // namespace

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
    if (const ClothState& t = s->state; t.tangles)
      h.add(t.tangles), h.add(t.least_tangles), h.add(t.tangled_steps), h.add(t.tangles_rest), h.add(t.released);
    h.add(s->flight()), h.add(s->state.load), h.add(s->state.substeps);
    h.bytes(s->solver_name.data(), s->solver_name.size());
    for (const std::uint32_t v : s->mesh.triangles) h.add(v);
    if (s->settings.pressure != 0) h.add(s->settings.pressure);
    if (!s->settings.flows()) continue;
    for (const ClothLink& l : s->mesh.links) h.add(l.rest);
    for (const ClothHinge& k : s->mesh.hinges) h.add(k.angle);
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
    each_number(*s, [&](const auto& x) { w.add(x); });
    w.text(s->search_name);
    w.text(s->solver_name);
    s->solver_options.save(w);
    s->solver->save(w);
    each_list(s->mesh, [&](const auto& array) { w.list(array); });
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
    each_number(*s, [&](auto& x) { r.get(x); });
    r.text(s->search_name);
    s->find_search();
    std::string name;
    r.text(name);
    Params options;
    options.load(r);
    m.attach_solver(*s, name, options);
    s->solver->load(r);
    each_list(s->mesh, [&](auto& array) { r.list(array); });
    s->suspect = true;
    m.sheets.push_back(std::move(s));
  }
  m.declare_surfaces();
  m.surfaces.forget();
  *m.structure_changed = true;
}

}  // namespace feder
