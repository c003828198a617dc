// The passes of the rigid system. Bodies that take part are listed in `moving` once per step (awake dynamic and
// kinematic ones, ascending); moving[p] has the solver index p + 1, so that all passes run over plain ranges. Free
// rotation of bodies with uneven moments of inertia: spin.cpp; of jointed ones: jointed_body.h.
#include <algorithm>

#include "base/jobs.h"
#include "forces/forces.h"
#include "rigid/impl.h"

namespace feder {
namespace {

Vec3 angular_velocity_of(const Mat3& inv_inertia, const Quat& rotation, const Vec3& momentum) {
  return rotate(rotation, Vec3(inv_inertia * rotate_inverse(rotation, momentum)));
}

Vec3 momentum_of(const Mat3& inertia, const Quat& rotation, const Vec3& angular_velocity) {
  return rotate(rotation, Vec3(inertia * rotate_inverse(rotation, angular_velocity)));
}

bool all_finite(const Vec3& v) { return is_finite(v[0] + v[1] + v[2]); }

}  // namespace

void Rigid::Impl::rebuild_list() {
  if (!list_stale) return;
  list_stale = islands_joined = false;
  joints_stale = true;
  moving.clear();
  for (std::uint32_t i = 0; i < bodies.size(); ++i)
    if (bodies.awake[i]) moving.push_back(i);
}

void Rigid::Impl::refresh(StepContext&) {
  if (!poses_stale) return;
  poses_stale = false;
  rebuild_list();
  for (const std::uint32_t i : moving) place_colliders(i, 0, Vec3::Zero());
}

// Velocity that takes a kinematic body to its target; when it starts to move it wakes what rests on it.
void Rigid::Impl::aim_kinematic(std::uint32_t i, StepContext& c) {
  FEDER_ASSERT(bodies.type[i] == BodyType::kinematic && bodies.has_target[i] <= 2);
  if (bodies.has_target[i] == 1) {
    const Pose& to = bodies.target[i];
    const Vec3 center = to.position + rotate(to.rotation, bodies.local_com[i]);
    bodies.velocity[i] = (center - bodies.position[i]) / c.dt;
    bodies.angular_velocity[i] = rotation_between(bodies.rotation[i], to.rotation) / c.dt;
  } else if (bodies.has_target[i] == 2) {
    // arrived in the last step
    bodies.velocity[i] = bodies.angular_velocity[i] = Vec3::Zero();
    bodies.has_target[i] = 0;
  }
  const std::uint32_t k = bodies.first_collider[i];
  const bool starts = !bodies.velocity[i].isZero(0) || !bodies.angular_velocity[i].isZero(0);
  each_collider(i, [&](std::uint32_t n) { colliders.touched.push_back(n); });
  if (starts && k != kNone && !colliders.awake[k]) wake_touching(i, WakeCause::contact);
}

void Rigid::Impl::update_boxes(StepContext& c) {
  rebuild_list();
  poses_stale = true;
  for (const std::uint32_t i : moving)
    if (bodies.type[i] == BodyType::kinematic) aim_kinematic(i, c);
  rebuild_list();
  each_moving(c, [&](std::uint32_t p) { place_colliders(moving[p], c.dt, c.gravity); });
}

void Rigid::Impl::gather(StepContext& c) {
  last_h = c.h;
  islands_joined = false;
  rebuild_list();  // contacts may have woken bodies
  const std::uint32_t count = static_cast<std::uint32_t>(moving.size());
  solver_bodies.reset(count);
  jointed.clear();
  applied_force.resize(count), applied_torque.resize(count);
  angular_momentum.resize(count), bad.resize(count);
  pushes = c.scratch->take<BodyPush>(count + 1);
  each_moving(c, [&](std::uint32_t p) { gather_body(p), gather_push(p, c); });
  if constexpr (kAsserts) check_gathered();
}

void Rigid::Impl::gather_body(std::uint32_t p) {
  const std::uint32_t i = moving[p];
  FEDER_ASSERT(bodies.awake[i] && bodies.solver_slot[i] < solver_bodies.index.size());
  FEDER_ASSERT(solver_bodies.index[bodies.solver_slot[i]] == 0);  // else listed twice, or a slot of two bodies
  SolverBody& s = solver_bodies.state[p + 1];
  SolverMass& m = solver_bodies.mass[p + 1];
  solver_bodies.index[bodies.solver_slot[i]] = p + 1;
  solver_bodies.indexed[p + 1] = bodies.solver_slot[i];
  s.velocity = bodies.velocity[i];
  s.angular_velocity = bodies.angular_velocity[i];
  s.delta_position = s.delta_rotation = Vec3::Zero();
  s.rotation = m.start_rotation = bodies.rotation[i];
  m.center = bodies.position[i];
  m.inv_mass = bodies.inv_mass[i];
  for (int k = 0; k < 3; ++k) m.inv_mass_axes[k] = bodies.lock[i] & (kLockX << k) ? Real(0) : m.inv_mass;
  m.inv_inertia = bodies.type[i] == BodyType::dynamic ? bodies.world_inv_inertia(i) : Mat3(Mat3::Zero());
  applied_force[p] = bodies.force[i];
  applied_torque[p] = bodies.torque[i];
  bad[p] = 0;
  if (asymmetric[i] && bodies.type[i] == BodyType::dynamic)
    angular_momentum[p] = bodies.angular_velocity[i] == kept_angular_velocity[i]
                              ? kept_momentum[i]
                              : momentum_of(bodies.inertia[i], bodies.rotation[i], bodies.angular_velocity[i]);
}

// Force generators, at the state of this substep: each sees all its points at once.
void Rigid::Impl::add_forces(StepContext& c) {
  const Forces& forces = store.get<Forces>();
  const std::uint32_t count = static_cast<std::uint32_t>(moving.size());
  FEDER_ASSERT(force_count > 0 && applied_force.size() == count);
  for (std::uint32_t p = 0; p < count; ++p) applied_force[p] = bodies.force[moving[p]];
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  const Real share = forces.drag_share() / c.h;
  for (const ForceEntry& f : forces.list) {
    if (!f.enabled || !f.force) continue;
    points.clear();
    point_rank.clear();
    for (std::uint32_t p = 0; p < count; ++p) {
      const std::uint32_t i = moving[p];
      if (bodies.type[i] != BodyType::dynamic || !acts_on(f, bodies.object[i], objects.tags(bodies.object[i])))
        continue;
      const SolverBody& s = solver_bodies.state[p + 1];
      MassPoint point;
      point.position = solver_bodies.mass[p + 1].center + s.delta_position;
      point.velocity = s.velocity;
      point.mass = bodies.mass[i];
      point.area = area[i];
      point.volume = volume[i];
      point.most_drag = share * bodies.mass[i];
      points.push_back(point);
      point_rank.push_back(p);
    }
    point_force.assign(points.size(), Vec3::Zero());
    f.force->add(points.data(), points.size(), time, point_force.data());
    for (std::size_t k = 0; k < points.size(); ++k) applied_force[point_rank[k]] += point_force[k];
  }
}

// Forces and damping (implicit) of a substep; of the rotation, where it is plain: else spin() does it, or a joint.
void Rigid::Impl::gather_push(std::uint32_t p, const StepContext& c) {
  const std::uint32_t i = moving[p];
  BodyPush& push = pushes[p + 1];
  push = {};
  std::fill_n(push.keep.v, kLanes, Real(1));
  if (bodies.type[i] != BodyType::dynamic) return;
  const Vec3 a = acceleration(p, c), turn = solver_bodies.mass[p + 1].inv_inertia * applied_torque[p];
  const Real slow = 1 / (1 + c.h * bodies.linear_damping[i]), brake = 1 / (1 + c.h * bodies.angular_damping[i]);
  for (int k = 0; k < 3; ++k) {
    push.change.v[k] = a[k];
    push.keep.v[k] = bodies.lock[i] & (kLockX << k) ? Real(0) : slow;
    if (asymmetric[i]) continue;
    push.change.v[k + 3] = turn[k];
    push.keep.v[k + 3] = bodies.lock[i] & (kLockRx << k) ? Real(0) : brake;
  }
}

Vec3 Rigid::Impl::acceleration(std::uint32_t p, const StepContext& c) const {
  return c.gravity * bodies.gravity_scale[moving[p]] + applied_force[p] * solver_bodies.mass[p + 1].inv_mass;
}

void Rigid::Impl::integrate_velocities(StepContext& c) {
  const std::uint32_t count = static_cast<std::uint32_t>(moving.size());
  FEDER_ASSERT(last_h == c.h && spin_lane.size() == count && solver_bodies.state.size() > count);
  spin(c);
  if (force_count)
    each_moving(c, [&](std::uint32_t p) {
      const Vec3 a = acceleration(p, c);
      if (bodies.type[moving[p]] == BodyType::dynamic) std::copy_n(a.data(), 3, pushes[p + 1].change.v);
    });
  PushPass pass{reinterpret_cast<Real*>(solver_bodies.state.data()), pushes, 0, 0, c.h};
  const SpinKernels& kernels = spin_kernels(solver->wide());
  constexpr JobGrain kGrain{1024, 3'000};
  c.jobs->for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    PushPass part = pass;
    part.first = first + 1, part.last = last + 1;
    bool finite = kernels.push(part);
    if (!jointed.empty())
      for (std::uint32_t p = first; p < last; ++p) finite &= start_uneven(p, c);
    if (finite) return;
    for (std::uint32_t p = first; p < last; ++p) stop_bad(p);
  });
}

// Free rotation of a jointed body with uneven moments; false: not finite.
bool Rigid::Impl::start_uneven(std::uint32_t p, const StepContext& c) {
  JointedBody* j = uneven_body(p + 1);
  if (!j) return true;
  SolverBody& s = solver_bodies.state[p + 1];
  const Real brake = 1 / (1 + c.h * bodies.angular_damping[moving[p]]);
  const Vec3d l = carried_momentum(*j, s) + (c.h * applied_torque[p]).cast<double>();
  start_jointed(*j, l * static_cast<double>(brake), c.h, s);
  return all_finite(s.angular_velocity);
}

// A non-finite body must not spread through its contacts.
void Rigid::Impl::stop_bad(std::uint32_t p) {
  SolverBody& s = solver_bodies.state[p + 1];
  if (bodies.type[moving[p]] != BodyType::dynamic || (all_finite(s.velocity) && all_finite(s.angular_velocity))) return;
  bad[p] = 1;
  s.velocity = s.angular_velocity = Vec3::Zero();
  stop_spin(p);
}

SolverInput Rigid::Impl::input() {
  FEDER_ASSERT(jointed.empty() || jointed.size() > moving.size());
  return {&contacts,
          &colliders,
          &solver_bodies,
          {joints.data(), joint_count == 0 ? 0 : joints.size()},
          {active_joints.data(), joint_count == 0 ? 0 : active_joints.size()},
          {breakable_joints.data(), joint_count == 0 ? 0 : breakable_joints.size()},
          {jointed.data(), jointed.size()},
          {levels.data(), levels.size()}};
}

void Rigid::Impl::prepare(StepContext& c) {
  if constexpr (kAsserts) check_gathered();
  list_spins(c);
  choose_levels(c);
  solver->prepare(input(), c);
}

void Rigid::Impl::solve(StepContext& c) { solver->solve(input(), c); }

void Rigid::Impl::finish_solve(StepContext& c) {
  solver->finish(input(), c);
  check_loads(c);
  const std::uint64_t capped = solver->capped();
  if (capped == 0 || cap_warned) return;
  cap_warned = true;  // once; the residual rigid.capped goes on counting
  events.warn("iteration_limit", "the rigid solver reached its iteration limit " + std::to_string(capped) +
                                     " times in a step: contacts or joints are left unresolved");
}

bool Rigid::Impl::commit_finite(std::uint32_t p) const {
  const SolverBody& s = solver_bodies.state[p + 1];
  const Quat& q = s.rotation;
  return !bad[p] && all_finite(s.velocity) && all_finite(s.angular_velocity) &&
         all_finite(bodies.position[moving[p]] + s.delta_position) && is_finite(q.x + q.y + q.z + q.w);
}

void Rigid::Impl::commit_body(std::uint32_t p) {
  const std::uint32_t i = moving[p];
  const SolverBody& s = solver_bodies.state[p + 1];
  if (force_count) applied_force[p] = bodies.force[i];  // without generators, for the watchdog
  bodies.force[i] = bodies.torque[i] = Vec3::Zero();
  if (bodies.type[i] == BodyType::kinematic) {
    if (bodies.has_target[i] == 1) {
      bodies.rotation[i] = bodies.target[i].rotation;
      bodies.position[i] = bodies.target[i].position + rotate(bodies.rotation[i], bodies.local_com[i]);
      bodies.has_target[i] = 2;
    } else {
      bodies.position[i] += s.delta_position;
      bodies.rotation[i] = s.rotation;
    }
    return;
  }
  // dynamic
  bad[p] = !commit_finite(p);
  if (bad[p]) return;
  bodies.position[i] += s.delta_position;
  bodies.rotation[i] = s.rotation;
  bodies.velocity[i] = s.velocity;
  bodies.angular_velocity[i] = s.angular_velocity;
  // angular momentum, and the velocity that it gives now
  if (!asymmetric[i]) return;
  Vec3& l = kept_momentum[i];
  spin_invariant[i] = kUnknownSpin;
  if (const JointedBody* j = uneven_body(p + 1))
    l = carried_momentum(*j, s).cast<Real>();
  else
    l = spin_momentum(p);
  bodies.angular_velocity[i] = kept_angular_velocity[i] = angular_velocity_of(bodies.inv_inertia[i], s.rotation, l);
  bad[p] = !all_finite(bodies.angular_velocity[i]);
}

// Quarantine: a non-finite body becomes fixed at its last finite pose.
void Rigid::Impl::quarantine(std::uint32_t i) {
  FEDER_ASSERT(bodies.type[i] == BodyType::dynamic);
  suspect(i);
  events.warn("non_finite",
              objects.describe(bodies.object[i]) + " got a velocity or position that is not finite; it is fixed now",
              bodies.object[i]);
  bodies.velocity[i] = bodies.angular_velocity[i] = Vec3::Zero();
  set_type(i, BodyType::fixed);
}

void Rigid::Impl::commit(StepContext& c) {
  const std::uint32_t count = static_cast<std::uint32_t>(moving.size());
  FEDER_ASSERT(bad.size() == count && applied_torque.size() == count);
  moved.resize(count);
  for (std::uint32_t p = 0; p < count; ++p) moved[p] = bodies.object[moving[p]];
  each_moving(c, [&](std::uint32_t p) { commit_body(p); });
  for (std::uint32_t p = 0; p < count; ++p)
    if (bad[p]) quarantine(moving[p]);
  if (joint_count) break_joints(c);
  rebuild_list();
  update_sleep(c);
  now = c.step + 1;
}

}  // namespace feder
