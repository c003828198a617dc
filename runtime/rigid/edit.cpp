// Edits of bodies and joints by scripts, between steps: arguments are checked, sleeping bodies woken, contacts removed
// where they are no longer valid. And the getters.
#include <cmath>

#include "rigid/impl.h"

namespace feder {
namespace {

void check(const Vec3& v, const char* what) {
  if (!is_finite(v)) throw SceneError(std::string(what) + ": expected three finite numbers");
}

void check_not_negative(Real x, const char* what) {
  if (!(x >= 0) || !is_finite(x))
    throw SceneError(std::string(what) + ": expected a number not below 0, got " + std::to_string(x));
}

}  // namespace

ObjectId Rigid::add_body(const BodyDesc& desc) {
  const Command command(impl_->commands, "rigid.add_body", desc);
  return impl_->add(desc);
}
void Rigid::destroy_body(ObjectId body, const std::string& where) {
  const Command command(impl_->commands, "rigid.destroy_body", body, where);
  impl_->remove(impl_->index(body), where);
}
const Bodies& Rigid::bodies() const { return impl_->bodies; }
std::span<const ObjectId> Rigid::moved() const { return {impl_->moved.data(), impl_->moved.size()}; }
std::uint32_t Rigid::index(ObjectId body) const { return impl_->index(body); }
Pose Rigid::pose(ObjectId body) const { return impl_->bodies.origin_pose(impl_->index(body)); }
void Rigid::set_pose(ObjectId body, const Pose& origin) {
  const Command command(impl_->commands, "rigid.set_pose", body, origin);
  impl_->set_pose(impl_->index(body), origin);
}

Vec3 Rigid::velocity(ObjectId body) const { return impl_->bodies.velocity[impl_->index(body)]; }
Vec3 Rigid::angular_velocity(ObjectId body) const { return impl_->bodies.angular_velocity[impl_->index(body)]; }
BodyType Rigid::type(ObjectId body) const { return impl_->bodies.type[impl_->index(body)]; }
bool Rigid::asleep(ObjectId body) const {
  const std::uint32_t i = impl_->index(body);
  return impl_->bodies.type[i] != BodyType::fixed && !impl_->bodies.awake[i];
}

// Wakes a body, and what is in contact with it.
void Rigid::Impl::wake_around(std::uint32_t i) {
  wake(i, WakeCause::script, {});
  wake_touching(i, WakeCause::script);
}

// One of the velocities of a body that is not fixed: 0 along locked axes, the first of which has the bit `lock`.
void Rigid::Impl::set_rate(std::uint32_t i, Array<Vec3>& rate, const Vec3& value, int lock) {
  if (bodies.type[i] == BodyType::fixed) return;
  wake(i, WakeCause::script, {});
  bodies.has_target[i] = 0;
  for (int k = 0; k < 3; ++k) rate[i][k] = bodies.lock[i] & (lock << k) ? Real(0) : value[k];
}

void Rigid::set_velocity(ObjectId body, const Vec3& v) {
  const Command command(impl_->commands, "rigid.set_velocity", body, v);
  const std::uint32_t i = impl_->index(body);
  check(v, "set_velocity");
  impl_->set_rate(i, impl_->bodies.velocity, v, kLockX);
}

void Rigid::set_angular_velocity(ObjectId body, const Vec3& w) {
  const Command command(impl_->commands, "rigid.set_angular_velocity", body, w);
  const std::uint32_t i = impl_->index(body);
  check(w, "set_angular_velocity");
  impl_->set_rate(i, impl_->bodies.angular_velocity, w, kLockRx);
}

void Rigid::apply_force(ObjectId body, const Vec3& force, const Vec3* world_point) {
  const Command command(impl_->commands, "rigid.apply_force", body, force, world_point);
  const std::uint32_t i = impl_->index(body);
  check(force, "apply_force");
  if (world_point) check(*world_point, "apply_force (point)");
  impl_->wake(i, WakeCause::force, {});
  impl_->bodies.force[i] += force;
  if (world_point) impl_->bodies.torque[i] += cross(*world_point - impl_->bodies.position[i], force);
}

void Rigid::apply_torque(ObjectId body, const Vec3& torque) {
  const Command command(impl_->commands, "rigid.apply_torque", body, torque);
  const std::uint32_t i = impl_->index(body);
  check(torque, "apply_torque");
  impl_->wake(i, WakeCause::force, {});
  impl_->bodies.torque[i] += torque;
}

void Rigid::apply_impulse(ObjectId body, const Vec3& impulse, const Vec3* world_point) {
  const Command command(impl_->commands, "rigid.apply_impulse", body, impulse, world_point);
  const std::uint32_t i = impl_->index(body);
  check(impulse, "apply_impulse");
  if (world_point) check(*world_point, "apply_impulse (point)");
  Bodies& b = impl_->bodies;
  if (b.type[i] != BodyType::dynamic) return;
  impl_->wake(i, WakeCause::force, {});
  for (int k = 0; k < 3; ++k)
    if (!(b.lock[i] & (kLockX << k))) b.velocity[i][k] += impulse[k] * b.inv_mass[i];
  if (world_point) b.angular_velocity[i] += b.world_inv_inertia(i) * cross(*world_point - b.position[i], impulse);
}

void Rigid::apply_angular_impulse(ObjectId body, const Vec3& impulse) {
  const Command command(impl_->commands, "rigid.apply_angular_impulse", body, impulse);
  const std::uint32_t i = impl_->index(body);
  check(impulse, "apply_angular_impulse");
  if (impl_->bodies.type[i] != BodyType::dynamic) return;
  impl_->wake(i, WakeCause::force, {});
  impl_->bodies.angular_velocity[i] += impl_->bodies.world_inv_inertia(i) * impulse;
}

void Rigid::move_to(ObjectId body, const Pose& origin) {
  const Command command(impl_->commands, "rigid.move_to", body, origin);
  const std::uint32_t i = impl_->index(body);
  check(origin.position, "move_to");
  check(origin.rotation.vec(), "move_to (rotation)");
  if (!is_finite(origin.rotation.w)) throw SceneError("move_to (rotation): expected four finite numbers");
  if (impl_->bodies.type[i] != BodyType::kinematic) throw SceneError("move_to: expected a kinematic body");
  if (impl_->bodies.target.size() <= i) impl_->bodies.target.resize(impl_->bodies.size());
  impl_->bodies.target[i] = {origin.position, normalized(origin.rotation)};
  impl_->bodies.has_target[i] = 1;
}

void Rigid::set_type(ObjectId body, BodyType type) {
  const Command command(impl_->commands, "rigid.set_type", body, type);
  impl_->set_type(impl_->index(body), type);
}

void Rigid::set_filter(ObjectId body, std::uint32_t group, std::uint32_t mask) {
  const Command command(impl_->commands, "rigid.set_filter", body, group, mask);
  const std::uint32_t i = impl_->index(body);
  impl_->wake_around(i);
  impl_->changed(i);
  impl_->each_collider(i, [&](std::uint32_t k) { impl_->colliders.group[k] = group, impl_->colliders.mask[k] = mask; });
}

void Rigid::set_friction(ObjectId body, Real fixed, Real dynamic) {
  const Command command(impl_->commands, "rigid.set_friction", body, fixed, dynamic);
  const std::uint32_t i = impl_->index(body);
  check_not_negative(fixed, "set_friction");
  check_not_negative(dynamic, "set_friction");
  impl_->wake_around(i);
  impl_->each_collider_without(kStatesStatic, i, [&](std::uint32_t k) {
    impl_->colliders.friction_static[k] = fixed;
    impl_->colliders.changed.push_back(k);
  });
  impl_->each_collider_without(kStatesDynamic, i, [&](std::uint32_t k) {
    impl_->colliders.friction_dynamic[k] = dynamic;
    impl_->colliders.changed.push_back(k);
  });
}

void Rigid::set_restitution(ObjectId body, Real e) {
  const Command command(impl_->commands, "rigid.set_restitution", body, e);
  const std::uint32_t i = impl_->index(body);
  if (!(e >= 0 && e <= 1)) throw SceneError("set_restitution: expected a number from 0 to 1, got " + std::to_string(e));
  impl_->each_collider_without(kStatesRestitution, i, [&](std::uint32_t k) {
    impl_->colliders.restitution[k] = e;
    impl_->colliders.changed.push_back(k);
  });
}

void Rigid::set_surface_velocity(ObjectId body, const Vec3& v) {
  const Command command(impl_->commands, "rigid.set_surface_velocity", body, v);
  const std::uint32_t i = impl_->index(body);
  check(v, "set_surface_velocity");
  impl_->wake_around(i);
  impl_->each_collider_without(kStatesVelocity, i, [&](std::uint32_t k) {
    impl_->colliders.surface_velocity[k] = v;
    impl_->colliders.touched.push_back(k);
  });
}

void Rigid::set_damping(ObjectId body, Real linear, Real angular) {
  const Command command(impl_->commands, "rigid.set_damping", body, linear, angular);
  const std::uint32_t i = impl_->index(body);
  check_not_negative(linear, "set_damping");
  check_not_negative(angular, "set_damping");
  impl_->bodies.linear_damping[i] = linear;
  impl_->bodies.angular_damping[i] = angular;
}

void Rigid::set_gravity_scale(ObjectId body, Real scale) {
  const Command command(impl_->commands, "rigid.set_gravity_scale", body, scale);
  const std::uint32_t i = impl_->index(body);
  if (!is_finite(scale)) throw SceneError("set_gravity_scale: expected a finite number");
  impl_->wake(i, WakeCause::script, {});
  impl_->bodies.gravity_scale[i] = scale;
}

void Rigid::set_sensor(ObjectId body, bool sensor, bool senses_fixed) {
  const Command command(impl_->commands, "rigid.set_sensor", body, sensor, senses_fixed);
  const std::uint32_t i = impl_->index(body);
  impl_->wake_touching(i, WakeCause::script);
  impl_->changed(i);
  impl_->each_collider(i, [&](std::uint32_t k) { impl_->colliders.sensor[k] = sensing(sensor, senses_fixed); });
}

void Rigid::wake(ObjectId body, WakeCause cause, ObjectId other) {
  const Command command(impl_->commands, "rigid.wake", body, cause, other);
  impl_->wake(impl_->index(body), cause, other);
}
void Rigid::sleep(ObjectId body) {
  const Command command(impl_->commands, "rigid.sleep", body);
  impl_->put_to_sleep(impl_->index(body));
}

void Rigid::wake_all(WakeCause cause) {
  const Command command(impl_->commands, "rigid.wake_all", cause);
  for (std::uint32_t i = 0; impl_->sleeping_count > 0 && i < impl_->bodies.size(); ++i)
    if (!impl_->bodies.awake[i]) impl_->wake(i, cause, {});
}

Real Rigid::mass(ObjectId body) const { return impl_->bodies.mass[impl_->index(body)]; }
Mat3 Rigid::inertia(ObjectId body) const { return impl_->bodies.inertia[impl_->index(body)]; }
Vec3 Rigid::center_of_mass(ObjectId body) const { return impl_->bodies.position[impl_->index(body)]; }

ObjectId Rigid::add_joint(const JointDesc& desc) {
  const Command command(impl_->commands, "rigid.add_joint", desc);
  return impl_->add_joint(desc);
}
void Rigid::destroy_joint(ObjectId joint, const std::string& where) {
  const Command command(impl_->commands, "rigid.destroy_joint", joint, where);
  impl_->remove_joint(impl_->joint_index(joint), where, WakeCause::joint);
}

Vec3 Rigid::joint_force(ObjectId joint) const {
  Vec3 force, torque;
  impl_->joint_load(impl_->joint_index(joint), force, torque);
  return force;
}

Vec3 Rigid::joint_torque(ObjectId joint) const {
  Vec3 force, torque;
  impl_->joint_load(impl_->joint_index(joint), force, torque);
  return torque;
}

Real Rigid::joint_coordinate(ObjectId joint) const {
  const std::uint32_t j = impl_->joint_index(joint);
  const SolverJoint& s = impl_->joints[j];
  return s.kind->coordinate ? s.kind->coordinate(impl_->joint_input(j)) : Real(0);
}

void Rigid::set_motor(ObjectId joint, Real speed, Real max_force) {
  const Command command(impl_->commands, "rigid.set_motor", joint, speed, max_force);
  const std::uint32_t j = impl_->joint_index(joint);
  SolverJoint& s = impl_->joints[j];
  if (!(s.kind->uses & kUsesMotor)) throw SceneError(std::string("set_motor: a ") + s.kind->name + " has no motor");
  if (!is_finite(speed) || !(max_force >= 0))
    throw SceneError("set_motor: expected a finite speed and a force not below 0");
  JointOptions& o = s.shape.options;
  if (!o.has_motor)  // more rows than before: no warm start
    for (Real& impulse : s.impulse) impulse = 0;
  o.motor_speed = speed, o.motor_max = max_force, o.has_motor = true;
  impl_->wake_joined(impl_->records[j], WakeCause::joint);
}

void Rigid::set_limits(ObjectId joint, Real lower, Real upper) {
  const Command command(impl_->commands, "rigid.set_limits", joint, lower, upper);
  const std::uint32_t j = impl_->joint_index(joint);
  SolverJoint& s = impl_->joints[j];
  if (!(s.kind->uses & kUsesLimits)) throw SceneError(std::string("set_limits: a ") + s.kind->name + " has no limits");
  if (!(lower <= upper)) throw SceneError("set_limits: expected a lower number not above the upper one");
  JointOptions& o = s.shape.options;
  for (Real& impulse : s.impulse) impulse = 0;
  o.lower = lower, o.upper = upper, o.has_limits = true;
  const JointRecord& r = impl_->records[j];
  impl_->edited(r.body_a), impl_->edited(r.body_b);
  impl_->wake_joined(r, WakeCause::joint);
}

Real Rigid::max_joint_error() const {
  Real error = 0;
  double elastic = 0;
  impl_->joint_totals(error, elastic);
  return error;
}

std::size_t Rigid::joint_count() const { return impl_->joint_count; }

Rigid::JointInfo Rigid::joint_info(ObjectId joint) const {
  const std::uint32_t j = impl_->joint_index(joint);
  const JointInput in = impl_->joint_input(j);
  const Pose a = in.a * in.joint->frame_a, b = in.b * in.joint->frame_b;
  return {impl_->joints[j].kind,
          impl_->records[j].a,
          impl_->records[j].b,
          a.position,
          b.position,
          rotate(a.rotation, vec3(1, 0, 0))};
}

}  // namespace feder
