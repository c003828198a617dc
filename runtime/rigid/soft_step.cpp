// Soft step: substepped sequential impulses with soft constraints (Catto, "Solver2D", 2024; "Soft Constraints", GDC
// 2011). Per substep: impacts, warm start, joints and contacts with bias, positions, the same without bias.
// Impacts are pairwise and sequential, before the soft rows could share them out: all points that will touch within the
// substep, faster than bounce_speed, strike at once with restitution (Newton's law, rounds of Gauss-Seidel); then those
// that this has made approach, and so on, so that a row of balls passes a blow on to the last (in the spirit of
// Guendelman, Bridson, Fedkiw 2003, and of generalized reflections, Smith et al. 2012).
// Contacts are coloured greedily (no two of a colour push the same solver body) and solved eight at a time; those that
// find no colour are solved alone. Contact rows do not change within a step, so the warm start of substeps 2..n is one
// addition per solver body: the velocity change by contacts in the substep before.
// Kept between steps: impulses, in Contacts and SolverJoint. Weak spot: stiff trees of joints, very high mass ratios
// with few substeps; simultaneous hits that share a body are resolved in colour order, in a few rounds.
#include <algorithm>

#include "base/hash.h"
#include "base/jobs.h"
#include "base/simd.h"
#include "feder/error.h"
#include "rigid/contact_batch.h"
#include "rigid/soft_joints.h"
#include "rigid/solver.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "state/solver_bodies.h"

namespace feder {
namespace {

constexpr int kColors = 64;
constexpr int kFixedColor = 48;  // colours from here on: contacts against immovable bodies, solved last
// Contact softness by crowding: one pass per substep cannot resolve many stiff contacts of a body, so a contact is
// softer by kCrowd per contact's worth of stiffness above one. With less, pyramids of 30 do not come to rest; with 1.5
// one of 100 buckles. Immovable bodies count kSupport: with 1/2 a heavy crate on a light one oscillates for twice as
// long, with 1 a tower sinks a twentieth deeper.
constexpr Real kCrowd = 1.25, kSupport = 0.75;
// A contact bounces when it closes faster than gravity alone would make it in so many substeps, and bounce_speed.
constexpr Real kRestSubsteps = 4;
constexpr int kStrikeWaves = 64;  // in a substep; what has not been passed on then is left to the soft rows
// batches and bodies per job
constexpr JobGrain kSolveGrain{8, 2'500}, kFillGrain{8, 5'000}, kStoreGrain{8, 1'000}, kBodyGrain{512, 3'000};

static_assert(std::is_same_v<WideReal, Real>);
static_assert(kBatchPoints == kMaxContactPoints);

const ContactKernels& pick_kernels([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && __builtin_cpu_supports("avx2")) return kContactKernelsAvx2;
#endif
  return kContactKernelsPlain;
}

class SoftStep final : public RigidSolver {
 public:
  SoftStep(Arena& arena, const Params& p)
      : kernels_(&pick_kernels(wide_kernels(p))), contact_hertz_(p.real({"contact_hertz", "Hz", {0.1, 1e5}}, 72)),
        contact_damping_(p.real({"contact_damping", "", {0, 1e3}}, 16)),
        contact_cap_(p.real({"contact_cap", "", kUnitRange}, 0.3)),
        push_speed_(p.real({"push_speed", "m/s", {0, 1e6}}, 3)),
        bounce_speed_(p.real({"bounce_speed", "m/s", {0, 1e6}}, 0.02)),
        bounce_rounds_(p.integer({"bounce_rounds", "", {1, 100}}, 4)),
        joints_(arena, p.real({"joint_hertz", "Hz", {0.1, 1e5}}, 60), p.real({"joint_damping", "", {0, 1e3}}, 2),
                push_speed_, p.flag({"joint_trees"}, true), joint_kernels(wide_kernels(p))) {}

  void prepare(const SolverInput& in, StepContext& c) override;
  void solve(const SolverInput& in, StepContext& c) override;
  void finish(const SolverInput& in, StepContext& c) override;
  bool wide() const override { return kernels_ != &kContactKernelsPlain; }

 private:
  void color(const SolverInput& in, StepContext& c);
  void check_colors(const SolverInput& in, StepContext& c) const;
  void fill(const SolverInput& in, std::uint32_t batch);
  void fill_lane(const Contact& contact, std::uint32_t batch, int lane);
  void store_batch(Contacts& contacts, std::uint32_t batch) const;
  // Calls f(i) for the solver bodies but the world, in parallel.
  template <class F>
  void each_body(const SolverInput& in, StepContext& c, F&& f) {
    FEDER_ASSERT(in.solver_bodies->state.size() == body_count_);
    c.jobs->for_blocks(static_cast<std::uint32_t>(body_count_), kBodyGrain,
                       [&](std::uint32_t first, std::uint32_t last, int) {
                         for (std::uint32_t i = std::max(first, 1u); i < last; ++i) f(i);
                       });
  }
  void start_velocities(const SolverInput& in, StepContext& c);
  void integrate(const SolverInput& in, StepContext& c);
  void end_velocities(const SolverInput& in, StepContext& c);
  void report_corrections(const SolverInput& in, StepContext& c);
  ContactPass pass(const SolverInput& in, const StepContext& c) const;
  void strike(const SolverInput& in, StepContext& c);
  template <class F>
  void keep_out(const SolverInput& in, StepContext& c, F&& f);
  void run(void (*kernel)(const ContactPass&), const SolverInput& in, StepContext& c);

  const ContactKernels* kernels_;
  Real contact_hertz_, contact_damping_, contact_cap_, push_speed_, bounce_speed_;
  int bounce_rounds_;
  SoftJoints joints_;

  // in the step's scratch memory
  ContactBatch* batches_ = nullptr;
  BatchSide* sides_ = nullptr;
  StrikeBatch* strikes_ = nullptr;  // null: nothing bounces
  WideMass* masses_ = nullptr;
  Real* crowd_ = nullptr;  // by solver index: stiffness of its contacts over its mass: 1 in a tower, 2 in a pyramid
  std::uint32_t* lanes_ = nullptr;  // contact slot by batch and lane, kNone where empty
  Real* before_ = nullptr;          // velocities before the contacts of the substep, 6 per solver body
  Real* contact_change_ = nullptr;  // velocity change by contacts in the last substep, 6 per solver body
  std::uint32_t batch_count_ = 0, overflow_count_ = 0;
  std::size_t body_count_ = 0, contact_count_ = 0;  // when the step was prepared
  std::uint32_t color_first_[kColors + 1] = {};     // first batch of each colour; the overflow comes before colour 0
  JobPool::Stage stages_[kColors];                  // of the kernel that runs: its colours
  Vec3 gravity_ = Vec3::Zero();
};

bool movable(const SolverMass& m) {
  return m.inv_mass > 0 || m.inv_inertia(0, 0) > 0 || m.inv_inertia(1, 1) > 0 || m.inv_inertia(2, 2) > 0;
}

void SoftStep::color(const SolverInput& in, StepContext& c) {
  const Contacts& contacts = *in.contacts;
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::uint32_t count = static_cast<std::uint32_t>(contacts.active.size());
  const std::size_t body_count = solver_bodies.state.size();
  std::uint64_t* taken = c.scratch->take<std::uint64_t>(body_count);
  std::uint8_t* color_of = c.scratch->take<std::uint8_t>(count);
  // the world and kinematic solver bodies never conflict
  const std::uint64_t kFixedMask = ~std::uint64_t(0) << kFixedColor;
  crowd_ = c.scratch->take<Real>(body_count);
  for (std::size_t i = 0; i < body_count; ++i) taken[i] = 0, crowd_[i] = 0;
  // greedy: the first colour that neither body has; and how crowded each body is
  std::uint32_t of_color[kColors + 1] = {};
  for (std::uint32_t i = 0; i < count; ++i) {
    const Contact& contact = contacts.slots[contacts.active[i]];
    const std::uint32_t a = in.solver_index(contact.collider_a), b = in.solver_index(contact.collider_b);
    const bool moves_a = masses_[a].movable > 0, moves_b = masses_[b].movable > 0;
    std::uint64_t used = (moves_a ? taken[a] : 0) | (moves_b ? taken[b] : 0);
    used |= moves_a && moves_b ? kFixedMask : ~kFixedMask;
    FEDER_ASSERT(a < body_count && b < body_count);
    const Real wa = solver_bodies.mass[a].inv_mass, wb = solver_bodies.mass[b].inv_mass;
    const bool both = wa > 0 && wb > 0;
    crowd_[a] += both ? wa / (wa + wb) : kSupport;
    crowd_[b] += both ? wb / (wa + wb) : kSupport;
    std::uint8_t color = kColors;
    if (~used) {
      color = static_cast<std::uint8_t>(__builtin_ctzll(~used));
      const std::uint64_t bit = std::uint64_t(1) << color;
      if (moves_a) taken[a] |= bit;
      if (moves_b) taken[b] |= bit;
    }
    color_of[i] = color;
    ++of_color[color];
  }
  // overflow first, one contact per batch
  overflow_count_ = of_color[kColors];
  std::uint32_t batch = overflow_count_, next[kColors + 1];
  next[kColors] = 0;
  for (int k = 0; k < kColors; ++k) {
    color_first_[k] = batch;
    next[k] = batch * kLanes;
    batch += (of_color[k] + kLanes - 1) / kLanes;
  }
  color_first_[kColors] = batch_count_ = batch;
  // contacts into their lanes
  lanes_ = c.scratch->take<std::uint32_t>(std::size_t(batch) * kLanes);
  std::fill(lanes_, lanes_ + std::size_t(batch) * kLanes, kNone);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t& at = next[color_of[i]];
    lanes_[at] = contacts.active[i];
    at += color_of[i] == kColors ? kLanes : 1;
  }
  if constexpr (kAsserts) check_colors(in, c);
}

// Checks the colouring: each active contact lies in one lane; lanes of a colour, and those of an overflow batch, push
// different solver bodies.
void SoftStep::check_colors(const SolverInput& in, StepContext& c) const {
  std::uint32_t* last =
      c.scratch->take<std::uint32_t>(in.solver_bodies->state.size());  // by solver index: the colour it was met in
  std::fill(last, last + in.solver_bodies->state.size(), kNone);
  MultisetHash active, listed;
  for (const std::uint32_t slot : in.contacts->active) active.add(slot);
  FEDER_ASSERT(color_first_[0] == overflow_count_ && color_first_[kColors] == batch_count_);
  int color = 0;
  for (std::uint32_t batch = 0; batch < batch_count_; ++batch) {
    while (batch >= overflow_count_ && batch >= color_first_[color + 1]) ++color;
    const std::uint32_t name = batch < overflow_count_ ? kColors + batch : static_cast<std::uint32_t>(color);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t slot = lanes_[std::size_t(batch) * kLanes + lane];
      if (slot == kNone) continue;
      listed.add(slot);
      const Contact& contact = in.contacts->slots[slot];
      for (const std::uint32_t collider : {contact.collider_a, contact.collider_b}) {
        const std::uint32_t i = in.solver_index(collider);
        if (!(masses_[i].movable > 0)) continue;
        FEDER_ASSERT(last[i] != name);
        last[i] = name;
      }
    }
  }
  FEDER_ASSERT(active == listed);
}

void SoftStep::fill_lane(const Contact& contact, std::uint32_t batch, int lane) {
  FEDER_ASSERT(contact.touching && !contact.sensor);
  FEDER_ASSERT(contact.point_count >= 1 && contact.point_count <= kBatchPoints);
  ContactBatch& c = batches_[batch];
  BatchSide& side = sides_[batch];
  const auto put = [lane](Lane8x3& to, const Vec3& v) {
    to.x.v[lane] = v[0], to.y.v[lane] = v[1], to.z.v[lane] = v[2];
  };
  // points
  put(c.normal, contact.normal);
  for (int j = 0; j < contact.point_count; ++j) {
    const ContactPoint& from = contact.points[j];
    BatchPoint& q = c.point[j];
    put(q.angular_a, from.arm_a);
    put(q.angular_b, from.arm_b);
    q.separation.v[lane] = from.separation;
    q.impulse.v[lane] = from.normal_impulse;
    q.mass.v[lane] = 1;
  }
  c.points = std::max(c.points, unsigned(contact.point_count));
  // landing: no warm start, and about to carry weight: worth more rounds
  side.lands.v[lane] = contact.fresh || std::fabs(dot(contact.normal, gravity_)) > length(gravity_) / 2 ? 1 : 0;
  // friction and restitution
  c.friction_static.v[lane] = contact.friction_static;
  c.friction_dynamic.v[lane] = contact.friction_dynamic;
  c.tangent_impulse[0].v[lane] = contact.tangent_impulse[0];
  c.tangent_impulse[1].v[lane] = contact.tangent_impulse[1];
  c.twist_impulse.v[lane] = contact.twist_impulse;
  if (!contact.surface_velocity.isZero(0)) {
    Vec3 t1, t2;
    tangent_frame(contact.normal, t1, t2);
    c.tangent_speed[0].v[lane] = dot(contact.surface_velocity, t1);
    c.tangent_speed[1].v[lane] = dot(contact.surface_velocity, t2);
  }
  side.restitution.v[lane] = contact.restitution;
  if (contact.restitution > 0) side.bounces = 1;
  if (contact.rolling_friction > 0) side.rolls = 1;
  side.rolling_arm.v[lane] = contact.rolling_friction;
  put(side.rolling_impulse, contact.rolling_impulse);
}

void SoftStep::fill(const SolverInput& in, std::uint32_t batch) {
  ContactBatch& c = batches_[batch];
  std::memset(static_cast<void*>(&c), 0, sizeof c);
  std::memset(static_cast<void*>(&sides_[batch]), 0, sizeof(BatchSide));
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t slot = lanes_[std::size_t(batch) * kLanes + static_cast<std::size_t>(lane)];
    if (slot == kNone) continue;
    FEDER_ASSERT(slot < in.contacts->slots.size());
    const Contact& contact = in.contacts->slots[slot];
    const std::uint32_t a = in.solver_index(contact.collider_a), b = in.solver_index(contact.collider_b);
    const bool moves_a = masses_[a].movable > 0, moves_b = masses_[b].movable > 0;
    c.index_a[lane] = a, c.index_b[lane] = b;
    if (moves_a) c.writes_a |= 1u << lane;
    if (moves_b) c.writes_b |= 1u << lane;
    c.against_fixed.v[lane] = moves_a && moves_b ? 0 : 1;
    c.leak.v[lane] = 1 + kCrowd * std::max(std::max(crowd_[a], crowd_[b]) - 1, Real(0));
    fill_lane(contact, batch, lane);
  }
}

ContactPass SoftStep::pass(const SolverInput& in, const StepContext& c) const {
  FEDER_ASSERT(in.solver_bodies->state.size() ==
               body_count_);  // masses and batches are those of the solver bodies of prepare
  ContactPass p{};
  p.batches = batches_;
  p.sides = sides_;
  p.strikes = strikes_;
  p.bodies = reinterpret_cast<Real*>(in.solver_bodies->state.data());
  p.masses = masses_;
  p.h = c.h;
  p.inv_h = 1 / c.h;
  // as stiff as the substep rate allows; twice that against immovable bodies
  const Real hertz = std::min(contact_hertz_, contact_cap_ / c.h);
  p.soft = soft_factors(hertz, contact_damping_, c.h);
  p.soft_fixed = soft_factors(2 * hertz, contact_damping_ / 2, c.h);
  p.push_speed = push_speed_;
  p.bounce_speed = bounce_speed_ + kRestSubsteps * c.h * length(c.gravity);
  p.odd = static_cast<unsigned>(c.substep) & 1u;
  return p;
}

void SoftStep::run(void (*kernel)(const ContactPass&), const SolverInput& in, StepContext& c) {
  if (batch_count_ == 0) return;
  ContactPass p = pass(in, c);
  // batches lie in the order of their colours: alone, one thread does all in one go
  const bool alone = c.jobs->threads() == 1;
  p.first = 0, p.last = alone ? batch_count_ : overflow_count_;
  if (p.last) kernel(p);
  if (alone) return;
  const auto solve = [&p, kernel](std::uint32_t from, std::uint32_t to, int) {
    ContactPass part = p;
    part.first = from, part.last = to;
    kernel(part);
  };
  std::size_t count = 0;
  for (int k = 0; k < kColors; ++k)
    if (color_first_[k] < color_first_[k + 1])
      stages_[count++] = JobPool::stage(color_first_[k], color_first_[k + 1], kSolveGrain, solve);
  c.jobs->run_stages({stages_, count});
}

void SoftStep::prepare(const SolverInput& in, StepContext& c) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::uint32_t body_count = static_cast<std::uint32_t>(solver_bodies.state.size());
  FEDER_ASSERT(body_count >= 1 && solver_bodies.mass.size() == body_count);
  body_count_ = body_count, contact_count_ = in.contacts->active.size();
  before_ = c.scratch->take<Real>(std::size_t(body_count) * 6);
  contact_change_ = c.scratch->take<Real>(std::size_t(body_count) * 6);
  batch_count_ = overflow_count_ = 0;
  strikes_ = nullptr;
  gravity_ = c.gravity;
  if (!in.active_joints.empty())
    joints_.prepare(in, c, !in.contacts->active.empty());
  else if (!joints_.is_clear())
    joints_.clear();
  if (in.contacts->active.empty()) return;
  // masses in the order of the kernels
  masses_ = c.scratch->take<WideMass>(body_count);
  for (std::uint32_t i = 0; i < body_count; ++i) {
    const SolverMass& m = solver_bodies.mass[i];
    const Mat3& j = m.inv_inertia;
    masses_[i] = {{m.inv_mass_axes[0], m.inv_mass_axes[1], m.inv_mass_axes[2]},
                  {j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(0, 2), j(1, 2)},
                  Real(movable(m) ? 1 : 0),
                  {}};
  }
  // colours, then batches
  color(in, c);
  batches_ = c.scratch->take<ContactBatch>(batch_count_);
  sides_ = c.scratch->take<BatchSide>(batch_count_);
  const ContactPass p = pass(in, c);
  c.jobs->for_blocks(batch_count_, kFillGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) fill(in, i);
    ContactPass part = p;
    part.first = first, part.last = last;
    kernels_->prepare(part);
  });
  bool bounces = false;
  for (std::uint32_t i = 0; i < batch_count_; ++i) bounces = bounces || sides_[i].bounces;
  if (bounces) strikes_ = c.scratch->take<StrikeBatch>(batch_count_);
}

void SoftStep::start_velocities(const SolverInput& in, StepContext& c) {
  FEDER_ASSERT(before_);
  SolverBody* state = in.solver_bodies->state.data();
  const bool again = c.substep > 0 && batch_count_ > 0;
  each_body(in, c, [&](std::uint32_t i) {
    Real* before = before_ + std::size_t(i) * 6;
    const Real* change = contact_change_ + std::size_t(i) * 6;
    for (int k = 0; k < 3; ++k) {
      before[k] = state[i].velocity[k];
      before[k + 3] = state[i].angular_velocity[k];
      if (!again) continue;
      state[i].velocity[k] += change[k];
      state[i].angular_velocity[k] += change[k + 3];
    }
  });
}

void SoftStep::end_velocities(const SolverInput& in, StepContext& c) {
  const SolverBody* state = in.solver_bodies->state.data();
  each_body(in, c, [&](std::uint32_t i) {
    const Real* before = before_ + std::size_t(i) * 6;
    Real* change = contact_change_ + std::size_t(i) * 6;
    for (int k = 0; k < 3; ++k) {
      change[k] = state[i].velocity[k] - before[k];
      change[k + 3] = state[i].angular_velocity[k] - before[k + 3];
    }
  });
}

// Drift of an uneven jointed body after contacts: free rotation for h seconds, rad.
Vec3 drift_delta_rotation(JointedBody& j, const SolverBody& s, const SolverMass& m, Real h) {
  j.drift_angular_velocity = s.angular_velocity;
  take_pushes(j, s, m);
  return rotate_jointed(j, h);
}

void SoftStep::integrate(const SolverInput& in, StepContext& c) {
  SolverBody* state = in.solver_bodies->state.data();
  const Real h = c.h;
  const std::span<const BodySlide> slides = joints_.slides();
  FEDER_ASSERT(slides.empty() || slides.size() == body_count_);
  each_body(in, c, [&](std::uint32_t i) {
    SolverBody& s = state[i];
    s.delta_position += h * s.velocity;
    Vec3 rotation = h * s.angular_velocity;
    if (!slides.empty()) {
      s.delta_position += h * slides[i].velocity;
      if (JointedBody* j = in.uneven(i)) rotation = drift_delta_rotation(*j, s, in.solver_bodies->mass[i], h);
      rotation += h * slides[i].angular_velocity;
    }
    if (rotation[0] == 0 && rotation[1] == 0 && rotation[2] == 0) return;
    s.delta_rotation += rotation;
    s.rotation = integrate_rotation(s.rotation, rotation);
  });
}

// Rotation by bias velocities, which the relax pass removed from the velocity.
void SoftStep::report_corrections(const SolverInput& in, StepContext& c) {
  for (std::uint32_t i = 1; i < in.jointed.size(); ++i)
    if (JointedBody* j = in.uneven(i))
      j->correction = c.h * (j->drift_angular_velocity - in.solver_bodies->state[i].angular_velocity);
}

// What impacts change is no part of the warm start of the next substep: `before_` moves along.
void SoftStep::strike(const SolverInput& in, StepContext& c) {
  SolverBody* state = in.solver_bodies->state.data();
  if (c.substep == 0)
    each_body(in, c, [&](std::uint32_t i) {
      for (int k = 0; k < 3; ++k) {
        contact_change_[i * 6 + k] = state[i].velocity[k] - before_[i * 6 + k];
        contact_change_[i * 6 + k + 3] = state[i].angular_velocity[k] - before_[i * 6 + k + 3];
      }
    });
  const auto any_acts = [&] {
    for (std::uint32_t i = 0; i < batch_count_; ++i)
      if (sides_[i].bounces && strikes_[i].acts) return true;
    return false;
  };
  bool acted = false;
  for (int wave = 0; wave < kStrikeWaves; ++wave) {
    run(kernels_->mark, in, c);
    if (!any_acts()) break;
    acted = true;
    for (int round = 0; round < bounce_rounds_; ++round) run(kernels_->strike, in, c);
  }
  if (!acted) return;
  each_body(in, c, [&](std::uint32_t i) {
    for (int k = 0; k < 3; ++k) {
      before_[i * 6 + k] = state[i].velocity[k] - contact_change_[i * 6 + k];
      before_[i * 6 + k + 3] = state[i].angular_velocity[k] - contact_change_[i * 6 + k + 3];
    }
  });
}

// What `f` changes, by joints, is no part of the warm start of the next substep either.
template <class F>
void SoftStep::keep_out(const SolverInput& in, StepContext& c, F&& f) {
  const std::span<const std::uint32_t> bodies = joints_.bodies();
  const SolverBody* state = in.solver_bodies->state.data();
  const auto each = [&](const auto& change) {
    if (batch_count_ == 0) return;
    c.jobs->for_blocks(static_cast<std::uint32_t>(bodies.size()), kBodyGrain,
                       [&](std::uint32_t first, std::uint32_t last, int) {
                         for (std::uint32_t n = first; n < last; ++n) change(bodies[n]);
                       });
  };
  each([&](std::uint32_t i) {
    for (int k = 0; k < 3; ++k) {
      contact_change_[i * 6 + k] = state[i].velocity[k] - before_[i * 6 + k];
      contact_change_[i * 6 + k + 3] = state[i].angular_velocity[k] - before_[i * 6 + k + 3];
    }
  });
  f();
  each([&](std::uint32_t i) {
    for (int k = 0; k < 3; ++k) {
      before_[i * 6 + k] = state[i].velocity[k] - contact_change_[i * 6 + k];
      before_[i * 6 + k + 3] = state[i].angular_velocity[k] - contact_change_[i * 6 + k + 3];
    }
  });
}

void SoftStep::solve(const SolverInput& in, StepContext& c) {
  start_velocities(in, c);
  if (c.substep == 0) run(kernels_->warm_start, in, c);
  if (strikes_) strike(in, c);
  const bool jointed = !in.active_joints.empty();
  if (jointed) keep_out(in, c, [&] { joints_.solve(in, c); });
  run(kernels_->solve, in, c);
  integrate(in, c);
  if (jointed) keep_out(in, c, [&] { joints_.relax(in, c); });
  if (jointed && !joints_.all_direct()) report_corrections(in, c);
  run(kernels_->relax, in, c);
  if (batch_count_) end_velocities(in, c);
}

void SoftStep::store_batch(Contacts& contacts, std::uint32_t batch) const {
  const ContactBatch& c = batches_[batch];
  const BatchSide& side = sides_[batch];
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t slot = lanes_[std::size_t(batch) * kLanes + static_cast<std::size_t>(lane)];
    if (slot == kNone) continue;
    Contact& contact = contacts.slots[slot];
    FEDER_ASSERT(contact.collider_a != kNone && contact.point_count <= c.points);  // as it was filled
    for (int j = 0; j < contact.point_count; ++j) {
      ContactPoint& to = contact.points[j];
      to.normal_impulse = c.point[j].impulse.v[lane];
      to.total_impulse = side.total[j].v[lane];
      to.approach_speed = side.approach[j].v[lane];
    }
    contact.tangent_impulse[0] = c.tangent_impulse[0].v[lane];
    contact.tangent_impulse[1] = c.tangent_impulse[1].v[lane];
    contact.twist_impulse = c.twist_impulse.v[lane];
    contact.rolling_impulse =
        Vec3(side.rolling_impulse.x.v[lane], side.rolling_impulse.y.v[lane], side.rolling_impulse.z.v[lane]);
  }
}

void SoftStep::finish(const SolverInput& in, StepContext& c) {
  FEDER_ASSERT(in.contacts->active.size() == contact_count_);
  c.jobs->for_blocks(batch_count_, kStoreGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) store_batch(*in.contacts, i);
  });
  if (!in.active_joints.empty()) joints_.finish(in, c);
}

}  // namespace

Variant<RigidSolver> rigid_soft_step() {
  return {"soft_step", "substepped soft constraints with relaxation; eight contacts at a time",
          [](Arena& arena, const Params& p) -> std::unique_ptr<RigidSolver> {
            return std::make_unique<SoftStep>(arena, p);
          }};
}

}  // namespace feder
