// One block of joint rows of the impulse solver: velocities by a direct solve of the block, J M^-1 J^T = L D L^T;
// soft rows as implicit spring and damper (Catto, "Soft Constraints", GDC 2011): with k = omega^2 / w and
// c = 2 zeta omega / w for the row's response w, gamma = 1 / (h (c + h k)) and the wanted speed is
// -h k / (c + h k) C / h. The drift that a substep of straight motion adds to the error of a stiff row is removed along
// the rows of its start, in position and velocity alike (SHAKE: Ryckaert, Ciccotti, Berendsen 1977), which conserves
// angular momentum and, over long times, energy. Older errors are corrected in position alone. Rows that depend on
// others (planar worlds, locked axes) get no impulse.
#include <algorithm>

#include "rigid/impulse_parts.h"

namespace feder {
namespace {

constexpr Real kMaxCorrection = Real(0.3);  // rad or m per correction: rows are linear for small motions only

Real row_speed(const Row& r, const SolverBody& a, const SolverBody& b) {
  return dot(r.linear, b.velocity - a.velocity) + dot(r.angular_a, a.angular_velocity) +
         dot(r.angular_b, b.angular_velocity);
}

// w_ij = J_i M^-1 J_j^T.
Real response(const BlockRows& r, int row, int column, const ImpulseScene& s) {
  const Row &i = r.rows[row], &j = r.rows[column];
  const std::uint32_t a = r.a, b = r.b;
  Real w = 0;
  if (s.body[a].movable)
    w += dot(i.linear, s.mass[a].inv_mass_axes.cwiseProduct(j.linear)) +
         dot(i.angular_a, joint_response(s.body[a], j.angular_a));
  if (s.body[b].movable)
    w += dot(i.linear, s.mass[b].inv_mass_axes.cwiseProduct(j.linear)) +
         dot(i.angular_b, joint_response(s.body[b], j.angular_b));
  return w;
}

// L D L^T of the matrix in the lower half of `m`.
void factor(Real m[6][6], int count, Real* inv_d) {
  FEDER_ASSERT(count >= 1 && count <= 6);
  Real d[6];
  for (int j = 0; j < count; ++j) {
    const Real size = m[j][j];
    d[j] = size;
    for (int k = 0; k < j; ++k) d[j] -= m[j][k] * m[j][k] * d[k];
    const bool independent = d[j] > 32 * kEpsilon * size;
    if (!independent) d[j] = 0;
    inv_d[j] = independent ? 1 / d[j] : 0;
    for (int i = j + 1; i < count; ++i) {
      Real sum = m[i][j];
      for (int k = 0; k < j; ++k) sum -= m[i][k] * m[j][k] * d[k];
      m[i][j] = sum * inv_d[j];
    }
  }
}

void solve(const Real m[6][6], const Real* inv_d, int count, Real* x) {
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < i; ++k) x[i] -= m[i][k] * x[k];
  for (int i = 0; i < count; ++i) x[i] *= inv_d[i];
  for (int i = count; i-- > 0;)
    for (int k = i + 1; k < count; ++k) x[i] -= m[k][i] * x[k];
}

bool is_bounded(const Row& r) { return r.lower > -kInfinity || r.upper < kInfinity; }

// Speed that row i lacks to its target.
Real missing_speed(const BlockRows& r, const ImpulseBlock& block, const Real* impulse, const ImpulseScene& s, int i) {
  return block.target[i] - row_speed(r.rows[i], s.state[r.a], s.state[r.b]) - block.gamma[i] * impulse[i];
}

// Change of the block's impulses that solves it for the velocities now.
void wanted_change(const BlockRows& r, const ImpulseBlock& block, const Real* impulse, const ImpulseScene& s,
                   Real* change) {
  for (int i = 0; i < r.count; ++i) change[i] = missing_speed(r, block, impulse, s, i);
  solve(block.factor, block.inv_d, r.count, change);
  for (int i = 0; i < r.count; ++i) {
    const Row& row = r.rows[i];
    if (!is_bounded(row)) continue;
    FEDER_ASSERT(row.lower <= row.upper);
    const Real sum = clamp(impulse[i] + change[i], row.lower * s.h, row.upper * s.h);
    change[i] = sum - impulse[i];
  }
}

// Rows that position correction acts on: stiff equalities, and limits that are exceeded.
bool has_position(const Row& r) { return !r.velocity_only && r.hertz <= 0 && (!is_bounded(r) || r.value < 0); }

// Drift: what a substep's motion added to the error of a stiff row, or to the excess of a limit.
Real drift(const Row& start, const Row& now) {
  if (now.velocity_only || now.hertz > 0) return 0;
  if (!is_bounded(now)) return now.value - start.value;
  return std::min(std::min(now.value, Real(0)) - std::min(start.value, Real(0)), Real(0));
}

// Impulse (or position correction) of a block: the rows' Jacobians times `size`, on both bodies.
template <auto Push, class Moment>
void push_block(const BlockRows& r, const Real* size, const ImpulseScene& s) {
  using Scalar = typename Moment::Scalar;
  Vec3 linear = Vec3::Zero();
  Moment moment_a = Moment::Zero(), moment_b = Moment::Zero();
  for (int i = 0; i < r.count; ++i) {
    const Row& row = r.rows[i];
    linear += size[i] * row.linear;
    moment_a += static_cast<Scalar>(size[i]) * row.angular_a.cast<Scalar>();
    moment_b += static_cast<Scalar>(size[i]) * row.angular_b.cast<Scalar>();
  }
  Push(s, r.a, -linear, moment_a);
  Push(s, r.b, linear, moment_b);
}

}  // namespace

void factor_block(const BlockRows& block, const ImpulseScene& s, ImpulseBlock& out) {
  for (int i = 0; i < block.count; ++i)
    for (int j = 0; j <= i; ++j) out.factor[i][j] = response(block, i, j, s);
  for (int i = 0; i < block.count; ++i) {
    const Row& r = block.rows[i];
    const Real w = out.factor[i][i];
    out.gamma[i] = 0;
    out.target[i] = r.speed;
    if (r.velocity_only || !(w > 0)) continue;
    if (r.hertz > 0) {
      const Real omega = 2 * kPi * r.hertz, stiffness = omega * omega / w, damping = 2 * r.damping_ratio * omega / w;
      out.gamma[i] = 1 / (s.h * (damping + s.h * stiffness));
      out.target[i] -= stiffness / (damping + s.h * stiffness) * r.value;
      out.factor[i][i] += out.gamma[i];
    } else if (is_bounded(r)) {
      out.target[i] -= std::max(r.value, Real(0)) / s.h;  // the gap that is left may close
    }
  }
  factor(out.factor, block.count, out.inv_d);
}

void apply_block(const BlockRows& r, const Real* impulse, const ImpulseScene& s) {
  push_block<&push_joint, Vec3d>(r, impulse, s);
}

void push_back_block(const BlockRows& r, const Real* impulse, const ImpulseScene& s) {
  push_block<&push_back, Vec3d>(r, impulse, s);
}

Real block_speed_error(const BlockRows& r, const ImpulseBlock& block, const Real* impulse, const ImpulseScene& s) {
  const SolverBody &a = s.state[r.a], &b = s.state[r.b];
  Real worst = 0, change[6];
  wanted_change(r, block, impulse, s, change);
  for (int i = 0; i < r.count; ++i) {
    if (block.inv_d[i] == 0) continue;
    const Row& row = r.rows[i];
    // change of the row's speed if it were alone
    const Real error =
        is_bounded(row) ? std::abs(change[i]) / block.inv_d[i] : std::abs(missing_speed(r, block, impulse, s, i));
    const Real size = length(a.velocity) + length(b.velocity) + length(row.angular_a) * length(a.angular_velocity) +
                      length(row.angular_b) * length(b.angular_velocity);
    worst = std::max(worst, error - 8 * kEpsilon * (size + std::abs(block.gamma[i] * impulse[i])));
  }
  return worst;
}

void solve_block_speed(const BlockRows& r, const ImpulseBlock& block, Real* impulse, const ImpulseScene& s) {
  Real change[6];
  wanted_change(r, block, impulse, s, change);
  for (int i = 0; i < r.count; ++i) impulse[i] += change[i];
  apply_block(r, change, s);
}

Real block_position_error(const BlockRows& r) {
  Real worst = 0;
  for (int i = 0; i < r.count; ++i)
    if (has_position(r.rows[i])) worst = std::max(worst, std::abs(r.rows[i].value));
  return worst;
}

void correct_block(const BlockRows& r, const ImpulseScene& s) {
  FEDER_ASSERT(r.a != r.b);
  if (!(block_position_error(r) > 0)) return;
  Real m[6][6], inv_d[6], move[6];
  for (int i = 0; i < r.count; ++i) {
    for (int j = 0; j <= i; ++j) m[i][j] = response(r, i, j, s);
    move[i] = clamp(-r.rows[i].value, -kMaxCorrection, kMaxCorrection);
  }
  factor(m, r.count, inv_d);
  solve(m, inv_d, r.count, move);
  push_block<&shift_joint, Vec3>(r, move, s);
}

Real block_drift(const BlockRows& start, const BlockRows& now) {
  Real worst = 0;
  for (int i = 0; i < now.count; ++i) worst = std::max(worst, std::abs(drift(start.rows[i], now.rows[i])));
  return worst;
}

void correct_block_drift(const BlockRows& start, const BlockRows& now, const ImpulseBlock& block, Real* impulse,
                         const ImpulseScene& s) {
  if (!(block_drift(start, now) > 0)) return;
  const int count = now.count;
  Real move[6];
  for (int i = 0; i < count; ++i) move[i] = clamp(-drift(start.rows[i], now.rows[i]), -kMaxCorrection, kMaxCorrection);
  solve(block.factor, block.inv_d, count, move);
  for (int i = 0; i < count; ++i) {
    move[i] /= s.h;
    impulse[i] += move[i];
  }
  push_back_block(start, move, s);
}

}  // namespace feder
