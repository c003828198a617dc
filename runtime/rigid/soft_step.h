// The soft step as a class: what it keeps of a step, and its parts (soft_step.cpp, which alone includes this).
#pragma once
#include <span>

#include "base/jobs.h"
#include "base/simd.h"
#include "feder/error.h"
#include "rigid/contact_group.h"
#include "rigid/joint_impacts.h"
#include "rigid/soft_joints.h"
#include "rigid/solver.h"
#include "rigid/spin_batch.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "state/solver_bodies.h"

namespace feder {
namespace {

// A contact bounces when it closes faster than gravity alone would make it in so many substeps, and bounce_speed.
constexpr Real kRestSubsteps = 4;
// turns of contacts and joints, and rounds of contacts in each; what is left then is left to the soft rows
constexpr int kImpactTurns = 30, kImpactRounds = 16;
constexpr int kEaseTurns = 10, kEaseRounds = 4;  // likewise, for what the warm start throws
constexpr int kStrikeWaves = 64;    // in a substep; what has not been passed on then is left to the soft rows
constexpr Real kTreeRatio = 2'000;  // by experiment, with pieces: beyond, some chains gain energy
// Every so many substeps, contacts between bodies relax twice: what sways in large piles comes to rest in a third of
// the time. Not in pieces: 1000 times its weight on a box would sway.
constexpr std::uint32_t kRelaxAgain = 4;
constexpr Real kPieceHertz = Real(0.8);  // of the frequency of a contact, in pieces of a substep; at .9 some still sway
// batches and bodies per job
constexpr JobGrain kFillGrain{8, 5'000}, kBodyGrain{512, 3'000};

static_assert(std::is_same_v<WideReal, Real>);

const ContactKernels& pick_kernels([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && __builtin_cpu_supports("avx2")) return kContactKernelsAvx2;
#endif
  return kContactKernelsPlain;
}

class SoftStep final : public RigidSolver {
 public:
  SoftStep(Arena& arena, const Params& p)
      : kernels_(&pick_kernels(wide_kernels(p))), contact_hertz_(p.real({"contact_hertz", "Hz", {0.1, 1e5}}, 74)),
        contact_damping_(p.real({"contact_damping", "", {0, 1e3}}, 16)),
        contact_cap_(p.real({"contact_cap", "", kUnitRange}, 0.31)),
        push_speed_(p.real({"push_speed", "m/s", {0, 1e6}}, 3)),
        bounce_speed_(p.real({"bounce_speed", "m/s", {0, 1e6}}, 0.02)),
        bounce_rounds_(p.integer({"bounce_rounds", "", {1, 100}}, 4)),
        joint_hertz_(p.real({"joint_hertz", "Hz", {0.1, 1e5}}, 60)),
        joint_damping_(p.real({"joint_damping", "", {0, 1e3}}, 2)), joint_trees_(p.flag({"joint_trees"}, true)),
        arena_(arena), joint_kernels_(joint_kernels(wide_kernels(p))), spin_kernels_(spin_kernels(wide_kernels(p))) {}

  void prepare(const SolverInput& in, StepContext& c) override;
  void solve(const SolverInput& in, StepContext& c) override;
  void finish(const SolverInput& in, StepContext& c) override;
  ContactSpring contact_spring(Real h) const override;
  Real tree_ratio() const override { return joint_trees_ ? kTreeRatio : Real(0); }
  bool wide() const override { return kernels_ != &kContactKernelsPlain; }

 private:
  // What is solved together: contacts, joints (null: there never were any of this level) and the bodies they push.
  struct Group {
    ContactGroup contacts;
    std::unique_ptr<SoftJoints> soft_joints;
    std::span<const std::uint32_t> joints;  // indices into SolverInput::joints, ascending
    std::span<const std::uint32_t> bodies;  // solver indices, ascending; not listed where all are in the first group
    int level = 0;
    int pieces() const { return 1 << level; }
    bool used() const { return level == 0 || !bodies.empty(); }
  };
  // A substep of a group, or a piece of it.
  struct Piece {
    Real h;           // s
    bool first;       // of the step
    std::uint32_t k;  // in the step
  };
  // Calls f(i) for some solver bodies of a group but the world: the numbers first to last - 1 of listed_bodies.
  template <class F>
  void each_of(const Group& g, std::uint32_t first, std::uint32_t last, F&& f) const {
    if (split_)
      for (std::uint32_t n = first; n < last; ++n) f(g.bodies[n]);
    else
      for (std::uint32_t i = std::max(first, 1u); i < last; ++i) f(i);
  }
  std::uint32_t listed_bodies(const Group& g) const {
    return static_cast<std::uint32_t>(split_ ? g.bodies.size() : body_count_);
  }
  // For all of them, in parallel.
  template <class F>
  void each_body(const Group& g, StepContext& c, F&& f) {
    each_block(g, c, [&](std::uint32_t first, std::uint32_t last) { each_of(g, first, last, f); });
  }
  template <class F>
  void each_block(const Group& g, StepContext& c, F&& f) {
    c.jobs->for_blocks(listed_bodies(g), kBodyGrain,
                       [&](std::uint32_t first, std::uint32_t last, int) { f(first, last); });
  }
  void make_groups(const SolverInput& in, StepContext& c);
  void list_driven(const SolverInput& in, StepContext& c);
  void prepare_contacts(const SolverInput& in, StepContext& c);
  void prepare_joints(Group& g, const SolverInput& in, StepContext& c);
  void start_velocity(std::uint32_t i, bool again, SolverBody& s);
  void move(const Group& g, std::uint32_t first, std::uint32_t last, Real h, const SolverInput& in) const;
  void move_sliding(std::uint32_t i, Real h, std::span<const BodySlide> slides, const SolverInput& in) const;
  void end_velocity(std::uint32_t i, const SolverBody& s);
  void report_corrections(const Group& g, const Piece& piece, const SolverInput& in);
  ContactPass pass(const Group& g, const Piece& piece, const SolverInput& in, const StepContext& c) const;
  void renew_contacts(Group& g, const Piece& piece, const SolverInput& in, const StepContext& c);
  void begin_from(std::uint32_t i, const SolverBody& s);
  void strike(Group& g, const Piece& piece, const SolverInput& in, StepContext& c);
  void ease_contacts(Group& g, const Piece& piece, const SolverInput& in, const SolverInput& own, StepContext& c);
  void settle_impacts(Group& g, const Piece& piece, const SolverInput& in, const SolverInput& own, StepContext& c);
  template <class F>
  void keep_out(const Group& g, const SolverInput& in, StepContext& c, F&& f);
  static SolverInput part(const Group& g, const SolverInput& in) {
    SolverInput own = in;
    own.active_joints = g.joints;
    return own;
  }
  static void scale_impulses(const Group& g, const SolverInput& in, Real by) {
    for (const std::uint32_t j : g.joints)
      for (Real& impulse : in.joints[j].impulse) impulse *= by;
  }
  void solve_staged(Group& g, const Piece& piece, const SolverInput& in, StepContext& c);
  static bool relaxes_again(const Group& g, const Piece& piece, const StepContext& c) {
    const std::uint64_t pieces = c.step * static_cast<std::uint64_t>(c.substeps * g.pieces()) + piece.k;
    return g.level == 0 && !g.contacts.empty() && pieces % kRelaxAgain == kRelaxAgain - 1;
  }
  void solve_piece(Group& g, const Piece& piece, const SolverInput& in, StepContext& c);
  void solve_in_pieces(Group& g, const SolverInput& in, StepContext& c);

  const ContactKernels* kernels_;
  Real contact_hertz_, contact_damping_, contact_cap_, push_speed_, bounce_speed_;
  int bounce_rounds_;
  Real joint_hertz_, joint_damping_;
  bool joint_trees_;
  Arena& arena_;
  const JointKernels& joint_kernels_;
  const SpinKernels& spin_kernels_;
  Group groups_[kLevels];            // by level; the first has one piece
  bool split_ = false;               // there are others than the first
  std::span<std::uint32_t> driven_;  // solver indices of kinematic bodies that move, where there are others
  JobPool::Stage stages_[4 * (ContactGroup::kMostStages + 1)];  // of a piece

  // in the step's scratch memory
  ContactShared shared_;
  WideMass* masses_ = nullptr;       // those of shared_
  std::uint8_t* turned_ = nullptr;   // by solver index: contacts do not see its inertia now
  std::uint8_t* jointed_ = nullptr;  // by solver index: on a joint
  std::uint8_t* struck_ = nullptr;  // by solver index: the last wave of strikes in the substep; where something bounces
  Real* before_ = nullptr;          // velocities before the contacts of the substep, 6 per solver body
  Real* contact_change_ = nullptr;  // velocity change by contacts in the last substep, 6 per solver body
  Real* kept_ = nullptr;            // of bodies in pieces: velocities at the end of the last substep, 6 per solver body
  Real* push_ = nullptr;            // and what changed them since, per piece
  Vec3d* kept_momentum_ = nullptr;  // of uneven jointed bodies: angular momenta likewise, N m s
  std::size_t body_count_ = 0, contact_count_ = 0;  // when the step was prepared
};

}  // namespace
}  // namespace feder
