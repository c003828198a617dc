// Limits, motors and friction between bodies of a tree of joints: bounded rows, solved with the response of the whole
// tree. K = J (M^-1 projected on the motions that the joints allow) J^T between the rows of a tree that act, by one
// elimination each (joint_trees.h); then the bounded problem by projected Gauss-Seidel, and the tree once more with its
// impulses. A row solved with the masses of its two bodies alone, in turn with the tree, does not settle in a pass: a
// limit that stops an elbow leaves its joint open, and its warm start throws the limb back in the next substep.
// Weak spot: more than kMostActive rows of a tree are solved in parts, one after the other.
#include <algorithm>
#include <cmath>

#include "rigid/soft_joints.h"

namespace feder {
namespace {

constexpr std::size_t kMostActive = 32;    // rows of a tree solved together
constexpr int kBoundedRounds = 40;         // of Gauss-Seidel
constexpr Real kBoundedRest = Real(1e-5);  // m/s or rad/s: what is less does not act, nor goes on

}  // namespace

// A function of the structure, so that a restored world finds the same.
void SoftJoints::list_bounded() {
  bounded_.clear();
  bounded_.reserve(blocks_.size());
  with_tree_.assign(blocks_.size(), 0);
  if (trees_.empty()) return;
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    const RowBlock& block = blocks_[i];
    const Row& row = rows_[block.first];
    const bool bounded = row.lower > -kInfinity || row.upper < kInfinity;
    if (is_direct(i) || block.count != 1 || !bounded || row.hertz > 0 || !trees_.joins(block.index_a, block.index_b))
      continue;
    bounded_.push_back(i);
    with_tree_[i] = 1;
  }
  const auto tree = [this](std::uint32_t i) { return trees_.tree_of(blocks_[i].index_a, blocks_[i].index_b); };
  std::sort(bounded_.begin(), bounded_.end(),
            [&](std::uint32_t x, std::uint32_t y) { return tree(x) != tree(y) ? tree(x) < tree(y) : x < y; });
}

Real SoftJoints::velocity_error(const RowBlock& block, const SolverInput& in, bool biased) const {
  const SolverBody &a = in.solver_bodies->state[block.index_a], &b = in.solver_bodies->state[block.index_b];
  const ReadyRow& r = ready_[block.first];
  return dot(r.linear, Vec3(b.velocity - a.velocity)) + dot(r.angular_b, b.angular_velocity) +
         dot(r.angular_a, a.angular_velocity) + (biased ? r.bias : r.relaxed_bias);
}

// Returns whether impulses have changed, so that the trees have to be solved again.
bool SoftJoints::solve_bounded(const SolverInput& in, bool biased) {
  std::uint32_t active[kMostActive];
  std::size_t count = 0;
  bool changed = false;
  const auto tree = [this](std::uint32_t i) { return trees_.tree_of(blocks_[i].index_a, blocks_[i].index_b); };
  for (std::size_t k = 0; k < bounded_.size(); ++k) {
    const std::uint32_t i = bounded_[k];
    const RowBlock& block = blocks_[i];
    const ReadyRow& r = ready_[block.first];
    const Real impulse = in.joints[block.joint].impulse[block.first_impulse];
    const Real error = velocity_error(block, in, biased);
    const bool acts = impulse != 0 || (error < -kBoundedRest && r.upper > 0) || (error > kBoundedRest && r.lower < 0);
    if (acts) active[count++] = i;
    const bool last = k + 1 == bounded_.size() || tree(bounded_[k + 1]) != tree(i);
    if (count == 0 || (!last && count < kMostActive)) continue;
    changed |= solve_active({active, count}, in, biased);
    count = 0;
  }
  return changed;
}

bool SoftJoints::solve_active(std::span<const std::uint32_t> active, const SolverInput& in, bool biased) {
  const std::size_t n = active.size();
  double matrix[kMostActive][kMostActive], error[kMostActive];
  Real before[kMostActive];
  double worst = 0;
  bias_.assign(rows_.size(), Real(0));
  for (std::size_t i = 0; i < n; ++i) {
    const RowBlock& block = blocks_[active[i]];
    error[i] = static_cast<double>(velocity_error(block, in, biased));
    before[i] = in.joints[block.joint].impulse[block.first_impulse];
  }
  for (std::size_t j = 0; j < n; ++j) {
    trees_.respond(blocks_[active[j]], rows_, in, bias_, step_);
    for (std::size_t i = 0; i < n; ++i) matrix[i][j] = trees_.response(blocks_[active[i]], rows_, in);
  }
  for (int round = 0; round < kBoundedRounds; ++round) {
    double most = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const RowBlock& block = blocks_[active[i]];
      const ReadyRow& r = ready_[block.first];
      if (!(matrix[i][i] > 0)) continue;  // the joints allow no motion along it
      Real& impulse = in.joints[block.joint].impulse[block.first_impulse];
      const Real mass_scale = biased ? r.mass_scale : r.relaxed_mass_scale;
      const Real impulse_scale = biased ? r.impulse_scale : r.relaxed_impulse_scale;
      const Real wanted = impulse - mass_scale * static_cast<Real>(error[i] / matrix[i][i]) - impulse_scale * impulse;
      const Real now = clamp(wanted, r.lower, r.upper);
      const double step = static_cast<double>(now - impulse);
      impulse = now;
      for (std::size_t k = 0; k < n; ++k) error[k] += matrix[k][i] * step;
      most = std::max(most, std::abs(step) * matrix[i][i]);
    }
    worst = std::max(worst, most);
    if (most < static_cast<double>(kBoundedRest)) break;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const RowBlock& block = blocks_[active[i]];
    const Real step = in.joints[block.joint].impulse[block.first_impulse] - before[i];
    if (step != 0) push(block, &step, in);
  }
  return worst > static_cast<double>(kBoundedRest);
}

}  // namespace feder
