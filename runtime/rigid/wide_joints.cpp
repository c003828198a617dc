#include "rigid/wide_joints.h"

#include <algorithm>
#include <cstring>

#include "base/wide.h"
#include "feder/error.h"
#include "rigid/joint_load.h"

namespace feder {
namespace {

constexpr JobGrain kJointGrain{8, 2'000}, kJointFillGrain{8, 8'000};  // batches per job

// Is its velocity changed by joints?
bool can_move(const SolverMass& m) { return m.inv_mass > 0 || !m.inv_inertia.isZero(0); }

void put_lane(Lane8x3& to, int lane, const Vec3& v) { to.x.v[lane] = v[0], to.y.v[lane] = v[1], to.z.v[lane] = v[2]; }

}  // namespace

const JointKernels& joint_kernels([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && runs_avx2()) return kJointKernelsAvx2;
#endif
  return kJointKernelsPlain;
}

void WideJoints::color(const SolverInput& in, std::span<const std::uint32_t> wanted, Array<std::uint32_t>& rest,
                       StepContext& c) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::size_t body_count = solver_bodies.state.size();
  std::uint64_t* taken = c.scratch->take<std::uint64_t>(body_count);
  std::uint8_t* color_of = c.scratch->take<std::uint8_t>(wanted.size());
  std::fill_n(taken, body_count, std::uint64_t(0));
  // greedy: the first colour that neither body has
  std::uint32_t of_color[kColors] = {}, next[kColors];
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const SolverJoint& joint = in.joints[wanted[i]];
    const std::uint32_t a = solver_bodies.at(joint.slot_a), b = solver_bodies.at(joint.slot_b);
    const bool moves_a = can_move(solver_bodies.mass[a]), moves_b = can_move(solver_bodies.mass[b]);
    const std::uint64_t used = (moves_a ? taken[a] : 0) | (moves_b ? taken[b] : 0);
    color_of[i] = kColors;
    if (!~used) {
      rest.push_back(wanted[i]);
      continue;
    }
    color_of[i] = static_cast<std::uint8_t>(__builtin_ctzll(~used));
    const std::uint64_t bit = std::uint64_t(1) << color_of[i];
    if (moves_a) taken[a] |= bit;
    if (moves_b) taken[b] |= bit;
    ++of_color[color_of[i]];
  }
  // batches in the order of colours, joints into their lanes
  std::uint32_t batch = 0;
  for (int k = 0; k < kColors; ++k) {
    color_first_[k] = batch;
    next[k] = batch * kLanes;
    batch += (of_color[k] + kLanes - 1) / kLanes;
  }
  color_first_[kColors] = batch;
  lanes_.assign(std::size_t(batch) * kLanes, kNone);
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (color_of[i] < kColors) lanes_[next[color_of[i]]++] = wanted[i];
  batches_.resize(batch);
  if constexpr (kAsserts) check_colors(in, c);
}

// Checks the colouring: joints of a colour push different solver bodies.
void WideJoints::check_colors(const SolverInput& in, StepContext& c) const {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  std::uint32_t* last = c.scratch->take<std::uint32_t>(solver_bodies.state.size());
  std::fill_n(last, solver_bodies.state.size(), kNone);
  for (std::uint32_t k = 0; k < kColors; ++k) {
    for (std::size_t at = std::size_t(color_first_[k]) * kLanes; at < std::size_t(color_first_[k + 1]) * kLanes; ++at) {
      if (lanes_[at] == kNone) continue;
      for (const std::uint32_t slot : {in.joints[lanes_[at]].slot_a, in.joints[lanes_[at]].slot_b}) {
        const std::uint32_t i = solver_bodies.at(slot);
        if (!can_move(solver_bodies.mass[i])) continue;
        FEDER_ASSERT(last[i] != k);
        last[i] = k;
      }
    }
  }
}

void WideJoints::fill_lane(const SolverInput& in, const SolverJoint& joint, PointJointBatch& c, int lane) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  Vec3 origin[2];
  const auto side = [&](bool b) {
    const std::uint32_t index = b ? c.index_b[lane] : c.index_a[lane];
    const SolverMass& m = solver_bodies.mass[index];
    const Vec3 anchor = b ? joint.shape.frame_b.position : joint.shape.frame_a.position;
    // the world's anchor is a point, not an arm: far from its origin an arm would have no digits
    const Vec3 arm = index == 0 ? Vec3(Vec3::Zero()) : anchor;
    origin[b] = index == 0 ? anchor : m.center;
    put_lane(b ? c.local_b : c.local_a, lane, arm);
    (b ? c.arm_b : c.arm_a).v[lane] = length(arm);
    put_lane(b ? c.inv_mass_b : c.inv_mass_a, lane, m.inv_mass_axes);
    Lane8* inertia = b ? c.inv_inertia_b : c.inv_inertia_a;
    const Mat3& j = m.inv_inertia;
    const Real parts[6] = {j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(0, 2), j(1, 2)};
    for (int k = 0; k < 6; ++k) inertia[k].v[lane] = parts[k];
    if (can_move(m)) (b ? c.writes_b : c.writes_a) |= 1u << lane;
  };
  side(false), side(true);
  put_lane(c.start_gap, lane, origin[1] - origin[0]);
  put_lane(c.impulse, lane, Vec3(joint.impulse[0], joint.impulse[1], joint.impulse[2]));
}

void WideJoints::fill(const SolverInput& in, std::uint32_t batch, std::span<const std::uint8_t> in_contact) {
  PointJointBatch& c = batches_[batch];
  std::memset(static_cast<void*>(&c), 0, sizeof c);
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t j = lanes_[std::size_t(batch) * kLanes + static_cast<std::size_t>(lane)];
    if (j == kNone) continue;
    SolverJoint& joint = in.joints[j];
    joint.rows = 3;
    c.index_a[lane] = in.solver_bodies->at(joint.slot_a), c.index_b[lane] = in.solver_bodies->at(joint.slot_b);
    c.bends_a.v[lane] = in_contact[c.index_a[lane]] ? 0 : 1;
    c.bends_b.v[lane] = in_contact[c.index_b[lane]] ? 0 : 1;
    fill_lane(in, joint, c, lane);
  }
}

void WideJoints::load(const SolverInput& in, StepContext& c, std::span<const std::uint8_t> in_contact,
                      std::span<Real> strain) {
  const auto count = static_cast<std::uint32_t>(batches_.size());
  c.jobs->for_blocks(count, kJointFillGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) fill(in, i, in_contact);
  });
  for (const PointJointBatch& b : batches_) {
    for (int i = 0; i < kLanes; ++i) {
      const Real pull = c.h * length(Vec3(b.impulse.x.v[i], b.impulse.y.v[i], b.impulse.z.v[i]));
      strain[b.index_a[i]] += pull * b.arm_a.v[i];
      strain[b.index_b[i]] += pull * b.arm_b.v[i];
    }
  }
}

void WideJoints::solve(const JointPass& pass, StepContext& c) {
  JointPass p = pass;
  p.batches = batches_.data();
  const std::uint32_t count = color_first_[kColors];
  if (c.jobs->threads() == 1) {
    p.last = count;
    for (const Kernel kernel : {kernels_->start, kernels_->warm_start, kernels_->solve}) kernel(p);
    return;
  }
  const auto part = [&p](Kernel kernel) {
    return [&p, kernel](std::uint32_t first, std::uint32_t last, int) {
      JointPass own = p;
      own.first = first, own.last = last;
      kernel(own);
    };
  };
  const auto start = part(kernels_->start), warm = part(kernels_->warm_start), solve = part(kernels_->solve);
  std::size_t stages = 0;
  stages_[stages++] = JobPool::stage(0, count, kJointGrain, start);
  for (const auto* body : {&warm, &solve})
    for (int k = 0; k < kColors; ++k)
      if (color_first_[k] < color_first_[k + 1])
        stages_[stages++] = JobPool::stage(color_first_[k], color_first_[k + 1], kJointGrain, *body);
  c.jobs->run_stages({stages_, stages});
}

void WideJoints::relax(const JointPass& pass, StepContext& c) {
  JointPass p = pass;
  p.batches = batches_.data();
  const auto relax = [&p, kernel = kernels_->relax](std::uint32_t first, std::uint32_t last, int) {
    JointPass own = p;
    own.first = first, own.last = last;
    kernel(own);
  };
  const bool alone = c.jobs->threads() == 1;
  std::size_t stages = 0;
  for (int k = kColors; k-- > 0;) {
    if (color_first_[k] == color_first_[k + 1]) continue;
    if (alone) relax(color_first_[k], color_first_[k + 1], 0);
    stages_[stages++] = JobPool::stage(color_first_[k], color_first_[k + 1], kJointGrain, relax);
  }
  if (!alone) c.jobs->run_stages({stages_, stages});
}

void WideJoints::note_loads(const SolverInput& in, Real h) const {
  for (std::size_t at = 0; at < lanes_.size(); ++at) {
    if (lanes_[at] == kNone || !in.joints[lanes_[at]].breakable) continue;
    const Lane8x3& impulse = batches_[at / kLanes].impulse;
    const std::size_t i = at % kLanes;
    note_force(in.joints[lanes_[at]], Vec3(impulse.x.v[i], impulse.y.v[i], impulse.z.v[i]), h);
  }
}

void WideJoints::store(const SolverInput& in, StepContext& c) const {
  const auto count = static_cast<std::uint32_t>(batches_.size());
  c.jobs->for_blocks(count, kJointFillGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      for (int lane = 0; lane < kLanes; ++lane) {
        const std::uint32_t j = lanes_[std::size_t(i) * kLanes + static_cast<std::size_t>(lane)];
        if (j == kNone) continue;
        const Lane8x3& impulse = batches_[i].impulse;
        Real* to = in.joints[j].impulse;
        to[0] = impulse.x.v[lane], to[1] = impulse.y.v[lane], to[2] = impulse.z.v[lane];
      }
    }
  });
}

}  // namespace feder
