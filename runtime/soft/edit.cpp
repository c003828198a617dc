// Reading and editing of soft bodies between steps.
#include <algorithm>

#include "feder/body.h"
#include "soft/impl.h"

namespace feder {
namespace {

void check_finite(const Vec3& v, const char* what) {
  if (!is_finite(v)) throw SceneError(std::string(what) + ": expected three finite numbers");
}

}  // namespace

std::uint32_t Soft::Impl::point(ObjectId id, std::size_t i) const {
  const std::uint32_t size = body(id).size();
  if (i >= size)
    throw SceneError(objects.describe(id) + ": expected a point number from 1 to " + std::to_string(size) + ", got " +
                     std::to_string(i + 1));
  return static_cast<std::uint32_t>(i);
}

std::size_t Soft::point_count(ObjectId id) const { return impl_->body(id).size(); }
std::size_t Soft::tetrahedron_count(ObjectId id) const { return impl_->body(id).mesh.tetrahedra.size(); }
Vec3 Soft::point(ObjectId id, std::size_t i) const { return impl_->body(id).position[impl_->point(id, i)]; }
Vec3 Soft::rest_point(ObjectId id, std::size_t i) const { return impl_->body(id).mesh.rest[impl_->point(id, i)]; }
Vec3 Soft::velocity(ObjectId id, std::size_t i) const { return impl_->body(id).velocity[impl_->point(id, i)]; }
Real Soft::point_mass(ObjectId id, std::size_t i) const { return impl_->body(id).mass[impl_->point(id, i)]; }
bool Soft::pinned(ObjectId id, std::size_t i) const { return impl_->body(id).inv_mass[impl_->point(id, i)] == 0; }

void Soft::set_point(ObjectId id, std::size_t i, const Vec3& x) {
  const Command command(impl_->commands, "soft.set_point", id, i, x);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(x, "set_point");
  SoftBody& b = impl_->body(id);
  impl_->wake(b, WakeCause::script, {});
  b.position[at] = x;
}

void Soft::set_velocity(ObjectId id, std::size_t i, const Vec3& v) {
  const Command command(impl_->commands, "soft.set_velocity", id, i, v);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(v, "set_velocity");
  SoftBody& b = impl_->body(id);
  if (b.state.frozen) return;
  impl_->wake(b, WakeCause::script, {});
  if (b.inv_mass[at] != 0) b.velocity[at] = v;
}

void Soft::apply_impulse(ObjectId id, std::size_t i, const Vec3& impulse) {
  const Command command(impl_->commands, "soft.apply_impulse", id, i, impulse);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(impulse, "apply_impulse");
  SoftBody& b = impl_->body(id);
  if (b.state.frozen) return;
  impl_->wake(b, WakeCause::script, {});
  b.velocity[at] += b.inv_mass[at] * impulse;
}

void Soft::pin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "soft.pin", id, i);
  const std::uint32_t at = impl_->point(id, i);
  SoftBody& b = impl_->body(id);
  b.inv_mass[at] = 0, b.velocity[at] = Vec3::Zero();
  b.derive_mass();
}

void Soft::unpin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "soft.unpin", id, i);
  const std::uint32_t at = impl_->point(id, i);
  SoftBody& b = impl_->body(id);
  if (b.state.frozen) return;
  impl_->wake(b, WakeCause::script, {});
  b.inv_mass[at] = 1 / b.mass[at];
  b.derive_mass();
}

void Soft::set_script_force(ObjectId id, std::size_t i, const Vec3& force) {
  const Command command(impl_->commands, "soft.set_script_force", id, i, force);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(force, "force");
  impl_->wake(impl_->body(id), WakeCause::force, {});
  impl_->body(id).script_force[at] = force;
}

void Soft::clear_script_forces() {
  const Command command(impl_->commands, "soft.clear_script_forces");
  for (auto& b : impl_->bodies)
    for (Vec3& f : b->script_force) f = Vec3::Zero();
}

void Soft::wake(ObjectId id, WakeCause cause, ObjectId other) {
  const Command command(impl_->commands, "soft.wake", id, cause, other);
  impl_->wake(impl_->body(id), cause, other);
}

void Soft::sleep(ObjectId id) {
  const Command command(impl_->commands, "soft.sleep", id);
  impl_->put_to_sleep(impl_->body(id));
}

void Soft::attach(ObjectId id, std::size_t i, ObjectId body, const Vec3& local) {
  const Command command(impl_->commands, "soft.attach", id, i, body, local);
  hold_to_body(impl_->store, impl_->objects, id, impl_->point(id, i), body, local);
  *impl_->structure_changed = true;
}

void Soft::attach_point(ObjectId id, std::size_t i, ObjectId other, std::size_t j) {
  const Command command(impl_->commands, "soft.attach_point", id, i, other, j);
  hold_point(impl_->store, impl_->objects, id, impl_->point(id, i), other, j, Vec3(0, 0, 0));
  *impl_->structure_changed = true;
}

void Soft::detach(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "soft.detach", id, i);
  if (release_point(impl_->store, impl_->objects, id, impl_->point(id, i))) *impl_->structure_changed = true;
}

}  // namespace feder
