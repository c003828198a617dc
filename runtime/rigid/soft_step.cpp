// Soft step: substepped sequential impulses with soft constraints (Catto, "Solver2D", 2024; "Soft Constraints", GDC
// 2011). Per substep: impacts, warm start, joints and contacts with bias, positions, the same without bias.
// Impacts are pairwise and sequential, before the soft rows could share them out: all points that will touch within the
// substep, faster than bounce_speed, strike at once with restitution (Newton's law, rounds of Gauss-Seidel); then those
// that this has made approach, and so on, so that a row of balls passes a blow on to the last (in the spirit of
// Guendelman, Bridson, Fedkiw 2003, and of generalized reflections, Smith et al. 2012).
// Contact rows (rigid/contact_group.h) do not change within a step, so the warm start of substeps 2..n is one addition
// per solver body: the velocity change by contacts in the substep before.
// A contact is a spring whose stiffness goes with the smaller mass and the square of the substep rate, so islands whose
// contacts carry many times what they join do each substep in 2^level pieces (rigid/budget.cpp), as if the world had so
// many more substeps; what else changed their velocities is given in equal parts. By this a light box holds 10,000
// times its mass, and sinks in by less than a hundredth. Kept between steps: impulses, in Contacts and SolverJoint.
// Weak spot: stiff trees of joints and higher mass ratios; simultaneous hits that share a body are resolved in colour
// order, in a few rounds.
#include "rigid/soft_step.h"

#include <algorithm>

namespace feder {
namespace {

// The first numbers of a solver body: velocity and angular velocity.
Real* velocities_of(SolverBody& s) { return reinterpret_cast<Real*>(&s); }
const Real* velocities_of(const SolverBody& s) { return reinterpret_cast<const Real*>(&s); }

void put_velocity(const SolverBody& s, Real* to) { std::copy_n(velocities_of(s), 6, to); }

bool movable(const SolverMass& m) {
  return m.inv_mass > 0 || m.inv_inertia(0, 0) > 0 || m.inv_inertia(1, 1) > 0 || m.inv_inertia(2, 2) > 0;
}

ContactPass SoftStep::pass(const Group& g, const Piece& piece, const SolverInput& in, const StepContext& c) const {
  FEDER_ASSERT(in.solver_bodies->state.size() ==
               body_count_);  // masses and batches are those of the solver bodies of prepare
  ContactPass p = g.contacts.pass();
  p.bodies = reinterpret_cast<Real*>(in.solver_bodies->state.data());
  p.masses = shared_.masses;
  p.h = piece.h;
  p.inv_h = 1 / piece.h;
  // as stiff as the substep rate allows, less in pieces: a light body between heavy ones sways with growing amplitude
  // where rows are as stiff as between equal masses; twice that against immovable bodies
  const Real whole = std::min(contact_hertz_ * static_cast<Real>(g.pieces()), contact_cap_ / piece.h);
  const Real hertz = g.level > 0 ? kPieceHertz * whole : whole;
  p.soft = soft_factors(hertz, contact_damping_, piece.h);
  p.soft_fixed = soft_factors(2 * hertz, contact_damping_ / 2, piece.h);
  p.push_speed = push_speed_;
  p.bounce_speed = bounce_speed_ + kRestSubsteps * c.h * length(c.gravity);
  p.odd = piece.k & 1u;
  return p;
}

ContactSpring SoftStep::contact_spring(Real h) const {
  return {2 * kPi * std::min(contact_hertz_, contact_cap_ / h), kCrowd};
}

// Contacts, joints and solver bodies by level; without levels all are in the first group.
void SoftStep::make_groups(const SolverInput& in, StepContext& c) {
  const std::span<const std::uint32_t> active = {in.contacts->active.data(), in.contacts->active.size()};
  split_ = !in.levels.empty();
  for (int level = 0; level < kLevels; ++level) groups_[level].level = level, groups_[level].bodies = {};
  if (!split_) {
    for (int level = 1; level < kLevels; ++level) groups_[level].joints = {};
    groups_[0].joints = in.active_joints;
    groups_[0].contacts.build(in, c, shared_, active, 0);
    return;
  }
  FEDER_ASSERT(in.levels.size() == body_count_);
  const auto level_of = [&](std::uint32_t slot) {
    const Contact& contact = in.contacts->slots[slot];
    return std::max(in.levels[in.solver_index(contact.collider_a)], in.levels[in.solver_index(contact.collider_b)]);
  };
  const auto level_of_joint = [&](std::uint32_t j) {
    const JointInput joint = in.joint_input(in.joints[j]);
    return std::max(in.levels[joint.index_a], in.levels[joint.index_b]);
  };
  // those of `count` numbers whose level it is, in their order
  const auto of_level = [&](int level, std::size_t count, auto&& number, auto&& its_level) {
    std::uint32_t* list = c.scratch->take<std::uint32_t>(count);
    std::size_t listed = 0;
    for (std::size_t n = 0; n < count; ++n)
      if (its_level(number(n)) == level) list[listed++] = number(n);
    return std::span<const std::uint32_t>(list, listed);
  };
  for (int level = 0; level < kLevels; ++level) {
    Group& g = groups_[level];
    g.bodies = of_level(
        level, body_count_ - 1, [](std::size_t n) { return static_cast<std::uint32_t>(n + 1); },
        [&](std::uint32_t i) { return in.levels[i]; });
    g.joints = {};
    if (!g.used()) continue;
    g.joints = of_level(
        level, in.active_joints.size(), [&](std::size_t n) { return in.active_joints[n]; }, level_of_joint);
    g.contacts.build(in, c, shared_,
                     of_level(
                         level, active.size(), [&](std::size_t n) { return active[n]; }, level_of),
                     level);
  }
}

void SoftStep::prepare(const SolverInput& in, StepContext& c) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::uint32_t body_count = static_cast<std::uint32_t>(solver_bodies.state.size());
  FEDER_ASSERT(body_count >= 1 && solver_bodies.mass.size() == body_count);
  body_count_ = body_count, contact_count_ = in.contacts->active.size();
  before_ = c.scratch->take<Real>(std::size_t(body_count) * 6);
  contact_change_ = c.scratch->take<Real>(std::size_t(body_count) * 6);
  if (contact_count_ > 0) {
    // masses in the order of the kernels
    WideMass* masses = c.scratch->take<WideMass>(body_count);
    for (std::uint32_t i = 0; i < body_count; ++i) {
      const SolverMass& m = solver_bodies.mass[i];
      const Mat3& j = m.inv_inertia;
      masses[i] = {{m.inv_mass_axes[0], m.inv_mass_axes[1], m.inv_mass_axes[2]},
                   {j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(0, 2), j(1, 2)},
                   Real(movable(m) ? 1 : 0),
                   {}};
    }
    masses_ = masses;
    turned_ = in.jointed.empty() ? nullptr : c.scratch->take<std::uint8_t>(body_count);
    if (turned_) std::fill_n(turned_, body_count, std::uint8_t(0));
    shared_ = {masses, c.scratch->take<Real>(body_count), c.scratch->take<std::uint64_t>(body_count)};
    std::fill_n(shared_.crowd, body_count, Real(0));
    std::fill_n(shared_.colors, body_count, std::uint64_t(0));
  }
  make_groups(in, c);
  for (Group& g : groups_) prepare_joints(g, in, c);
  jointed_ = nullptr;
  if (contact_count_ > 0 && !in.active_joints.empty()) {
    jointed_ = c.scratch->take<std::uint8_t>(body_count);
    std::fill_n(jointed_, body_count, std::uint8_t(0));
    for (const Group& g : groups_)
      if (!g.joints.empty())
        for (const std::uint32_t i : g.soft_joints->bodies()) jointed_[i] = 1;
  }
  if (contact_count_ > 0) prepare_contacts(in, c);
  if (!split_) return;
  list_driven(in, c);
  kept_ = c.scratch->take<Real>(body_count_ * 6);
  push_ = c.scratch->take<Real>(body_count_ * 6);
  for (std::size_t i = 0; i < body_count_; ++i) put_velocity(in.solver_bodies->state[i], kept_ + i * 6);
  kept_momentum_ = in.jointed.empty() ? nullptr : c.scratch->take<Vec3d>(body_count_);
  for (std::uint32_t i = 0; i < in.jointed.size(); ++i)
    if (const JointedBody* j = in.uneven(i)) kept_momentum_[i] = carried_momentum(*j, in.solver_bodies->state[i]);
}

void SoftStep::list_driven(const SolverInput& in, StepContext& c) {
  std::uint32_t* list = c.scratch->take<std::uint32_t>(body_count_);
  std::size_t count = 0;
  for (std::uint32_t i = 1; i < body_count_; ++i) {
    const SolverBody& s = in.solver_bodies->state[i];
    if (!movable(in.solver_bodies->mass[i]) && !(s.velocity.isZero(0) && s.angular_velocity.isZero(0)))
      list[count++] = i;
  }
  driven_ = {list, count};
}

// Impulses of joints, too, are kept per substep.
void SoftStep::prepare_joints(Group& g, const SolverInput& in, StepContext& c) {
  if (g.joints.empty()) {
    if (g.soft_joints && !g.soft_joints->is_clear()) g.soft_joints->clear();
    return;
  }
  if (!g.soft_joints)
    g.soft_joints =
        std::make_unique<SoftJoints>(arena_, joint_hertz_, joint_damping_, push_speed_, joint_trees_, joint_kernels_);
  if (g.level > 0) scale_impulses(g, in, Real(1) / static_cast<Real>(g.pieces()));
  StepContext piece = c;
  piece.h = c.h / static_cast<Real>(g.pieces());
  g.soft_joints->prepare(part(g, in), piece, !in.contacts->active.empty());
}

void SoftStep::prepare_contacts(const SolverInput& in, StepContext& c) {
  struck_ = nullptr;
  for (Group& g : groups_) {
    if (!g.used()) continue;
    const ContactPass p = pass(g, {c.h / static_cast<Real>(g.pieces()), true, 0}, in, c);
    c.jobs->for_blocks(g.contacts.batch_count(), kFillGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      ContactPass part = p;
      part.first = first, part.last = last;
      g.contacts.prepare(in, shared_, c.gravity, *kernels_, part);
    });
    const bool bounces = g.contacts.any_bounces();
    if (bounces || (!g.joints.empty() && !g.contacts.empty())) g.contacts.expect_strikes(c, bounces);
    if (bounces && !struck_) struck_ = c.scratch->take<std::uint8_t>(body_count_);
  }
}

// Velocities before contacts, and the warm start of all pieces of a step but the first.
[[gnu::always_inline]] inline void SoftStep::start_velocity(std::uint32_t i, bool again, SolverBody& s) {
  put_velocity(s, before_ + std::size_t(i) * 6);
  if (!again) return;
  const Real* change = contact_change_ + std::size_t(i) * 6;
  Real* v = velocities_of(s);
  for (int k = 0; k < 6; ++k) v[k] += change[k];
}

// What contacts changed.
[[gnu::always_inline]] inline void SoftStep::end_velocity(std::uint32_t i, const SolverBody& s) {
  const Real *before = before_ + std::size_t(i) * 6, *v = velocities_of(s);
  Real* change = contact_change_ + std::size_t(i) * 6;
  for (int k = 0; k < 6; ++k) change[k] = v[k] - before[k];
}

// Contacts see uneven jointed bodies as they lie now, and so does their warm start.
void SoftStep::renew_contacts(Group& g, const Piece& piece, const SolverInput& in, const StepContext& c) {
  if (g.joints.empty() || g.contacts.empty() || in.jointed.empty()) return;
  bool any = false;
  for (const std::uint32_t i : g.soft_joints->bodies()) {
    JointedBody* j = in.uneven(i);
    if (!j) continue;
    const Quat& rotation = in.solver_bodies->state[i].rotation;
    turned_[i] = turn_seen(*j, rotation, contact_change_ + std::size_t(i) * 6 + 3);
    if (!turned_[i]) continue;
    any = true;
    const Mat3d m = seen_inv_inertia(*j, rotation);
    const double packed[6] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
    for (int k = 0; k < 6; ++k) masses_[i].inv_inertia[k] = static_cast<Real>(packed[k]);
  }
  if (any) g.contacts.renew(turned_, *kernels_, pass(g, piece, in, c));
}

// The velocity from which contacts change it, when what they changed so far is contact_change_.
void SoftStep::begin_from(std::uint32_t i, const SolverBody& s) {
  Real* before = before_ + std::size_t(i) * 6;
  const Real *change = contact_change_ + std::size_t(i) * 6, *v = velocities_of(s);
  for (int k = 0; k < 6; ++k) before[k] = v[k] - change[k];
}

// Drift of an uneven jointed body after contacts: free rotation for h seconds, rad.
Vec3 drift_delta_rotation(JointedBody& j, const SolverBody& s, Real h) {
  j.drift_angular_velocity = s.angular_velocity;
  take_pushes(j, s);
  return rotate_jointed(j, h);
}

// Displacements and poses of listed bodies.
void SoftStep::move(const Group& g, std::uint32_t first, std::uint32_t last, Real h, const SolverInput& in) const {
  SolverBody* state = in.solver_bodies->state.data();
  const std::span<const BodySlide> slides = g.joints.empty() ? std::span<const BodySlide>() : g.soft_joints->slides();
  if (!slides.empty()) {
    each_of(g, first, last, [&](std::uint32_t i) { move_sliding(i, h, slides, in); });
  } else if (split_) {
    each_of(g, first, last, [&](std::uint32_t i) { spin_kernels_.drift({velocities_of(*state), i, i + 1, h}); });
  } else {
    spin_kernels_.drift({velocities_of(*state), std::max(first, 1u), last, h});
  }
  if (first > 0 || g.level == 0) return;
  // kinematic bodies move along, and are put back for the next group
  for (const std::uint32_t i : driven_) spin_kernels_.drift({velocities_of(*state), i, i + 1, h});
}

// `slides`: by trees, which correct positions.
void SoftStep::move_sliding(std::uint32_t i, Real h, std::span<const BodySlide> slides, const SolverInput& in) const {
  FEDER_ASSERT(slides.size() == body_count_);
  SolverBody& s = in.solver_bodies->state[i];
  s.delta_position += h * s.velocity;
  Vec3 rotation = h * s.angular_velocity;
  s.delta_position += h * slides[i].velocity;
  if (JointedBody* j = in.uneven(i)) rotation = drift_delta_rotation(*j, s, h);
  rotation += h * slides[i].angular_velocity;
  if (rotation[0] == 0 && rotation[1] == 0 && rotation[2] == 0) return;
  s.delta_rotation += rotation;
  s.rotation = integrate_rotation(s.rotation, rotation);
}

// Rotation by bias velocities, which the relax pass removed from the velocity.
void SoftStep::report_corrections(const Group& g, const Piece& piece, const SolverInput& in) {
  for (const std::uint32_t i : g.soft_joints->bodies())
    if (JointedBody* j = in.uneven(i))
      j->correction = piece.h * (j->drift_angular_velocity - in.solver_bodies->state[i].angular_velocity);
}

// What impacts change is no part of the warm start of the next substep: `before_` moves along.
void SoftStep::strike(Group& g, const Piece& piece, const SolverInput& in, StepContext& c) {
  SolverBody* state = in.solver_bodies->state.data();
  if (piece.first) each_body(g, c, [&](std::uint32_t i) { end_velocity(i, state[i]); });
  ContactPass p = pass(g, piece, in, c);
  p.struck = struck_;
  std::fill_n(struck_, body_count_, std::uint8_t(0));
  bool acted = false;
  for (int wave = 1; wave <= kStrikeWaves; ++wave) {
    p.wave = static_cast<std::uint8_t>(wave);
    g.contacts.run(kernels_->mark, p, *c.jobs);
    if (!g.contacts.any_strikes(false)) break;
    acted = true;
    for (int round = 0; round < bounce_rounds_; ++round) g.contacts.run(kernels_->strike, p, *c.jobs);
  }
  if (!acted) return;
  each_body(g, c, [&](std::uint32_t i) { begin_from(i, state[i]); });
}

// Impacts on jointed bodies: contact and joints in turn until both hold, before soft rows see either. Contacts alone
// stop the part that hits, and its joints open by what its neighbours move within the substep; joints alone, after it,
// drive it on. Each turn takes energy. As a strike, it is no part of the warm start of the next substep, which would
// throw the part, and what hangs on it, back.
void SoftStep::settle_impacts(Group& g, const Piece& piece, const SolverInput& in, const SolverInput& own,
                              StepContext& c) {
  SolverBody* state = in.solver_bodies->state.data();
  ContactPass p = pass(g, piece, in, c);
  p.all_strike = 1;
  const StruckBodies as_jointed{in, g.soft_joints->shares()};
  for (int turn = 0; turn < kImpactTurns; ++turn) {
    g.contacts.run(kernels_->mark, p, *c.jobs);
    if (!g.contacts.any_strikes(true)) {
      if (turn == 0) return;
      break;
    }
    if (turn == 0) each_body(g, c, [&](std::uint32_t i) { end_velocity(i, state[i]); });
    feder::strike(list_impacts(g.contacts, as_jointed, c), kImpactRounds, g.contacts, as_jointed);
    g.soft_joints->project(own, c);
  }
  each_body(g, c, [&](std::uint32_t i) { begin_from(i, state[i]); });
}

// What `f` changes, by joints, is no part of the warm start of the next substep either.
template <class F>
void SoftStep::keep_out(const Group& g, const SolverInput& in, StepContext& c, F&& f) {
  const std::span<const std::uint32_t> bodies = g.soft_joints->bodies();
  const SolverBody* state = in.solver_bodies->state.data();
  const auto each = [&](const auto& change) {
    if (g.contacts.empty()) return;
    c.jobs->for_blocks(static_cast<std::uint32_t>(bodies.size()), kBodyGrain,
                       [&](std::uint32_t first, std::uint32_t last, int) {
                         for (std::uint32_t n = first; n < last; ++n) change(bodies[n]);
                       });
  };
  each([&](std::uint32_t i) { end_velocity(i, state[i]); });
  f();
  each([&](std::uint32_t i) { begin_from(i, state[i]); });
}

// A warm start that joints do not balance in the pose now, as that of a limb that was caught, throws what it pushes:
// with it and the joints in turn a limb gets hundreds of radians per second. So contacts give up, in turn with the
// joints, what drives their points apart.
void SoftStep::ease_contacts(Group& g, const Piece& piece, const SolverInput& in, const SolverInput& own,
                             StepContext& c) {
  ContactPass p = pass(g, piece, in, c);
  p.jointed = jointed_;
  for (int turn = 0; turn < kEaseTurns; ++turn) {
    g.contacts.run(kernels_->mark_thrown, p, *c.jobs);
    if (!g.contacts.any_strikes(true)) return;
    for (int round = 0; round < kEaseRounds; ++round) g.contacts.run(kernels_->ease, p, *c.jobs);
    keep_out(g, in, c, [&] { g.soft_joints->project(own, c); });
  }
}

void SoftStep::solve_piece(Group& g, const Piece& piece, const SolverInput& in, StepContext& c) {
  if (c.jobs->threads() > 1 && g.joints.empty() && !g.contacts.empty() && !g.contacts.bounces())
    return solve_staged(g, piece, in, c);
  SolverBody* state = in.solver_bodies->state.data();
  if (!piece.first) renew_contacts(g, piece, in, c);
  if (!g.contacts.empty()) each_body(g, c, [&](std::uint32_t i) { start_velocity(i, !piece.first, state[i]); });
  const auto run = [&](void (*kernel)(const ContactPass&)) {
    if (!g.contacts.empty()) g.contacts.run(kernel, pass(g, piece, in, c), *c.jobs);
  };
  if (piece.first) run(kernels_->warm_start);
  if (g.contacts.bounces()) strike(g, piece, in, c);
  const bool jointed = !g.joints.empty();
  const SolverInput own = part(g, in);
  StepContext time = c;
  time.h = piece.h, time.substep = static_cast<int>(piece.k);
  if (jointed) keep_out(g, in, c, [&] { g.soft_joints->solve(own, time); });
  if (jointed && !g.contacts.empty()) {
    ease_contacts(g, piece, in, own, time);
    settle_impacts(g, piece, in, own, time);
  }
  run(kernels_->solve);
  each_block(g, c, [&](std::uint32_t first, std::uint32_t last) { move(g, first, last, piece.h, in); });
  renew_contacts(g, piece, in, c);
  if (jointed) keep_out(g, in, c, [&] { g.soft_joints->relax(own, time); });
  if (jointed && !g.soft_joints->all_direct()) report_corrections(g, piece, in);
  run(kernels_->relax);
  if (relaxes_again(g, piece, c)) {
    ContactPass again = pass(g, piece, in, c);
    again.again = 1;
    g.contacts.run(kernels_->relax, again, *c.jobs, ContactGroup::Which::between_movers);
  }
  if (!g.contacts.empty()) each_body(g, c, [&](std::uint32_t i) { end_velocity(i, state[i]); });
}

// Contacts alone, on several threads: the whole piece is one loop, whose threads stay awake from stage to stage.
void SoftStep::solve_staged(Group& g, const Piece& piece, const SolverInput& in, StepContext& c) {
  SolverBody* state = in.solver_bodies->state.data();
  const ContactPass all = pass(g, piece, in, c);
  const auto over_batches = [](void (*kernel)(const ContactPass&), const ContactPass& pass) {
    return [&pass, kernel](std::uint32_t first, std::uint32_t last, int) {
      ContactPass part = pass;
      part.first = first, part.last = last;
      kernel(part);
    };
  };
  const auto over_bodies = [&](const auto& f) {
    return [&, f](std::uint32_t first, std::uint32_t last, int) { each_of(g, first, last, f); };
  };
  const auto start = over_bodies([&](std::uint32_t i) { start_velocity(i, !piece.first, state[i]); });
  const auto drift = [&](std::uint32_t first, std::uint32_t last, int) { move(g, first, last, piece.h, in); };
  const auto end = over_bodies([&](std::uint32_t i) { end_velocity(i, state[i]); });
  const auto warm_start = over_batches(kernels_->warm_start, all), solve = over_batches(kernels_->solve, all),
             relax = over_batches(kernels_->relax, all);
  const std::uint32_t bodies = listed_bodies(g);
  std::size_t count = 0;
  stages_[count++] = JobPool::stage(0, bodies, kBodyGrain, start);
  if (piece.first) count += g.contacts.stages(warm_start, &stages_[count]);
  count += g.contacts.stages(solve, &stages_[count]);
  stages_[count++] = JobPool::stage(0, bodies, kBodyGrain, drift);
  count += g.contacts.stages(relax, &stages_[count]);
  ContactPass again = all;
  again.again = 1;
  const auto relax_again = over_batches(kernels_->relax, again);
  if (relaxes_again(g, piece, c))
    count += g.contacts.stages(relax_again, &stages_[count], ContactGroup::Which::between_movers);
  stages_[count++] = JobPool::stage(0, bodies, kBodyGrain, end);
  c.jobs->run_stages({stages_, count});
}

// What changed the velocities since the last substep, and the momenta of uneven jointed bodies, comes in equal parts.
void SoftStep::solve_in_pieces(Group& g, const SolverInput& in, StepContext& c) {
  const std::uint32_t count = static_cast<std::uint32_t>(g.pieces());
  const Real share = Real(1) / static_cast<Real>(count), h = share * c.h;
  SolverBody* state = in.solver_bodies->state.data();
  SolverBody* driven = c.scratch->take<SolverBody>(driven_.size());
  for (std::size_t n = 0; n < driven_.size(); ++n) driven[n] = state[driven_[n]];
  Vec3d* given = kept_momentum_ ? c.scratch->take<Vec3d>(body_count_) : nullptr;
  each_body(g, c, [&](std::uint32_t i) {
    Real* kept = kept_ + std::size_t(i) * 6;
    Real* push = push_ + std::size_t(i) * 6;
    put_velocity(state[i], push);
    for (int k = 0; k < 6; ++k) push[k] = share * (push[k] - kept[k]);
    for (int k = 0; k < 3; ++k) state[i].velocity[k] = kept[k], state[i].angular_velocity[k] = kept[k + 3];
    if (const JointedBody* j = in.uneven(i)) given[i] = static_cast<double>(share) * (j->momentum - kept_momentum_[i]);
  });
  const std::uint32_t done = static_cast<std::uint32_t>(c.substep) * count;
  for (std::uint32_t n = 0; n < count; ++n) {
    each_body(g, c, [&](std::uint32_t i) {
      const Real* push = push_ + std::size_t(i) * 6;
      for (int k = 0; k < 3; ++k) state[i].velocity[k] += push[k];
      if (JointedBody* j = in.uneven(i)) {
        if (n > 0) kept_momentum_[i] = carried_momentum(*j, state[i]);
        start_jointed(*j, kept_momentum_[i] + given[i], h, state[i]);
        return;
      }
      for (int k = 0; k < 3; ++k) state[i].angular_velocity[k] += push[k + 3];
    });
    solve_piece(g, {h, done + n == 0, done + n}, in, c);
  }
  for (std::size_t n = 0; n < driven_.size(); ++n) state[driven_[n]] = driven[n];
  each_body(g, c, [&](std::uint32_t i) {
    put_velocity(state[i], kept_ + std::size_t(i) * 6);
    if (const JointedBody* j = in.uneven(i)) kept_momentum_[i] = carried_momentum(*j, state[i]);
  });
}

void SoftStep::solve(const SolverInput& in, StepContext& c) {
  for (int level = 1; level < kLevels && split_; ++level)
    if (groups_[level].used()) solve_in_pieces(groups_[level], in, c);
  const std::uint32_t k = static_cast<std::uint32_t>(c.substep);
  solve_piece(groups_[0], {c.h, k == 0, k}, in, c);
}

void SoftStep::finish(const SolverInput& in, StepContext& c) {
  FEDER_ASSERT(in.contacts->active.size() == contact_count_);
  for (Group& g : groups_) {
    if (!g.used()) continue;
    g.contacts.store(*in.contacts, *c.jobs);
    if (g.joints.empty()) continue;
    g.soft_joints->finish(part(g, in), c);
    if (g.level > 0) scale_impulses(g, in, static_cast<Real>(g.pieces()));
  }
}

}  // namespace

Variant<RigidSolver> rigid_soft_step() {
  return {"soft_step", "substepped soft constraints with relaxation; eight contacts at a time",
          [](Arena& arena, const Params& p) -> std::unique_ptr<RigidSolver> {
            return std::make_unique<SoftStep>(arena, p);
          }};
}

}  // namespace feder
