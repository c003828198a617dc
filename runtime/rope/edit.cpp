// Reading and editing of ropes between steps, and queries of the world.
#include <algorithm>
#include <cmath>

#include "base/trig.h"
#include "feder/body.h"
#include "rope/impl.h"

namespace feder {
namespace {

void check_vector(const Vec3& v, const char* what) {
  if (!is_finite(v)) throw SceneError(std::string(what) + ": expected three finite numbers");
}

double angle_between(const Vec3& a, const Vec3& b) {
  return arc_tangent2(length(cross(wide(a), wide(b))), dot(wide(a), wide(b)));
}

}  // namespace

double Line::elastic_energy(const Array<Vec3>& x) const {
  double sum = 0;
  const std::uint32_t n = size();
  for (std::uint32_t k = 0; k + 1 < n; ++k) {
    const double rest_now = double(rest_length[k]), s = length(wide(x[k + 1]) - wide(x[k])) / rest_now - 1;
    sum += 0.5 * double(settings.stretch) * rest_now * s * s;
  }
  if (!(settings.bend > 0)) return sum;
  const auto segment = [&](std::uint32_t i) { return Vec3(x[i + 1] - x[i]); };
  for (std::uint32_t i = 1; i + 1 < n; ++i) {
    const double angle = angle_between(segment(i - 1), segment(i));
    sum += double(settings.bend) / (double(rest_length[i - 1]) + double(rest_length[i])) * angle * angle;
  }
  for (int k = 0; k < 2; ++k) {
    if (!state.clamped[k]) continue;
    const std::uint32_t i = k ? n - 2 : 0;
    const double angle =
        angle_between(segment(i), Vec3(state.direction[k][0], state.direction[k][1], state.direction[k][2]));
    sum += double(settings.bend) / double(rest_length[i]) * angle * angle;
  }
  return sum;
}

std::uint32_t Rope::Impl::point(ObjectId id, std::size_t i) const {
  const std::uint32_t size = line(id).size();
  if (i >= size)
    throw SceneError(objects.describe(id) + ": expected a point number from 1 to " + std::to_string(size) + ", got " +
                     std::to_string(i + 1));
  return static_cast<std::uint32_t>(i);
}

std::size_t Rope::count() const {
  std::size_t sum = 0;
  for (const auto& l : impl_->lines) sum += l->size();
  return sum;
}
std::size_t Rope::point_count(ObjectId id) const { return impl_->line(id).size(); }
Vec3 Rope::point(ObjectId id, std::size_t i) const { return impl_->line(id).position[impl_->point(id, i)]; }
Vec3 Rope::velocity(ObjectId id, std::size_t i) const { return impl_->line(id).velocity[impl_->point(id, i)]; }
Real Rope::point_mass(ObjectId id, std::size_t i) const { return impl_->line(id).mass[impl_->point(id, i)]; }
bool Rope::pinned(ObjectId id, std::size_t i) const { return impl_->line(id).inv_mass[impl_->point(id, i)] == 0; }

void Rope::set_point(ObjectId id, std::size_t i, const Vec3& x) {
  const Command command(impl_->commands, "rope.set_point", id, i, x);
  const std::uint32_t at = impl_->point(id, i);
  check_vector(x, "set_point");
  Line& l = impl_->line(id);
  impl_->wake(l, WakeCause::script, {});
  l.position[at] = x;
}

void Rope::set_velocity(ObjectId id, std::size_t i, const Vec3& v) {
  const Command command(impl_->commands, "rope.set_velocity", id, i, v);
  const std::uint32_t at = impl_->point(id, i);
  check_vector(v, "set_velocity");
  Line& l = impl_->line(id);
  if (l.state.frozen) return;
  impl_->wake(l, WakeCause::script, {});
  if (l.inv_mass[at] != 0) l.velocity[at] = v;
}

void Rope::apply_impulse(ObjectId id, std::size_t i, const Vec3& impulse) {
  const Command command(impl_->commands, "rope.apply_impulse", id, i, impulse);
  const std::uint32_t at = impl_->point(id, i);
  check_vector(impulse, "apply_impulse");
  Line& l = impl_->line(id);
  if (l.state.frozen) return;
  impl_->wake(l, WakeCause::script, {});
  l.velocity[at] += l.inv_mass[at] * impulse;
}

void Rope::pin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "rope.pin", id, i);
  const std::uint32_t at = impl_->point(id, i);
  Line& l = impl_->line(id);
  l.inv_mass[at] = 0, l.velocity[at] = Vec3::Zero();
  l.derive();
}

void Rope::unpin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "rope.unpin", id, i);
  const std::uint32_t at = impl_->point(id, i);
  Line& l = impl_->line(id);
  if (l.state.frozen) return;
  impl_->wake(l, WakeCause::script, {});
  if (at == 0) l.state.clamped[0] = 0;
  if (at + 1 == l.size()) l.state.clamped[1] = 0;
  l.inv_mass[at] = 1 / l.mass[at];
  l.derive();
}

Real Rope::strain(ObjectId id, std::size_t k) const {
  const Line& l = impl_->line(id);
  if (k >= l.rest_length.size())
    throw SceneError(impl_->objects.describe(id) + ": expected a segment number from 1 to " +
                     std::to_string(l.rest_length.size()) + ", got " + std::to_string(k + 1));
  const double now = length(wide(l.position[k + 1]) - wide(l.position[k]));
  return static_cast<Real>(now / double(l.rest_length[k]) - 1);
}

Real Rope::max_strain(ObjectId id) const {
  Real largest = -1;
  for (std::size_t k = 0; k < impl_->line(id).rest_length.size(); ++k) largest = std::max(largest, strain(id, k));
  return largest;
}

Real Rope::tension(ObjectId id, std::size_t k) const { return impl_->line(id).settings.stretch * strain(id, k); }

Real Rope::current_length(ObjectId id) const {
  const Line& l = impl_->line(id);
  Real sum = 0;
  for (std::size_t k = 0; k + 1 < l.position.size(); ++k) sum += length(Vec3(l.position[k + 1] - l.position[k]));
  return sum;
}

void Rope::positions(ObjectId id, std::vector<Vec3>& out) const {
  const Line& l = impl_->line(id);
  out.assign(l.position.begin(), l.position.end());
}

void Rope::set_script_force(ObjectId id, std::size_t i, const Vec3& force) {
  const Command command(impl_->commands, "rope.set_script_force", id, i, force);
  const std::uint32_t at = impl_->point(id, i);
  check_vector(force, "force");
  impl_->wake(impl_->line(id), WakeCause::force, {});
  impl_->line(id).script_force[at] = force;
}

void Rope::clear_script_forces() {
  const Command command(impl_->commands, "rope.clear_script_forces");
  for (auto& l : impl_->lines)
    for (Vec3& f : l->script_force) f = Vec3::Zero();
}

int Rope::substeps(ObjectId id) const { return impl_->line(id).state.substeps; }
bool Rope::asleep(ObjectId id) const { return impl_->line(id).state.asleep != 0; }
bool Rope::quarantined(ObjectId id) const { return impl_->line(id).state.frozen != 0; }
void Rope::wake(ObjectId id, WakeCause cause, ObjectId other) {
  const Command command(impl_->commands, "rope.wake", id, cause, other);
  impl_->wake(impl_->line(id), cause, other);
}
void Rope::sleep(ObjectId id) {
  const Command command(impl_->commands, "rope.sleep", id);
  impl_->put_to_sleep(impl_->line(id));
}

void Rope::attach(ObjectId id, std::size_t i, ObjectId body, const Vec3& local) {
  const Command command(impl_->commands, "rope.attach", id, i, body, local);
  hold_to_body(impl_->store, impl_->objects, id, impl_->point(id, i), body, local);
  *impl_->structure_changed = true;
}

void Rope::attach_point(ObjectId id, std::size_t i, ObjectId other, std::size_t j) {
  const Command command(impl_->commands, "rope.attach_point", id, i, other, j);
  hold_point(impl_->store, impl_->objects, id, impl_->point(id, i), other, j, Vec3(0, 0, 0));
  *impl_->structure_changed = true;
}

void Rope::detach(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "rope.detach", id, i);
  if (release_point(impl_->store, impl_->objects, id, impl_->point(id, i))) *impl_->structure_changed = true;
}

std::size_t Rope::rope_count() const { return impl_->lines.size(); }
Rope::Info Rope::info(std::size_t n) const {
  FEDER_ASSERT(n < impl_->lines.size());
  const Line& l = *impl_->lines[n];
  return {l.object, {l.position.data(), l.position.size()}, {l.inv_mass.data(), l.inv_mass.size()}, l.settings.radius};
}

Energy Rope::energy(const Vec3& gravity) const {
  Energy e;
  for (const auto& l : impl_->lines) {
    for (std::uint32_t i = 0; i < l->size(); ++i) {
      const double m = l->mass[i];
      e.kinetic += 0.5 * m * double(dot(l->velocity[i], l->velocity[i]));
      e.potential -= m * double(l->settings.gravity_scale) * double(dot(gravity, l->position[i]));
    }
    e.elastic += l->elastic_energy(l->position);
    impl_->each_force(*l, [&](const ForceEntry& f) {
      for (std::uint32_t i = 0; i < l->size(); ++i) {
        const MassPoint point = impl_->mass_point(*l, i);
        e.potential += f.force->potential(&point, 1);
      }
    });
  }
  return e;
}

Momentum Rope::momentum() const {
  Momentum sum;
  for (const auto& l : impl_->lines)
    for (std::uint32_t i = 0; i < l->size(); ++i) {
      const Double3 x = wide(l->position[i]), p = double(l->mass[i]) * wide(l->velocity[i]), a = cross(x, p);
      sum.linear[0] += p.x, sum.linear[1] += p.y, sum.linear[2] += p.z;
      sum.angular[0] += a.x, sum.angular[1] += a.y, sum.angular[2] += a.z;
    }
  return sum;
}

void Rope::residuals(std::vector<Residual>& out) const {
  double strain = 0, frozen = 0, sleeping = 0, steps = 1, missed = 0;
  for (const auto& l : impl_->lines) {
    strain = std::max(strain, double(max_strain(l->object)));
    frozen += l->state.frozen != 0, sleeping += l->state.asleep != 0;
    steps = std::max(steps, double(l->state.substeps));
    if (l->active()) missed = std::max(missed, l->missed);
  }
  out.push_back({"rope.max_strain", strain});
  out.push_back({"rope.substeps", steps});
  out.push_back({"rope.solves", static_cast<double>(impl_->solves)});
  out.push_back({"rope.missed", missed});
  out.push_back({"rope.sleeping", sleeping});
  out.push_back({"rope.quarantined", frozen});
}

bool Rope::finite() const {
  for (const auto& l : impl_->lines) {
    if (l->state.frozen) return false;
    for (std::uint32_t i = 0; i < l->size(); ++i)
      if (!is_finite(l->position[i]) || !is_finite(l->velocity[i])) return false;
  }
  return true;
}

}  // namespace feder
