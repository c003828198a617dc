// Reading and editing of cloths between steps, for scripts and couplings.
#include <algorithm>

#include "cloth/impl.h"
#include "state/surface_links.h"

namespace feder {

std::uint32_t Cloth::Impl::vertex(ObjectId id, std::size_t i) const {
  const Sheet& s = sheet(id);
  if (i >= s.points)
    throw SceneError(objects.describe(id) + ": expected a vertex number from 1 to " + std::to_string(s.points) +
                     ", got " + std::to_string(i + 1));
  return s.first + static_cast<std::uint32_t>(i);
}

std::size_t Cloth::count() const {
  std::size_t sum = 0;
  for (const auto& s : impl_->sheets) sum += s->points;
  return sum;
}
std::size_t Cloth::vertex_count(ObjectId id) const { return impl_->sheet(id).points; }
std::size_t Cloth::triangle_count(ObjectId id) const { return impl_->sheet(id).mesh.triangles.size() / 3; }
std::size_t Cloth::edge_count(ObjectId id) const { return impl_->sheet(id).mesh.edges.size(); }

Vec3 Cloth::point(ObjectId id, std::size_t i) const { return impl_->vertices.position[impl_->vertex(id, i)]; }
Vec3 Cloth::velocity(ObjectId id, std::size_t i) const { return impl_->vertices.velocity[impl_->vertex(id, i)]; }
Real Cloth::point_mass(ObjectId id, std::size_t i) const { return impl_->vertices.mass[impl_->vertex(id, i)]; }
bool Cloth::pinned(ObjectId id, std::size_t i) const { return impl_->vertices.inv_mass[impl_->vertex(id, i)] == 0; }

void Cloth::set_point(ObjectId id, std::size_t i, const Vec3& x) {
  const Command command(impl_->commands, "cloth.set_point", id, i, x);
  const std::uint32_t at = impl_->vertex(id, i);
  if (!is_finite(x)) throw SceneError("set_point: expected three finite numbers");
  impl_->wake(impl_->sheet(id), WakeCause::script, {});
  impl_->vertices.position[at] = x;
  Sheet& s = impl_->sheet(id);
  if (s.edited.size() < s.points && !s.suspect)
    s.edited.push_back(at - s.first);
  else
    s.suspect = true, s.edited.clear();
  s.state.edited = 1;
  if (impl_->vertices.inv_mass[at] != 0) s.state.suspect_steps = Sheet::kSuspectSteps;  // pins only go with their path
}

void Cloth::set_velocity(ObjectId id, std::size_t i, const Vec3& v) {
  const Command command(impl_->commands, "cloth.set_velocity", id, i, v);
  const std::uint32_t at = impl_->vertex(id, i);
  if (!is_finite(v)) throw SceneError("set_velocity: expected three finite numbers");
  impl_->wake(impl_->sheet(id), WakeCause::script, {});
  if (impl_->vertices.inv_mass[at] != 0) impl_->vertices.velocity[at] = v;
  impl_->sheet(id).kinetic = -1;
}

void Cloth::apply_impulse(ObjectId id, std::size_t i, const Vec3& impulse) {
  const Command command(impl_->commands, "cloth.apply_impulse", id, i, impulse);
  const std::uint32_t at = impl_->vertex(id, i);
  if (!is_finite(impulse)) throw SceneError("apply_impulse: expected three finite numbers");
  impl_->wake(impl_->sheet(id), WakeCause::script, {});
  impl_->vertices.velocity[at] += impl_->vertices.inv_mass[at] * impulse;
  impl_->sheet(id).kinetic = -1;
}

void Cloth::pin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "cloth.pin", id, i);
  const std::uint32_t at = impl_->vertex(id, i);
  impl_->vertices.inv_mass[at] = 0;
  impl_->vertices.velocity[at] = Vec3::Zero();
  impl_->sheet(id).paths_stale = true;
  impl_->sheet(id).kinetic = -1;
}

void Cloth::unpin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "cloth.unpin", id, i);
  const std::uint32_t at = impl_->vertex(id, i);
  Sheet& s = impl_->sheet(id);
  if (s.state.frozen) return;
  impl_->wake(s, WakeCause::script, {});
  FEDER_ASSERT(!(impl_->vertices.mass[at] < 0));
  impl_->vertices.inv_mass[at] = 1 / impl_->vertices.mass[at];
  s.paths_stale = true;
}

Real Cloth::strain(ObjectId id, std::size_t k) const {
  const Sheet& s = impl_->sheet(id);
  if (k >= s.mesh.edges.size())
    throw SceneError(impl_->objects.describe(id) + ": expected an edge number from 1 to " +
                     std::to_string(s.mesh.edges.size()) + ", got " + std::to_string(k + 1));
  const ClothLink& l = s.mesh.links[k];
  FEDER_ASSERT(l.a == s.mesh.edges[k].a && l.b == s.mesh.edges[k].b);
  const Vec3* x = impl_->vertices.position.data() + s.first;
  return length(x[l.b] - x[l.a]) / l.rest - 1;
}

Real Cloth::max_strain(ObjectId id) const {
  const Sheet& s = impl_->sheet(id);
  Real largest = -1;
  for (std::size_t k = 0; k < s.mesh.edges.size(); ++k) largest = std::max(largest, strain(id, k));
  return largest;
}

void Cloth::positions(ObjectId id, std::vector<Vec3>& out) const {
  const Sheet& s = impl_->sheet(id);
  const auto begin = impl_->vertices.position.begin() + s.first;
  out.assign(begin, begin + s.points);
}

void Cloth::triangles(ObjectId id, std::vector<std::uint32_t>& out) const {
  const Sheet& s = impl_->sheet(id);
  out.assign(s.mesh.triangles.begin(), s.mesh.triangles.end());
}

void Cloth::normals(ObjectId id, std::vector<Vec3>& out) const {
  const Sheet& s = impl_->sheet(id);
  const Vec3* x = impl_->vertices.position.data() + s.first;
  out.assign(s.points, Vec3(0, 0, 0));
  for (std::size_t t = 0; t < s.mesh.triangles.size(); t += 3) {
    const std::uint32_t* v = &s.mesh.triangles[t];
    const Vec3 n = normalized_or(cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]), Vec3(0, 0, 0));
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = x[v[(k + 1) % 3]] - x[v[k]], b = x[v[(k + 2) % 3]] - x[v[k]];
      out[v[k]] += arc_tan2(length(cross(a, b)), dot(a, b)) * n;
    }
  }
  for (Vec3& n : out) n = normalized_or(n, Vec3(0, 1, 0));
}

// Laplacian smoothing: each vertex half-way to the mean of its neighbours along edges (those of the border along the
// border), then pushed out again by as much as that step shrinks (Taubin 1995): wrinkles of one cell go, folds stay.
// Pinned vertices stay.
void Cloth::smooth_positions(ObjectId id, std::vector<Vec3>& out) const {
  const Sheet& s = impl_->sheet(id);
  positions(id, out);
  std::vector<Vec3> sum(s.points);
  std::vector<Real> count(s.points);
  std::vector<char> border(s.points, 0);
  for (const ClothEdge& e : s.mesh.edges)
    if (e.triangle[1] == kNone) border[e.a] = border[e.b] = 1;
  for (const Real share : {Real(0.5), Real(-0.53)}) {
    std::fill(sum.begin(), sum.end(), Vec3(0, 0, 0));
    std::fill(count.begin(), count.end(), Real(0));
    for (const ClothEdge& e : s.mesh.edges) {
      const bool rim = e.triangle[1] == kNone;
      if (rim || !border[e.a]) sum[e.a] += out[e.b], count[e.a] += 1;
      if (rim || !border[e.b]) sum[e.b] += out[e.a], count[e.b] += 1;
    }
    for (std::uint32_t i = 0; i < s.points; ++i)
      if (count[i] > 0 && impl_->vertices.inv_mass[s.first + i] != 0) out[i] += share * (sum[i] / count[i] - out[i]);
  }
}

void Cloth::set_script_force(ObjectId id, std::size_t i, const Vec3& force) {
  const Command command(impl_->commands, "cloth.set_script_force", id, i, force);
  const std::uint32_t at = impl_->vertex(id, i);
  if (!is_finite(force)) throw SceneError("force: expected three finite numbers");
  impl_->wake(impl_->sheet(id), WakeCause::force, {});
  impl_->vertices.script_force[at] = force;
}

void Cloth::clear_script_forces() {
  const Command command(impl_->commands, "cloth.clear_script_forces");
  for (Vec3& f : impl_->vertices.script_force) f = Vec3::Zero();
}

int Cloth::substeps(ObjectId id) const { return impl_->sheet(id).state.substeps; }
bool Cloth::asleep(ObjectId id) const { return impl_->sheet(id).state.asleep != 0; }
bool Cloth::quarantined(ObjectId id) const { return impl_->sheet(id).state.frozen != 0; }
void Cloth::wake(ObjectId id, WakeCause cause, ObjectId other) {
  const Command command(impl_->commands, "cloth.wake", id, cause, other);
  impl_->wake(impl_->sheet(id), cause, other);
}
void Cloth::sleep(ObjectId id) {
  const Command command(impl_->commands, "cloth.sleep", id);
  impl_->put_to_sleep(impl_->sheet(id));
}

void Cloth::attach(ObjectId id, std::size_t i, ObjectId body, const Vec3& local) {
  const Command command(impl_->commands, "cloth.attach", id, i, body, local);
  const std::uint32_t at = impl_->vertex(id, i);
  if (!impl_->objects.alive(body) || impl_->objects.kind(body) != kBodyKind)
    throw SceneError("attach: expected a living body, got " + impl_->objects.describe(body));
  if (!is_finite(local)) throw SceneError("attach: expected three finite numbers");
  detach(id, i);
  FEDER_ASSERT(at < impl_->vertices.size() && impl_->vertices.cloth[at] == id);
  impl_->attachments.push_back({id, body, at, local});
  impl_->sheet(id).paths_stale = true;
  *impl_->structure_changed = true;
}

void Cloth::attach_point(ObjectId id, std::size_t i, ObjectId other, std::size_t j) {
  const Command command(impl_->commands, "cloth.attach_point", id, i, other, j);
  hold_point(impl_->store, impl_->objects, id, impl_->vertex(id, i) - impl_->sheet(id).first, other, j, Vec3(0, 0, 0));
  *impl_->structure_changed = true;
}

void Cloth::detach(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "cloth.detach", id, i);
  const std::uint32_t at = impl_->vertex(id, i);
  if (release_point(impl_->store, impl_->objects, id, i)) *impl_->structure_changed = true;
  if (std::erase_if(impl_->attachments, [&](const Attachment& a) { return a.vertex == at; }) == 0) return;
  impl_->wake(impl_->sheet(id), WakeCause::script, {});
  impl_->sheet(id).paths_stale = true;
  *impl_->structure_changed = true;
}

void Cloth::detach_body(ObjectId body) {
  const Command command(impl_->commands, "cloth.detach_body", body);
  for (const Attachment& a : impl_->attachments)
    if (a.body == body) impl_->sheet(a.cloth).paths_stale = true;
  if (std::erase_if(impl_->attachments, [&](const Attachment& a) { return a.body == body; }) > 0)
    *impl_->structure_changed = true;
}

const std::vector<Cloth::Attachment>& Cloth::attachments() const { return impl_->attachments; }

std::size_t Cloth::cloth_count() const { return impl_->sheets.size(); }

Cloth::Info Cloth::info(std::size_t n) const {
  FEDER_ASSERT(n < impl_->sheets.size());
  const Sheet& s = *impl_->sheets[n];
  return {s.object,
          s.first,
          s.points,
          {s.mesh.triangles.data(), s.mesh.triangles.size()},
          s.settings.thickness,
          s.settings.friction,
          s.solver->relaxation(),
          s.settings.group,
          s.settings.mask,
          !s.active(),
          s.active() && s.state.sleep_steps == 0};
}

const ClothVertices& Cloth::vertices() const { return impl_->vertices; }
void Cloth::set_impact(std::size_t n, Real acceleration, Real speed) {
  FEDER_ASSERT(!(acceleration < 0 || speed < 0));
  Sheet& s = *impl_->sheets[n];
  s.impact = std::max(s.impact, acceleration), s.approach_speed = std::max(s.approach_speed, speed);
}
void Cloth::set_beside_body(std::size_t n) {
  FEDER_ASSERT(n < impl_->sheets.size());
  impl_->sheets[n]->beside_body = true;
}
void Cloth::set_load(std::size_t n, Real mass) {
  FEDER_ASSERT(n < impl_->sheets.size() && !(mass < 0));
  impl_->sheets[n]->state.load = mass;
}
Real Cloth::load(std::size_t n) const { return impl_->sheets[n]->state.load; }
void Cloth::push(std::uint32_t i, const Vec3& p) {
  FEDER_ASSERT(impl_->sheet_of(i).active() || impl_->delta_position[i].w == 0);
  impl_->velocity[i].add(impl_->delta_position[i].w * p);
}

}  // namespace feder
