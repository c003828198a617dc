// Continuous collision: a body that would pass through something in this step stops at its time of impact. It keeps its
// velocity, so that the contact of the next step sees the blow; what is left of its way is lost. Between the last solve
// of a step and its commit. Bodies that move by less than the depth of their core cannot pass anything and are not
// looked at. Fixed bodies and kinematic ones at rest stop all, moving ones only bullets.
// Source: time of impact as in narrow/impact.h; the way is searched in pieces, so that its cost is what lies near it.
// Two moving bodies meet by their contact, which looks ahead (collide/obstacles.cpp). Weak spot: that takes them to
// move as they do when the step begins; a bullet that stops is pushed along by the rest of the other's way; parts of a
// body outside its core may rotate through a thin wall.
#include <algorithm>

#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kPieceExtents = 8;               // length of a piece, of the body's extent
constexpr int kMostPieces = 64;                 // longer pieces beyond
constexpr Real kRound = Real(1.001);            // an extent over the half width up to here: a ball
constexpr std::uint32_t kMostObstacles = 2048;  // in a step, of one body

Pose at_time(const OwnerMotion& m, Real t) {
  return {m.from.position + t * m.shift, integrate_rotation(m.from.rotation, t * m.turn)};
}

}  // namespace

OwnerMotion Rigid::Impl::motion_in_step(std::uint32_t i) const {
  const std::uint32_t n = solver_bodies.at(bodies.solver_slot[i]);
  if (n == 0) return {bodies.com_pose(i)};
  const SolverBody& s = solver_bodies.state[n];
  return {{solver_bodies.mass[n].center, solver_bodies.mass[n].start_rotation}, s.delta_position, s.delta_rotation};
}

// May the core of the body moving[p] have passed through something?
bool Rigid::Impl::is_fast(std::uint32_t p) const {
  const std::uint32_t i = moving[p];
  if (bodies.type[i] != BodyType::dynamic) return false;
  const SolverBody& s = solver_bodies.state[p + 1];
  const Real depth = core_depth[i], extent = bodies.extent[i];
  const bool ball = extent * kCoreDepth < depth * kRound;  // rotation moves nothing
  const Real shift = dot(s.delta_position, s.delta_position);
  const Real turn = ball ? 0 : extent * extent * dot(s.delta_rotation, s.delta_rotation);
  return 2 * (shift + turn) > depth * depth && std::sqrt(shift) + std::sqrt(turn) > depth;
}

// Looks for what collider `k` of the body meets from `begin` to `end`; keeps the earliest.
void Rigid::Impl::sweep_collider(std::uint32_t i, std::uint32_t k, const OwnerMotion& motion, Real begin, Real end,
                                 Array<std::uint32_t>& found, FastStop& stop) {
  // where it may be at any rotation: most have nothing there
  Aabb around;
  for (const Real t : {begin, end}) around.include(motion.from.position + t * motion.shift);
  around.grow(bodies.extent[i] + kContactMargin);
  collide.obstacles(k, around, bodies.bullet[i] != 0, found);
  if (found.empty()) return;
  const Pose from = at_time(motion, begin) * colliders.local[k], to = at_time(motion, end) * colliders.local[k];
  Aabb box = colliders.shape[k]->bounds(from);
  box.include(colliders.shape[k]->bounds(to));
  const Real arc = std::min(length(motion.turn) * (end - begin), Real(2)) * bodies.extent[i];
  box.grow(arc + kContactMargin);
  const auto off = [&](std::uint32_t other) { return !overlaps(colliders.box[other], box); };
  found.erase(std::remove_if(found.begin(), found.end(), off), found.end());
  stop.obstacles += static_cast<std::uint32_t>(found.size());
  if (stop.obstacles > kMostObstacles) {
    stop.time = begin, stop.other = kNone;
    return;
  }
  for (const std::uint32_t other : found) {
    const std::uint32_t j = colliders.owner_index[other];
    const OwnerImpact hit = collide.impact(k, motion, other, motion_in_step(j), begin, std::min(end, stop.time));
    if (!(hit.time < stop.time)) continue;
    stop.time = hit.time, stop.other = j;
    stop.normal = hit.normal, stop.point = hit.point, stop.inside = hit.inside;
  }
}

FastStop Rigid::Impl::find_stop(std::uint32_t p, Array<std::uint32_t>& found) {
  FastStop stop;
  const std::uint32_t i = moving[p];
  const OwnerMotion motion = motion_in_step(i);
  const Real way = length(motion.shift), piece = kPieceExtents * bodies.extent[i];
  if (!is_finite(way + length(motion.turn))) return stop;
  const int pieces = way > piece * kMostPieces ? kMostPieces : std::max(1, static_cast<int>(std::ceil(way / piece)));
  for (int n = 0; n < pieces && stop.time > 1; ++n)
    each_collider(i, [&](std::uint32_t k) {
      if (!colliders.sensor[k] && !colliders.meets_nothing(k) && stop.obstacles <= kMostObstacles)
        sweep_collider(i, k, motion, Real(n) / Real(pieces), Real(n + 1) / Real(pieces), found, stop);
    });
  return stop;
}

void Rigid::Impl::apply_stop(std::uint32_t p, const FastStop& stop, const OwnerMotion& other) {
  const std::uint32_t i = moving[p];
  SolverBody& s = solver_bodies.state[p + 1];
  if (stop.obstacles > kMostObstacles && !sweep_warned) {
    sweep_warned = true;
    events.warn("sweep_limit",
                objects.describe(bodies.object[i]) + " passed more than " + std::to_string(kMostObstacles) +
                    " parts of bodies in a step, " + std::to_string(static_cast<long long>(length(s.delta_position))) +
                    " m: it stops early. Make it slower, dt shorter, or use fewer and larger parts",
                bodies.object[i]);
  }
  const OwnerMotion motion = motion_in_step(i);
  const Pose pose = at_time(motion, stop.time);
  s.delta_position = stop.time * motion.shift;
  s.delta_rotation = stop.time * motion.turn;
  s.rotation = pose.rotation;
  if (stop.other == kNone) return;
  // a spin of many turns a step is more than contacts see: scenery takes what they should have
  if (const std::uint32_t o = stop.other; stop.inside && bodies.type[o] != BodyType::dynamic) {
    const Vec3 scenery = bodies.velocity[o] + cross(bodies.angular_velocity[o], stop.point - bodies.position[o]);
    s.velocity -= std::max(dot(s.velocity - scenery, stop.normal), Real(0)) * stop.normal;
  }
  // what pushes on takes it along
  const Vec3 rest =
      (1 - stop.time) * (other.shift + cross(other.turn, stop.point - at_time(other, stop.time).position));
  const Real along = dot(rest, stop.normal);
  if (along < 0) s.delta_position += along * stop.normal;
}

// A body that stops would open its joints by the rest of its neighbours' way: fast bodies on joints stop at one time.
void Rigid::Impl::stop_together() {
  const auto count = static_cast<std::uint32_t>(fast.size());
  fast_groups.reset(count);
  const auto place = [&](std::uint32_t i) {  // in `fast`, or kNone
    const std::uint32_t n = bodies.moves(i) ? solver_bodies.at(bodies.solver_slot[i]) : 0;
    if (n == 0 || !fast_marks[n - 1]) return kNone;
    return static_cast<std::uint32_t>(std::lower_bound(fast.begin(), fast.end(), n - 1) - fast.begin());
  };
  for (const std::uint32_t j : active_joints) {
    const std::uint32_t a = place(records[j].body_a), b = place(records[j].body_b);
    if (a != kNone && b != kNone) fast_groups.join(a, b);
  }
  for (std::uint32_t n = 0; n < count; ++n) {  // a root is the first of its group
    FastStop& first = stops[fast_groups.root(n)];
    first.group_time = std::min(first.group_time, stops[n].time);
  }
  for (std::uint32_t n = 0; n < count; ++n) {
    const Real time = stops[fast_groups.root(n)].group_time;
    if (time < stops[n].time) stops[n].time = time, stops[n].other = kNone;
  }
}

void Rigid::Impl::list_fast(StepContext& c) {
  const auto count = static_cast<std::uint32_t>(moving.size());
  constexpr JobGrain kGrain{512, 5'000};  // bodies
  fast_marks.resize(count);
  c.jobs->for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t p = first; p < last; ++p) fast_marks[p] = !bad[p] && is_fast(p);
  });
  fast.clear();
  for (std::uint32_t p = 0; p < count; ++p)
    if (fast_marks[p]) fast.push_back(p);
}

void Rigid::Impl::stop_fast(StepContext& c) {
  list_fast(c);
  const auto count = static_cast<std::uint32_t>(fast.size());
  stops.resize(count);
  while (stop_scratch.size() < static_cast<std::size_t>(c.jobs->threads())) stop_scratch.emplace_back(&arena);
  constexpr JobGrain kGrain{16, 20'000};  // bodies
  c.jobs->for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int worker) {
    for (std::uint32_t n = first; n < last; ++n)
      stops[n] = find_stop(fast[n], stop_scratch[static_cast<std::size_t>(worker)]);
  });
  const auto stopped = [](const FastStop& s) { return s.time <= 1; };
  if (joint_count > 0 && std::any_of(stops.begin(), stops.end(), stopped)) stop_together();
  // all motions are still whole
  stop_motions.clear();
  for (const FastStop& stop : stops)
    if (stopped(stop)) stop_motions.push_back(stop.other == kNone ? OwnerMotion{} : motion_in_step(stop.other));
  std::size_t next = 0;
  for (std::uint32_t n = 0; n < count; ++n)
    if (stopped(stops[n])) apply_stop(fast[n], stops[n], stop_motions[next++]);
  stops_slack.clear(stops);
}

}  // namespace feder
