// Joint rows in the soft-step loop. Joints whose kind promises plain point rows are solved eight at a time
// (wide_joints.h) where no tree takes them and their bodies are even; the rest here. Rows are filled anew in every
// substep (their Jacobians rotate with the bodies); each block solves K x = J v + bias by LDL^T, where K = J M^-1 J^T,
// and takes the softened step (Catto, "Soft Constraints", GDC 2011). Spring rows keep their softness in the relax pass;
// stiff rows lose their bias there. Bounded rows stand alone and clamp the accumulated impulse. Stiff joints that form
// a tree are solved together (joint_trees.h); loops are swept in alternating direction. Kept between steps: the
// impulses, in SolverJoint. Weak spot: loops with high mass ratios.
#include "rigid/soft_joints.h"

#include <algorithm>
#include <cmath>

#include "constrain/joint.h"
#include "feder/error.h"
#include "rigid/joint_load.h"
#include "state/rows.h"
#include "state/solver_bodies.h"

namespace feder {
namespace {

constexpr JobGrain kStrainGrain{1024, 8'000};  // bodies per job
constexpr Real kRadian = Real(0.3);            // m, that an error of one radian counts as
constexpr Real kMostTurn = Real(0.03);         // rad, in a substep, by a correction of positions
constexpr int kBoundedTurns = 4;               // limits that others have made act come in the next
constexpr Real kStrain = 2;    // (h omega)^2 up to which a body keeps its inertia; above 4 the substep is unstable
constexpr Real kSmooth = 300;  // likewise, up to which its rotation goes on as it is: more is a snap

}  // namespace

SoftFactors soft_factors(Real hertz, Real damping_ratio, Real h) {
  FEDER_ASSERT(h > 0);
  if (!(hertz > 0)) return {0, 1, 0};
  const Real omega = 2 * kPi * hertz;
  const Real a1 = 2 * damping_ratio + h * omega;
  const Real a2 = h * omega * a1;
  const Real a3 = 1 / (1 + a2);
  return {omega / a1, a2 * a3, a3};
}

bool SoftJoints::is_direct(std::size_t block) const { return !trees_.empty() && trees_.direct(block); }

// Geometric stiffness: tension in a joint is a spring against rotation. About an axis with inertia I, forces p/h at
// arms r (of length q across that axis) oscillate with omega^2 = sum p q^2 / (r h I) at most, and h omega > 2 is
// unstable. Near that limit joints (not contacts) use a larger inertia (Andrews et al., "Geometric Stiffness for
// Real-time Constrained Multibody Dynamics", 2017).
void SoftJoints::stabilize(const SolverInput& in, Real h) {
  FEDER_ASSERT(strain_.size() == in.solver_bodies->state.size());
  for (const RowBlock& block : blocks_) {
    FEDER_ASSERT(block.index_a < strain_.size() && block.index_b < strain_.size());
    const SolverJoint& joint = in.joints[block.joint];
    Vec3 pull = Vec3::Zero();
    for (std::uint32_t k = 0; k < block.count; ++k)
      pull += rows_[block.first + k].linear * joint.impulse[block.first_impulse + k];
    const Real size = h * length(pull);
    const Vec3 &arm_a = joint.shape.frame_a.position, &arm_b = joint.shape.frame_b.position;
    strain_[block.index_a] += size * length(arm_a);
    strain_[block.index_b] += size * length(arm_b);
    if (!uneven_) continue;
    add_strain(in, block.index_a, arm_a, size);
    add_strain(in, block.index_b, arm_b, size);
  }
}

void SoftJoints::add_strain(const SolverInput& in, std::uint32_t index, const Vec3& arm, Real pull) {
  const JointedBody* uneven = in.uneven(index);
  const Real size = length(arm);
  if (!uneven || !(size > 0)) return;
  const Vec3d local = rotate_inverse(uneven->principal, arm).cast<double>();
  strain_axes_[index] += static_cast<double>(pull / size) * (Vec3d::Constant(local.squaredNorm()) - local.cwiseAbs2());
}

// Inverse inertias for the joints of this substep. The strain is used up: it is summed for the next one.
void SoftJoints::update_inertias(const SolverInput& in, StepContext& c) {
  FEDER_ASSERT(strain_.size() == in.solver_bodies->mass.size() && norm_.size() == strain_.size());
  const auto count = static_cast<std::uint32_t>(bodies_.size());
  std::uint8_t* strained = c.scratch->take<std::uint8_t>(count / kStrainGrain.items + 1);
  c.jobs->for_blocks(count, kStrainGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    bool any = false;
    for (std::uint32_t n = first; n < last; ++n) any |= update_inertia(in, bodies_[n]);
    strained[first / kStrainGrain.items] = any;
  });
  const bool before = strained_;
  strained_ = false;
  for (std::uint32_t i = 0; i < count; i += kStrainGrain.items) strained_ |= strained[i / kStrainGrain.items] != 0;
  inertia_changed_ = before || strained_;
}

// Returns whether joints use a larger inertia. The bend of a body's anchors is quadratic in the rotation that it had
// before the impulses of the substep, and they do work along it: in a snap, where light links turn fast and the tension
// ends that, a load on a chain would gain many times the energy of its fall.
bool SoftJoints::update_inertia(const SolverInput& in, std::uint32_t i) {
  const Real ratio = strain_[i] * norm_[i];  // (h omega)^2, at most
  strain_[i] = 0;
  share_[i] = ratio > kStrain ? kStrain / ratio : Real(1);
  bool strained = share_[i] != 1;
  if (!narrow_.empty()) inv_inertia_[i] = share_[i] * in.solver_bodies->mass[i].inv_inertia;
  JointedBody* uneven = in.uneven(i);
  smooth_[i] = ratio > kSmooth ? kSmooth / ratio : Real(1);
  if (!uneven) return strained;
  const Vec3d ratios = strain_axes_[i].cwiseProduct(uneven->inv_moments);
  const double highest = ratios.maxCoeff();
  smooth_[i] = highest > kSmooth ? static_cast<Real>(kSmooth / highest) : Real(1);
  for (int k = 0; k < 3; ++k) {
    uneven->share[k] = kStrain / std::max<double>(ratios[k], kStrain);
    strained |= uneven->share[k] != 1;
  }
  strain_axes_[i] = Vec3d::Zero();
  return strained;
}

// Marks the bodies that joints connect to a body in contact. There Row::bend is not predicted: a contact's last impulse
// rotates a body as its joints do not allow, and the bend is quadratic in that rotation.
void SoftJoints::find_in_contact(const SolverInput& in) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  in_contact_.assign(solver_bodies.state.size(), 0);
  if (in.contacts->active.empty()) return;
  groups_.reset(solver_bodies.state.size());
  for (const std::uint32_t j : in.active_joints) {
    const SolverJoint& joint = in.joints[j];
    if (joint.slot_a == kNone || joint.slot_b == kNone) continue;
    const std::uint32_t a = solver_bodies.index[joint.slot_a], b = solver_bodies.index[joint.slot_b];
    if (solver_bodies.mass[a].inv_mass > 0 && solver_bodies.mass[b].inv_mass > 0) groups_.join(a, b);
  }
  const auto mark = [&](std::uint32_t collider) {
    const std::uint32_t index = in.solver_index(collider);
    FEDER_ASSERT(index < in_contact_.size());
    if (index != 0) in_contact_[groups_.root(index)] = 1;
  };
  for (const ColliderPair& pair : in.contacts->active_pairs) mark(pair.a), mark(pair.b);
  for (std::uint32_t i = 0; i < in_contact_.size(); ++i) in_contact_[i] = in_contact_[groups_.root(i)];
}

void SoftJoints::load_motions(const SolverInput& in, Real h) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  FEDER_ASSERT(in_contact_.size() == solver_bodies.state.size());  // found in the first substep
  motions_.resize(solver_bodies.state.size());
  motions_[0] = BodyMotion{};
  for (const std::uint32_t i : bodies_) {
    const SolverBody& s = solver_bodies.state[i];
    const JointedBody* uneven = in.uneven(i);
    const Vec3& mean = uneven ? uneven->mean_angular_velocity : s.angular_velocity;
    motions_[i] = {s.velocity, s.angular_velocity, Mat3::Zero()};
    if (!in_contact_[i]) motions_[i].bend = bend_matrix(s.angular_velocity, mean, h);
  }
}

Real SoftJoints::prepare_row(const Row& row, Real h, ReadyRow& out) const {
  FEDER_ASSERT(row.lower <= row.upper && !(row.hertz < 0));
  out.linear = row.linear;
  out.angular_a = row.angular_a;
  out.angular_b = row.angular_b;
  out.lower = row.lower * h;
  out.upper = row.upper * h;
  out.bias = out.relaxed_bias = -row.speed;
  out.mass_scale = out.relaxed_mass_scale = 1;
  out.impulse_scale = out.relaxed_impulse_scale = 0;
  if (row.velocity_only) return 0;
  // a limit that is not active: the gap may close in this substep, not more
  const bool open = (row.lower >= 0 && row.value > 0) || (row.upper <= 0 && row.value < 0);
  if (open) {
    out.bias = out.relaxed_bias = row.value / h - row.speed;
    return 0;
  }
  const bool spring = row.hertz > 0;
  const SoftFactors soft = spring ? soft_factors(row.hertz, row.damping_ratio, h) : stiff_factors_;
  const Real closing = soft.bias_rate * row.value;
  out.bias = closing - row.speed;
  if (!spring) out.bias += row.bend, out.relaxed_bias += row.bend;
  out.mass_scale = soft.mass_scale;
  out.impulse_scale = soft.impulse_scale;
  if (!spring) return closing;
  out.relaxed_bias = out.bias;
  out.relaxed_mass_scale = soft.mass_scale;
  out.relaxed_impulse_scale = soft.impulse_scale;
  return 0;
}

// Bounds the bias: an open joint closes at push_speed at most, as overlap does. Jacobians that rotate under a biased
// impulse leave part of its energy in the bodies, in proportion to the square of the gap. Warm-start impulses are
// scaled likewise: joints of a loop pull against each other, and impulses that balanced do not after a rotation. (Trees
// are corrected by pseudo-velocities, which add no energy.)
void SoftJoints::bound_bias(const RowBlock& block, Real* impulse) {
  Real squares[2] = {0, 0};  // of linear and angular rows
  FEDER_ASSERT(push_speed_ >= 0 && block.first + block.count <= ready_.size());
  const auto is_angular = [](const ReadyRow& r) { return r.linear.isZero(0); };
  for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
    const Real wanted = ready_[k].bias - ready_[k].relaxed_bias;
    squares[is_angular(ready_[k])] += wanted * wanted;
  }
  const Real angular_push_speed = push_speed_ / kRadian;
  if (squares[0] <= push_speed_ * push_speed_ && squares[1] <= angular_push_speed * angular_push_speed) return;
  const Real share[2] = {std::min(push_speed_ / std::sqrt(squares[0]), Real(1)),
                         std::min(angular_push_speed / std::sqrt(squares[1]), Real(1))};
  for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
    ReadyRow& r = ready_[k];
    r.bias = r.relaxed_bias + share[is_angular(r)] * (r.bias - r.relaxed_bias);
    impulse[k - block.first] *= std::min(share[0], share[1]);
  }
}

// Velocity changes by unit impulses.
void SoftJoints::respond(const RowBlock& block, const SolverInput& in) {
  const JointedBody *a = in.uneven(block.index_a), *b = in.uneven(block.index_b);
  for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
    ReadyRow& r = ready_[k];
    r.push_a = a ? jointed_response(*a, r.angular_a) : Vec3(inv_inertia_[block.index_a] * r.angular_a);
    r.push_b = b ? jointed_response(*b, r.angular_b) : Vec3(inv_inertia_[block.index_b] * r.angular_b);
  }
}

// Scale of what each row of a tree would feel alone, once per step. Even bodies have the same moment about all axes.
void SoftJoints::measure_compliance(const RowBlock& block, const SolverInput& in) {
  const Vec3 inv_mass =
      in.solver_bodies->mass[block.index_a].inv_mass_axes + in.solver_bodies->mass[block.index_b].inv_mass_axes;
  const auto angular = [&](std::uint32_t i, const Vec3& v) {
    const JointedBody* uneven = in.uneven(i);
    return uneven ? dot(jointed_response(*uneven, v), v) : norm_[i] * dot(v, v);
  };
  for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
    const Row& r = rows_[k];
    compliance_[k] = dot(inv_mass.cwiseProduct(r.linear), r.linear) + angular(block.index_a, r.angular_a) +
                     angular(block.index_b, r.angular_b);
  }
}

// Warm start of a block of a tree, which has no responses by row.
void SoftJoints::start_direct(const RowBlock& block, const SolverInput& in) const {
  const Real* impulse = in.joints[block.joint].impulse + block.first_impulse;
  if (uneven_) return apply_uneven(block, impulse, in);
  Vec3 push = Vec3::Zero(), moment_a = Vec3::Zero(), moment_b = Vec3::Zero();
  for (std::uint32_t k = 0; k < block.count; ++k) {
    const Row& r = rows_[block.first + k];
    push += r.linear * impulse[k];
    moment_a += r.angular_a * impulse[k], moment_b += r.angular_b * impulse[k];
  }
  const auto side = [&](std::uint32_t i, const Vec3& linear, const Vec3& moment) {
    if (!i) return;
    SolverBody& s = in.solver_bodies->state[i];
    s.velocity += in.solver_bodies->mass[i].inv_mass_axes.cwiseProduct(linear);
    s.angular_velocity += inv_inertia_[i] * moment;
  };
  side(block.index_a, -push, moment_a);
  side(block.index_b, push, moment_b);
}

void SoftJoints::prepare_block(const RowBlock& block, const SolverMass& a, const SolverMass& b, ReadyBlock& out) const {
  FEDER_ASSERT(block.count >= 1 && block.count <= 6);
  const ReadyRow* r = &ready_[block.first];
  const Vec3 inv_mass = a.inv_mass_axes + b.inv_mass_axes;
  // LDL^T, row by row; a vanishing pivot (locked axis, repeated row) takes no part
  Real trace = 0;
  int at = 0;
  for (int i = 0; i < block.count; ++i) {
    const Vec3 weighted = inv_mass.cwiseProduct(r[i].linear);
    Real* l = out.factor + at;
    for (int j = 0; j < i; ++j)
      l[j] = dot(weighted, r[j].linear) + dot(r[i].push_a, r[j].angular_a) + dot(r[i].push_b, r[j].angular_b);
    Real pivot = dot(weighted, r[i].linear) + dot(r[i].push_a, r[i].angular_a) + dot(r[i].push_b, r[i].angular_b);
    const Real diagonal = pivot;
    trace = diagonal > trace ? diagonal : trace;
    int row_at = 0;
    for (int j = 0; j < i; ++j) {
      // l[j] holds K_ij - sum_k l_ik d_k l_jk until it is divided
      for (int k = 0; k < j; ++k) l[j] -= l[k] * out.factor[row_at + k];
      row_at += j;
    }
    for (int j = 0; j < i; ++j) {
      const Real unscaled = l[j];
      l[j] *= out.inv_pivot[j];
      pivot -= unscaled * l[j];
    }
    out.inv_pivot[i] = pivot > diagonal * Real(1e-5) ? 1 / pivot : 0;
    at += i;
  }
}

void SoftJoints::apply(const RowBlock& block, const Real* impulse, const SolverInput& in) const {
  FEDER_ASSERT(block.index_a != block.index_b);
  Vec3 push = Vec3::Zero(), angular_velocity_a = Vec3::Zero(), angular_velocity_b = Vec3::Zero();
  for (std::uint32_t k = 0; k < block.count; ++k) {
    const ReadyRow& r = ready_[block.first + k];
    push += r.linear * impulse[k];
    angular_velocity_a += r.push_a * impulse[k];
    angular_velocity_b += r.push_b * impulse[k];
  }
  const auto side = [&](std::uint32_t i, Real sign, const Vec3& angular_velocity) {
    if (!i) return;
    SolverBody& s = in.solver_bodies->state[i];
    s.velocity += sign * in.solver_bodies->mass[i].inv_mass_axes.cwiseProduct(push);
    s.angular_velocity += angular_velocity;
  };
  side(block.index_a, -1, angular_velocity_a);
  side(block.index_b, 1, angular_velocity_b);
}

// The same where there are jointed bodies with uneven moments.
void SoftJoints::apply_uneven(const RowBlock& block, const Real* impulse, const SolverInput& in) const {
  const auto side = [&](std::uint32_t i, Real sign, Vec3 ReadyRow::*angular) {
    if (!i) return;
    Vec3 push = Vec3::Zero();
    for (std::uint32_t k = 0; k < block.count; ++k) push += ready_[block.first + k].linear * (sign * impulse[k]);
    SolverBody& s = in.solver_bodies->state[i];
    s.velocity += in.solver_bodies->mass[i].inv_mass_axes.cwiseProduct(push);
    if (JointedBody* uneven = in.uneven(i)) {
      Vec3d moment = Vec3d::Zero();
      for (std::uint32_t k = 0; k < block.count; ++k)
        moment += (ready_[block.first + k].*angular).cast<double>() * static_cast<double>(impulse[k]);
      push_jointed(*uneven, moment, s, drifted_ && contacts_ && uneven->slender);
      return;
    }
    Vec3 moment = Vec3::Zero();
    for (std::uint32_t k = 0; k < block.count; ++k) moment += ready_[block.first + k].*angular * impulse[k];
    s.angular_velocity += inv_inertia_[i] * moment;
  };
  side(block.index_a, -1, &ReadyRow::angular_a);
  side(block.index_b, 1, &ReadyRow::angular_b);
}

// Rows of the joints in narrow_; without bends when h is 0.
void SoftJoints::fill_rows(const SolverInput& in, Real h) {
  rows_slack_.clear(rows_), blocks_slack_.clear(blocks_);
  RowWriter writer(rows_, blocks_);
  for (const std::uint32_t j : narrow_) {
    SolverJoint& joint = in.joints[j];
    JointInput input = in.joint_input(joint);
    if (h > 0) input.motion_a = &motions_[input.index_a], input.motion_b = &motions_[input.index_b];
    input.h = h;
    writer.start(input, j);
    joint.kind->fill(input, writer);
    joint.rows = static_cast<std::uint8_t>(writer.rows_written());
  }
}

void SoftJoints::prepare_rows(const RowBlock& block, Real h) {
  Real fastest = 0;
  const Real smooth = std::min(smooth_[block.index_a], smooth_[block.index_b]);
  for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
    rows_[k].bend *= smooth;
    fastest = std::max(fastest, std::abs(prepare_row(rows_[k], h, ready_[k])));
  }
  if (fastest > push_speed_) torn_.push_back(static_cast<std::uint32_t>(&block - blocks_.data()));
}

void SoftJoints::clear() {
  rows_.clear(), blocks_.clear(), keys_.clear(), key_count_ = 0, bodies_.clear(), narrow_.clear(), slides_.clear();
  bounded_.clear(), with_tree_.clear();
  trees_.clear(), wide_.clear();
}

void SoftJoints::prepare(const SolverInput& in, StepContext& c, bool contacts) {
  FEDER_ASSERT(!in.active_joints.empty());
  uneven_ = !in.jointed.empty();
  contacts_ = contacts;
  slides_.clear();
  if (structure_changed(in, c)) find_structure(in, c);
  find_in_contact(in);
  for (const std::uint32_t i : bodies_) {
    norm_[i] = in.solver_bodies->mass[i].inv_inertia.cwiseAbs().rowwise().sum().maxCoeff();
    strain_[i] = 0;
  }
  inv_inertia_[0] = in.solver_bodies->mass[0].inv_inertia;
  wide_.load(in, c, {in_contact_.data(), in_contact_.size()}, {strain_.data(), strain_.size()});
}

// Rows of a substep at the poses now, their effective masses and warm start.
void SoftJoints::start(const SolverInput& in, StepContext& c) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  drifted_ = false;
  slides_.assign(uneven_ ? solver_bodies.state.size() : 0, BodySlide{});
  if (!narrow_.empty()) load_motions(in, c.h);
  fill_rows(in, c.h);
  FEDER_ASSERT(!use_trees_ || trees_.knows(blocks_.size()));
  ready_.resize(rows_.size());
  compliance_.resize(rows_.size());
  prepared_.resize(blocks_.size());
  const Real quarter = Real(0.25) / c.h;
  stiff_factors_ = soft_factors(hertz_ < quarter ? hertz_ : quarter, damping_ratio_, c.h);
  stabilize(in, c.h);
  update_inertias(in, c);
  // effective masses of what trees do not solve
  torn_.clear();
  torn_.reserve(blocks_.size());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const RowBlock& block = blocks_[i];
    prepare_rows(block, c.h);
    if (is_direct(i)) {
      if (c.substep == 0) measure_compliance(block, in);
      start_direct(block, in);
      continue;
    }
    respond(block, in);
    prepare_block(block, solver_bodies.mass[block.index_a], solver_bodies.mass[block.index_b], prepared_[i]);
  }
  if (!trees_.empty()) trees_.factor({rows_, compliance_}, in, inv_inertia_, c.substep == 0 || inertia_changed_);
  for (const std::uint32_t i : torn_)
    if (!is_direct(i)) bound_bias(blocks_[i], in.joints[blocks_[i].joint].impulse + blocks_[i].first_impulse);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Real* impulse = in.joints[blocks_[i].joint].impulse + blocks_[i].first_impulse;
    if (!is_direct(i)) push(blocks_[i], impulse, in);
  }
}

JointPass SoftJoints::pass(const SolverInput& in, const StepContext& c) {
  JointPass p{};
  p.bodies = reinterpret_cast<Real*>(in.solver_bodies->state.data());
  p.share = share_.data(), p.strain = strain_.data();
  p.h = c.h;
  p.push_speed = push_speed_;
  p.soft = stiff_factors_;
  return p;
}

void SoftJoints::solve_block(std::size_t index, const SolverInput& in, bool biased) {
  const RowBlock& block = blocks_[index];
  const ReadyRow* rows = &ready_[block.first];
  const ReadyBlock& ready = prepared_[index];
  const SolverBody& a = in.solver_bodies->state[block.index_a];
  const SolverBody& b = in.solver_bodies->state[block.index_b];
  const Vec3 v = b.velocity - a.velocity;
  const int n = block.count;
  Real x[6], step[6];
  // L D L^T x = J v + bias
  int at = 0;
  for (int i = 0; i < n; ++i) {
    const ReadyRow& r = rows[i];
    x[i] = dot(r.linear, v) + dot(r.angular_b, b.angular_velocity) + dot(r.angular_a, a.angular_velocity) +
           (biased ? r.bias : r.relaxed_bias);
    for (int k = 0; k < i; ++k) x[i] -= ready.factor[at + k] * x[k];
    at += i;
  }
  for (int i = 0; i < n; ++i) x[i] *= ready.inv_pivot[i];
  for (int i = n - 1; i >= 0; --i) {
    at -= i;
    for (int k = 0; k < i; ++k) x[k] -= ready.factor[at + k] * x[i];
  }
  // softened and clamped step
  Real* impulse = in.joints[block.joint].impulse + block.first_impulse;
  for (int i = 0; i < n; ++i) {
    const ReadyRow& r = rows[i];
    const Real mass_scale = biased ? r.mass_scale : r.relaxed_mass_scale;
    const Real impulse_scale = biased ? r.impulse_scale : r.relaxed_impulse_scale;
    const Real now = clamp(impulse[i] - mass_scale * x[i] - impulse_scale * impulse[i], r.lower, r.upper);
    step[i] = now - impulse[i];
    impulse[i] = now;
  }
  push(block, step, in);
}

// Position correction of trees by pseudo-velocities, which are no part of the momentum: what a biased impulse does in
// one pose the relax pass, in another pose, would not undo.
void SoftJoints::slide_trees(const SolverInput& in, Real h) {
  FEDER_ASSERT(slides_.size() == in.solver_bodies->state.size());
  for (std::size_t i = 0; i < rows_.size(); ++i) bias_[i] = ready_[i].bias - ready_[i].relaxed_bias;
  trees_.solve(rows_, nullptr, bias_, step_);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!trees_.direct(i)) continue;
    const RowBlock& block = blocks_[i];
    Vec3 push = Vec3::Zero(), moment_a = Vec3::Zero(), moment_b = Vec3::Zero();
    for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
      push += step_[k] * rows_[k].linear;
      moment_a += step_[k] * rows_[k].angular_a, moment_b += step_[k] * rows_[k].angular_b;
    }
    const auto side = [&](std::uint32_t index, const Vec3& linear, const Vec3& moment) {
      if (!index) return;
      const JointedBody* uneven = in.uneven(index);
      slides_[index].velocity += in.solver_bodies->mass[index].inv_mass_axes.cwiseProduct(linear);
      slides_[index].angular_velocity +=
          uneven ? jointed_response(*uneven, moment) : Vec3(inv_inertia_[index] * moment);
    };
    side(block.index_a, -push, moment_a);
    side(block.index_b, push, moment_b);
  }
  bound_slides(h);
}

// A correction that straightens what is buckled turns the light links of a taut chain, the farther the straighter they
// are: beyond the straight line, from where the next one turns them back. So the fastest body of a tree turns by
// kMostTurn, and all of the tree in proportion.
void SoftJoints::bound_slides(Real h) {
  const Real limit = kMostTurn / h;
  fastest_.assign(slides_.size(), 0);
  for (const std::uint32_t i : bodies_) {
    Real& fastest = fastest_[trees_.root(i)];
    fastest = std::max(fastest, length(slides_[i].angular_velocity));
  }
  for (const std::uint32_t i : bodies_) {
    const Real fastest = fastest_[trees_.root(i)];
    if (fastest <= limit) continue;
    slides_[i].velocity *= limit / fastest, slides_[i].angular_velocity *= limit / fastest;
  }
}

void SoftJoints::solve_trees(const SolverInput& in, bool biased) {
  for (std::size_t i = 0; i < rows_.size(); ++i) bias_[i] = biased ? ready_[i].bias : ready_[i].relaxed_bias;
  trees_.solve(rows_, in.solver_bodies, bias_, step_);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!trees_.direct(i)) continue;
    const RowBlock& block = blocks_[i];
    FEDER_ASSERT(block.first_impulse + block.count <= in.joints[block.joint].rows);
    Real* impulse = in.joints[block.joint].impulse + block.first_impulse;
    for (std::uint32_t k = 0; k < block.count; ++k) impulse[k] += step_[block.first + k];
    if (uneven_) apply_uneven(block, &step_[block.first], in);
  }
  if (!uneven_) trees_.move_bodies(*in.solver_bodies);
}

void SoftJoints::solve_rows(const SolverInput& in, Real h, bool biased) {
  FEDER_ASSERT(ready_.size() == rows_.size() && prepared_.size() == blocks_.size());
  if (!trees_.empty()) {
    bias_.resize(rows_.size());
    step_.resize(rows_.size());
    if (biased && uneven_) slide_trees(in, h);
    solve_trees(in, biased && !uneven_);
    for (int turn = 0; turn < kBoundedTurns && solve_bounded(in, biased); ++turn) solve_trees(in, biased && !uneven_);
  }
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const std::size_t at = biased ? i : blocks_.size() - 1 - i;
    if (!is_direct(at) && !with_tree_[at]) solve_block(at, in, biased);
  }
}

// Wide joints are the first of the one pass and the last of the other.
void SoftJoints::solve(const SolverInput& in, StepContext& c) {
  start(in, c);
  if (!wide_.empty()) wide_.solve(pass(in, c), c);
  solve_rows(in, c.h, true);
}

void SoftJoints::project(const SolverInput& in, StepContext& c) {
  solve_rows(in, c.h, false);
  if (!wide_.empty()) wide_.relax(pass(in, c), c);
}

void SoftJoints::relax(const SolverInput& in, StepContext& c) {
  drifted_ = true;
  solve_rows(in, c.h, false);
  if (!wide_.empty()) wide_.relax(pass(in, c), c);
  if (!in.breakable_joints.empty()) note_loads(in, c.h);
}

void SoftJoints::note_loads(const SolverInput& in, Real h) const {
  wide_.note_loads(in, h);
  for (std::size_t i = 0; i < blocks_.size();) {
    const std::size_t first = i;
    while (i < blocks_.size() && blocks_[i].joint == blocks_[first].joint) ++i;
    SolverJoint& joint = in.joints[blocks_[first].joint];
    if (joint.breakable) note_force(joint, rows_, {&blocks_[first], i - first}, h);
  }
}

}  // namespace feder
