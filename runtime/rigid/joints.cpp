// Joints of the rigid system: making (frames from world anchors, options checked against the kind), removing, load and
// breaking, residuals. An immovable side is given to the solver as the world.
#include <algorithm>
#include <cmath>

#include "base/cast.h"
#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kRatioPerSubstep = 150;  // mass ratio that one substep can solve along a short loop, by experiment

void refuse(bool given, unsigned uses, unsigned bit, const JointKind& kind, const char* option) {
  if (given && !(uses & bit))
    throw SceneError(std::string("joint: a ") + kind.name + " has no use for '" + option + "'");
}

void check_options(const JointDesc& d, const JointKind& kind) {
  const JointOptions& o = d.options;
  refuse(o.has_limits, kind.uses, kUsesLimits, kind, "limits");
  refuse(o.has_motor, kind.uses, kUsesMotor, kind, "motor");
  refuse(o.spring_hertz > 0, kind.uses, kUsesSpring, kind, "spring");
  refuse(o.rest_length >= 0, kind.uses, kUsesTwoAnchors, kind, "rest_length");
  const auto good = [](bool ok, const char* what) {
    if (!ok) throw SceneError(std::string("joint.") + what);
  };
  good(is_finite(d.anchor_a) && is_finite(d.anchor_b), "anchor: expected three finite numbers");
  good(is_finite(d.axis) && length(d.axis) > Real(1e-6), "axis: expected three finite numbers, not all zero");
  good(!std::isnan(o.lower) && !std::isnan(o.upper) && (!o.has_limits || o.lower <= o.upper),
       "limits: expected a lower number not above the upper one");
  good(is_finite(o.motor_speed) && o.motor_max >= 0, "motor: expected a finite speed and a largest force not below 0");
  good(o.spring_hertz >= 0 && is_finite(o.spring_hertz) && o.spring_damping >= 0 && is_finite(o.spring_damping),
       "spring: expected hertz and damping_ratio not below 0");
  good(!std::isnan(o.rest_length) && o.rest_length < kInfinity, "rest_length: expected a finite number");
  good(d.break_force > 0, "break_force: expected a number above 0");
}

}  // namespace

std::uint32_t Rigid::Impl::joint_index(ObjectId joint) const {
  const std::uint32_t j = objects.index(joint, kJointKind);
  FEDER_ASSERT(j < records.size() && records[j].object == joint);
  return j;
}

ObjectId Rigid::Impl::add_joint(const JointDesc& d) {
  const std::span<const JointKind> kinds = joint_kinds();
  const JointKind& kind = find_variant(kinds, d.type, "joint type");
  check_options(d, kind);
  if (!d.a && !d.b) throw SceneError("joint: expected at least one body");
  if (d.a == d.b) throw SceneError("joint: expected two different bodies");
  const std::uint32_t a = d.a ? index(d.a) : kNone, b = d.b ? index(d.b) : kNone;
  const Vec3 axis = d.axis / length(d.axis);
  const Quat rotation = rotation_from_to(Vec3(1, 0, 0), axis);
  const Pose com_a = a == kNone ? Pose{} : bodies.com_pose(a), com_b = b == kNone ? Pose{} : bodies.com_pose(b);
  const Vec3& anchor_b = kind.uses & kUsesTwoAnchors ? d.anchor_b : d.anchor_a;
  // frames, both at the anchors with the x axis along the joint's
  JointRecord r;
  r.a = d.a, r.b = d.b;
  r.body_a = a, r.body_b = b;
  r.kind = static_cast<std::uint32_t>(&kind - kinds.data());
  r.local_a = {to_local(com_a, d.anchor_a), conjugate(com_a.rotation) * rotation};
  r.local_b = {to_local(com_b, anchor_b), conjugate(com_b.rotation) * rotation};
  r.break_force = d.break_force;
  r.alive = 1;
  r.collide = d.collide;
  const std::uint32_t j = take_index(free_joints, records.size(), [&] {
    records.emplace_back();
    joints.emplace_back();
  });
  FEDER_ASSERT(j < records.size() && !records[j].alive);
  // from here on nothing fails
  records[j] = r;
  joints[j] = SolverJoint{};
  joints[j].kind = &kind;
  joints[j].shape.options = d.options;
  if (d.options.rest_length < 0 && (kind.uses & kUsesTwoAnchors))
    joints[j].shape.options.rest_length = length(Vec3(anchor_b - d.anchor_a));
  refresh_joint(j);
  records[j].object = objects.add(kJointKind, j, d.name, d.tags);
  if (!d.collide && d.a && d.b) {
    collide.exclude(d.a, d.b);
    changed(a), changed(b);
  }
  wake_joined(records[j], WakeCause::joint);
  if (d.options.has_limits) edited(a), edited(b);
  joints_stale = true;
  if (joint_count++ == 0) *structure_changed = true;
  return records[j].object;
}

void Rigid::Impl::remove_joint(std::uint32_t j, const std::string& where, WakeCause cause) {
  FEDER_ASSERT(j < records.size() && records[j].alive && joint_count > 0);
  JointRecord& r = records[j];
  if (!r.collide && r.a && r.b) collide.include(r.a, r.b);
  wake_joined(r, cause);
  objects.remove(r.object, where);
  r = JointRecord{};
  joints[j] = SolverJoint{};
  free_joints.push_back(j);
  joints_stale = true;
  islands_joined = false;
  if (--joint_count == 0) *structure_changed = true;
}

void Rigid::Impl::wake_joined(const JointRecord& r, WakeCause cause) {
  if (r.body_a != kNone) wake(r.body_a, cause, r.b);
  if (r.body_b != kNone) wake(r.body_b, cause, r.a);
}

// Solver slots and frames for the solver, from the bodies' types and (fixed) poses.
void Rigid::Impl::refresh_joint(std::uint32_t j) {
  const JointRecord& r = records[j];
  SolverJoint& s = joints[j];
  FEDER_ASSERT(is_unit(r.local_a.rotation) && is_unit(r.local_b.rotation));
  const auto side = [&](std::uint32_t body, const Pose& local, std::uint32_t& slot, Pose& frame) {
    const bool world = body == kNone || bodies.type[body] == BodyType::fixed;
    slot = world ? kNone : bodies.solver_slot[body];
    frame = body != kNone && world ? bodies.com_pose(body) * local : local;
  };
  side(r.body_a, r.local_a, s.slot_a, s.shape.frame_a);
  side(r.body_b, r.local_b, s.slot_b, s.shape.frame_b);
}

void Rigid::Impl::refresh_joints_of(std::uint32_t body) {
  for (std::uint32_t j = 0; j < records.size(); ++j)
    if (records[j].alive && (records[j].body_a == body || records[j].body_b == body)) refresh_joint(j);
}

void Rigid::Impl::list_active_joints(StepContext& c) {
  if (!joints_stale) return;
  joints_stale = false;
  active_joints.clear(), breakable_joints.clear(), joined_bodies.clear();
  active_joints.reserve(records.size()), breakable_joints.reserve(records.size());
  std::uint8_t* joined = c.scratch->take<std::uint8_t>(bodies.size());
  std::fill_n(joined, bodies.size(), std::uint8_t(0));
  for (std::uint32_t j = 0; j < records.size(); ++j) {
    const JointRecord& r = records[j];
    joints[j].active = r.alive && (bodies.moves(r.body_a) || bodies.moves(r.body_b));
    if (!joints[j].active) continue;
    active_joints.push_back(j);
    joints[j].breakable = r.break_force < kInfinity;
    if (joints[j].breakable) breakable_joints.push_back(j);
    for (const std::uint32_t i : {r.body_a, r.body_b})
      if (i != kNone) joined[i] = 1;
  }
  check_mass_ratios(c);
  for (std::uint32_t i = 0; i < bodies.size(); ++i)
    if (joined[i]) joined_bodies.push_back(i);
}

void Rigid::Impl::activate_joints(StepContext& c) {
  FEDER_ASSERT(joints.size() == records.size() && jointed.empty());
  list_active_joints(c);
  if constexpr (kAsserts) check_active_joints();
  for (const std::uint32_t i : joined_bodies) load_inertia(i);
  for (const std::uint32_t j : breakable_joints) joints[j].peak_force = 0;
}

// Principal moments of an uneven body: its inertia for joints rotates with it.
void Rigid::Impl::load_inertia(std::uint32_t body) {
  if (!asymmetric[body] || bodies.type[body] != BodyType::dynamic) return;
  const std::uint32_t index = solver_bodies.index[bodies.solver_slot[body]];
  if (index == 0) return;  // asleep beside an awake one: it does not move
  if (jointed.empty()) jointed.assign(solver_bodies.state.size(), JointedBody{});
  FEDER_ASSERT(index < jointed.size() && moving[index - 1] == body);
  JointedBody& to = jointed[index];
  if (to.uneven) return;
  to.given_angular_velocity = solver_bodies.state[index].angular_velocity;
  to.momentum = angular_momentum[index - 1].cast<double>();
  to.uneven = true;
  to.inv_moments = inv_moments[body].cast<double>();
  to.principal = principal[body];
  to.contact_rotation = solver_bodies.state[index].rotation;
  to.axes = to.free_axes = jointed_axes(to, solver_bodies.state[index].rotation);
  to.slender = slender_inv_moments(to.inv_moments) != to.inv_moments;
  if (!to.slender) return;
  solver_bodies.mass[index].inv_inertia = seen_inv_inertia(to, to.contact_rotation).cast<Real>();
}

// Trees are solved exactly, loops from joint to joint.
void Rigid::Impl::check_mass_ratios(StepContext& c) {
  const auto unchecked = [&](std::uint32_t j) { return !records[j].mass_checked; };
  if (std::none_of(active_joints.begin(), active_joints.end(), unchecked)) return;
  std::uint8_t* loops = c.scratch->take<std::uint8_t>(bodies.size());  // by root
  const auto each_pair = [&](auto&& f) {
    for (const std::uint32_t j : active_joints) {
      const std::uint32_t a = records[j].body_a, b = records[j].body_b;
      if (a != kNone && b != kNone && bodies.inv_mass[a] > 0 && bodies.inv_mass[b] > 0) f(j, a, b);
    }
  };
  each_pair([&](std::uint32_t, std::uint32_t a, std::uint32_t b) {
    islands.isolate(a), islands.isolate(b);
    loops[a] = loops[b] = 0;
  });
  each_pair([&](std::uint32_t, std::uint32_t a, std::uint32_t b) {
    a = islands.root(a), b = islands.root(b);
    const bool loop = a == b || loops[a] || loops[b];
    loops[islands.join(a, b)] = loop;
  });
  const Real tree = solver->tree_ratio();
  each_pair([&](std::uint32_t j, std::uint32_t a, std::uint32_t b) {
    const Real per_substep = loops[islands.root(a)] ? kRatioPerSubstep : std::max(tree, kRatioPerSubstep);
    if (!records[j].mass_checked) check_mass_ratio(j, bodies.inv_mass[a] / bodies.inv_mass[b], per_substep, c);
  });
  for (const std::uint32_t j : active_joints) records[j].mass_checked = 1;
}

void Rigid::Impl::check_mass_ratio(std::uint32_t j, Real ratio, Real per_substep, StepContext& c) {
  ratio = std::max(ratio, 1 / ratio);
  if (ratio <= per_substep * static_cast<Real>(c.substeps)) return;
  const long long enough = whole_count(std::ceil(ratio / per_substep));
  const ObjectId joint = records[j].object;
  events.warn("mass_ratio",
              objects.describe(joint) + " joins masses of ratio " + std::to_string(whole_count(ratio)) + "; " +
                  std::to_string(c.substeps) + " substeps will stretch it, " + std::to_string(enough) +
                  " would hold it",
              joint);
}

JointInput Rigid::Impl::joint_input(std::uint32_t j) const {
  const JointRecord& r = records[j];
  const SolverJoint& s = joints[j];
  JointInput in;
  in.joint = &s.shape;
  in.index_a = s.slot_a == kNone ? 0 : 1;
  in.index_b = s.slot_b == kNone ? 0 : 2;
  in.a = s.slot_a == kNone ? Pose{} : bodies.com_pose(r.body_a);
  in.b = s.slot_b == kNone ? Pose{} : bodies.com_pose(r.body_b);
  return in;
}

// The rows of joint j for the poses of `in`, into `rows` and `blocks`.
void Rigid::Impl::fill_rows(std::uint32_t j, const JointInput& in) const {
  rows.clear();
  blocks.clear();
  RowWriter writer(rows, blocks);
  writer.start(in, j);
  joints[j].kind->fill(in, writer);
}

// J M^-1 J^T of one side of a row, 1/kg or 1/(kg m^2); 0 where nothing can move.
Real Rigid::Impl::row_compliance(std::uint32_t body, const Vec3& linear, const Vec3& angular) const {
  if (body == kNone || bodies.type[body] != BodyType::dynamic) return 0;
  return bodies.inv_mass[body] * dot(linear, linear) + dot(angular, Vec3(bodies.world_inv_inertia(body) * angular));
}

// Load: force and torque on b at its anchor, from the impulses of the last substep.
void Rigid::Impl::joint_load(std::uint32_t j, Vec3& force, Vec3& torque) const {
  const SolverJoint& s = joints[j];
  const JointInput in = joint_input(j);
  fill_rows(j, in);
  FEDER_ASSERT(last_h > 0);
  force = torque = Vec3::Zero();
  for (const RowBlock& block : blocks) {
    for (std::uint32_t k = 0; k < block.count; ++k) {
      const Row& row = rows[block.first + k];
      const Real size = s.impulse[block.first_impulse + k] / last_h;
      force += row.linear * size;
      torque += row.angular_b * size;
    }
  }
  torque -= cross(to_world(in.b, s.shape.frame_b.position) - in.b.position, force);
}

void Rigid::Impl::break_joints(StepContext&) {
  for (const std::uint32_t j : breakable_joints) {
    const JointRecord& r = records[j];
    if (!joints[j].active) continue;
    FEDER_ASSERT(r.alive);  // else a removed joint would break again
    const Real size = joints[j].peak_force;
    if (!(size > r.break_force)) continue;
    Event e;
    e.kind = kJointBreak;
    e.a = r.object;
    e.force = size;
    events.add(e);
    remove_joint(j, "break", WakeCause::joint);
  }
}

// Largest violation of a stiff equality (m; rad rows count as metres), and the elastic energy of springs with
// k = m_eff omega^2.
void Rigid::Impl::joint_totals(Real& max_error, double& elastic) const {
  max_error = 0;
  elastic = 0;
  for (std::uint32_t j = 0; j < records.size(); ++j) {
    if (!records[j].alive) continue;
    fill_rows(j, joint_input(j));
    Real squares = 0;
    for (const Row& row : rows) {
      if (row.velocity_only) continue;
      const bool equality = row.lower == -kInfinity && row.upper == kInfinity;
      if (row.hertz > 0) {
        const Real k = row_compliance(records[j].body_a, row.linear, row.angular_a) +
                       row_compliance(records[j].body_b, row.linear, row.angular_b);
        const double omega = 2 * static_cast<double>(kPi * row.hertz), value = static_cast<double>(row.value);
        if (k > 0) elastic += 0.5 * omega * omega / static_cast<double>(k) * value * value;
      } else if (equality) {
        squares += row.value * row.value;
      }
    }
    const Real error = std::sqrt(squares);
    max_error = error > max_error ? error : max_error;
  }
}

}  // namespace feder
