// Joint rows in the soft-step loop. Rows are written anew in every substep (their Jacobians turn with the bodies);
// each block solves K x = J v + bias by LDL^T, where K = J M^-1 J^T, and takes the softened step (Catto, GDC 2011).
// A row of a spring keeps its softness in the relax pass; a stiff one loses its bias there. Bounded rows stand alone
// and clamp the accumulated impulse. Kept between steps: the impulses, in SolverJoint. Weak spot: a long chain under a
// heavy end converges along the chain only, so sweeps change direction.
#include "rigid/soft_joints.h"

namespace feder {

SoftFactors soft_factors(Real hertz, Real damping_ratio, Real h) {
  if (!(hertz > 0)) return {0, 1, 0};
  const Real omega = 2 * kPi * hertz;
  const Real a1 = 2 * damping_ratio + h * omega;
  const Real a2 = h * omega * a1;
  const Real a3 = 1 / (1 + a2);
  return {omega / a1, a2 * a3, a3};
}

void SoftJoints::prepare_row(const Row& row, const MoverMass& a, const MoverMass& b, Real h, ReadyRow& out) const {
  out.linear = row.linear;
  out.angular_a = row.angular_a;
  out.angular_b = row.angular_b;
  out.push_a = a.inv_inertia * row.angular_a;
  out.push_b = b.inv_inertia * row.angular_b;
  out.lower = row.lower * h;
  out.upper = row.upper * h;
  out.bias = out.relaxed_bias = -row.speed;
  out.mass_scale = out.relaxed_mass_scale = 1;
  out.impulse_scale = out.relaxed_impulse_scale = 0;
  if (row.velocity_only) return;
  // a limit that is not reached: the gap may close in this substep, not more
  const bool open = (row.lower >= 0 && row.value > 0) || (row.upper <= 0 && row.value < 0);
  if (open) {
    out.bias = out.relaxed_bias = row.value / h - row.speed;
    return;
  }
  const bool spring = row.hertz > 0;
  const SoftFactors soft = spring ? soft_factors(row.hertz, row.damping_ratio, h)
                                  : soft_factors(stiff_hertz_, damping_ratio_, h);
  out.bias = soft.bias_rate * row.value - row.speed;
  out.mass_scale = soft.mass_scale;
  out.impulse_scale = soft.impulse_scale;
  if (!spring) return;
  out.relaxed_bias = out.bias;
  out.relaxed_mass_scale = soft.mass_scale;
  out.relaxed_impulse_scale = soft.impulse_scale;
}

void SoftJoints::prepare_block(const RowBlock& block, const MoverMass& a, const MoverMass& b, ReadyBlock& out) const {
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

void SoftJoints::apply(const RowBlock& block, const Real* impulse, const SolverInput& in, Real* change) const {
  MoverState& sa = in.movers->state[block.mover_a];
  MoverState& sb = in.movers->state[block.mover_b];
  Vec3 push = Vec3::Zero(), turn_a = Vec3::Zero(), turn_b = Vec3::Zero();
  for (int i = 0; i < block.count; ++i) {
    const ReadyRow& r = ready_[block.first + static_cast<std::uint32_t>(i)];
    push += r.linear * impulse[i];
    turn_a += r.push_a * impulse[i];
    turn_b += r.push_b * impulse[i];
  }
  if (block.mover_a) {
    const Vec3 v = in.movers->mass[block.mover_a].inv_mass_axes.cwiseProduct(push);
    sa.velocity -= v;
    sa.angular_velocity += turn_a;
    Real* d = change + 6 * std::size_t(block.mover_a);
    for (int k = 0; k < 3; ++k) d[k] -= v[k], d[3 + k] += turn_a[k];
  }
  if (block.mover_b) {
    const Vec3 v = in.movers->mass[block.mover_b].inv_mass_axes.cwiseProduct(push);
    sb.velocity += v;
    sb.angular_velocity += turn_b;
    Real* d = change + 6 * std::size_t(block.mover_b);
    for (int k = 0; k < 3; ++k) d[k] += v[k], d[3 + k] += turn_b[k];
  }
}

void SoftJoints::start(const SolverInput& in, const StepContext& c, Real* change) {
  clear();
  RowWriter writer(rows_, blocks_);
  const Movers& movers = *in.movers;
  for (std::uint32_t j = 0; j < in.joints.size(); ++j) {
    SolverJoint& joint = in.joints[j];
    if (!joint.active) continue;
    JointInput input;
    input.joint = &joint.shape;
    input.mover_a = joint.mover_a == kNone ? 0 : movers.solver[joint.mover_a];
    input.mover_b = joint.mover_b == kNone ? 0 : movers.solver[joint.mover_b];
    input.a = {movers.mass[input.mover_a].center + movers.state[input.mover_a].moved, movers.state[input.mover_a].rotation};
    input.b = {movers.mass[input.mover_b].center + movers.state[input.mover_b].moved, movers.state[input.mover_b].rotation};
    writer.start(input, j);
    joint.kind->fill(input, writer);
    joint.rows = static_cast<std::uint8_t>(writer.rows_written());
  }
  ready_.resize(rows_.size());
  prepared_.resize(blocks_.size());
  const Real quarter = Real(0.25) / c.h;
  stiff_hertz_ = hertz_ < quarter ? hertz_ : quarter;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const RowBlock& block = blocks_[i];
    const MoverMass& a = movers.mass[block.mover_a];
    const MoverMass& b = movers.mass[block.mover_b];
    for (std::uint32_t k = block.first; k < block.first + block.count; ++k) prepare_row(rows_[k], a, b, c.h, ready_[k]);
    prepare_block(block, a, b, prepared_[i]);
  }
  for (const RowBlock& block : blocks_) apply(block, in.joints[block.joint].impulse + block.first_impulse, in, change);
}

void SoftJoints::solve_block(std::size_t index, const SolverInput& in, bool biased, Real* change) {
  const RowBlock& block = blocks_[index];
  const ReadyRow* rows = &ready_[block.first];
  const ReadyBlock& ready = prepared_[index];
  const MoverState& a = in.movers->state[block.mover_a];
  const MoverState& b = in.movers->state[block.mover_b];
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
  Real* impulse = in.joints[block.joint].impulse + block.first_impulse;
  for (int i = 0; i < n; ++i) {
    const ReadyRow& r = rows[i];
    const Real mass_scale = biased ? r.mass_scale : r.relaxed_mass_scale;
    const Real impulse_scale = biased ? r.impulse_scale : r.relaxed_impulse_scale;
    const Real now = clamp(impulse[i] - mass_scale * x[i] - impulse_scale * impulse[i], r.lower, r.upper);
    step[i] = now - impulse[i];
    impulse[i] = now;
  }
  apply(block, step, in, change);
}

void SoftJoints::solve(const SolverInput& in, bool biased, Real* change) {
  if (biased) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) solve_block(i, in, true, change);
  } else {
    for (std::size_t i = blocks_.size(); i-- > 0;) solve_block(i, in, false, change);
  }
}

}  // namespace feder
