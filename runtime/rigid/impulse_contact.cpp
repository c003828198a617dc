// One contact of the impulse solver. A point is solved by the closed form of collision response with friction
// (Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, ch. 3; Millington, "Game Physics Engine
// Development", 2nd ed., ch. 15): with K = the relative velocity per impulse, the impulse K^-1 (wanted - v) stops the
// point fully; inside the friction cone it is used as it is, outside the impulse is p (n + mu d), d against the slip,
// with p from the wanted normal speed. A manifold's points are swept until they agree, so that a face that lands flat
// rises flat. Whether mu is static or dynamic is decided for the manifold as a whole and once the speeds are solved
// with the static one, because intermediate impulses leave the cone of contacts that will stick in the end. Impacts
// faster than the rest speed bounce: their impulse is final and acts at the moment of contact inside the substep, which
// makes a bounce between free flights exact. Slower contacts are resting: no restitution.
// Kept between substeps: the impulses of resting contacts. Weak spot: friction impulses are kept between steps as one
// sum per manifold.
#include <algorithm>

#include "rigid/impulse_parts.h"

namespace feder {
namespace {

constexpr int kSweeps = 40;  // of the points of one manifold; four corners agree to 1e-6 in about fifteen

Vec3 point_velocity(const ImpulseContact& c, const ImpulsePoint& p, const ImpulseScene& s) {
  const SolverBody &a = s.state[c.a], &b = s.state[c.b];
  return b.velocity + cross(b.angular_velocity, p.arm_b) - a.velocity - cross(a.angular_velocity, p.arm_a);
}

// Adds the inverse mass of solver body i at the arm r to K: M^-1 - [r] I^-1 [r].
void add_inverse_mass(const ImpulseScene& s, std::uint32_t i, const Vec3& arm, Mat3& k) {
  if (!s.body[i].movable) return;
  FEDER_ASSERT(i != 0);
  const Mat3 r = skew(arm);
  k -= r * s.body[i].inv_inertia * r;
  for (int axis = 0; axis < 3; ++axis) k(axis, axis) += s.mass[i].inv_mass_axes[axis];
}

// The inverse of K; an axis along which nothing can move (planar worlds) answers with no impulse.
Mat3 inverse_response(const Mat3& k) {
  Mat3 m = k;
  const Real size = k.trace();
  for (int axis = 0; axis < 3; ++axis)
    if (!(m(axis, axis) > kEpsilon * size)) m(axis, axis) = size;
  return inverse(m);
}

// The accumulated impulse that this point would have for the relative velocity `v` (surface velocity taken off).
Vec3 wanted_impulse(const ImpulseContact& c, const ImpulsePoint& p, const Vec3& v) {
  const Vec3& n = c.normal;
  const Real speed = dot(n, v);
  const Vec3 response = p.k * n;
  const Real k_normal = dot(n, response);
  if (!(k_normal > 0)) return Vec3::Zero();
  // normal speed that is missing when this point has no impulse at all
  const Real missing = p.target - speed + dot(response, p.impulse);
  const Real mu = c.slides ? c.friction_dynamic : c.friction_static;
  if (mu <= 0) return n * std::max(missing / k_normal, Real(0));

  // inside the cone: the full stop
  const Vec3 stop = p.impulse + p.k_inverse * (p.target * n - v);
  const Real stop_normal = dot(n, stop);
  const Vec3 stop_tangent = stop - stop_normal * n;
  if (stop_normal >= 0 && length(stop_tangent) <= mu * stop_normal) return stop;

  // outside: against the slip, or a stop when less than full friction already stops it
  const Vec3 slip = v - speed * n;
  const Real soft = 2 / (p.k.trace() - k_normal);
  const Vec3 along = p.impulse - dot(n, p.impulse) * n - soft * slip;
  const Real along_size = length(along);
  const Vec3 d = normalized_or(along, Vec3::Zero());
  Real k_slide = k_normal + mu * dot(response, d);
  if (k_slide < Real(0.05) * k_normal) k_slide = k_normal;  // a jam (Painleve): friction that would need its own push
  const Real push = missing / k_slide;
  if (!(push > 0)) return Vec3::Zero();
  if (mu * push <= along_size) return push * (n + mu * d);
  const Real stop_push = (missing - dot(response, along)) / k_normal;
  if (!(stop_push > 0)) return Vec3::Zero();
  return stop_push * n + d * std::min(along_size, mu * stop_push);
}

Vec3 wanted_rolling(const ImpulseContact& c, const ImpulseScene& s) {
  Real pressure = 0;
  for (int i = 0; i < c.count; ++i) pressure += dot(c.normal, c.points[i].impulse) + c.points[i].bounced;
  const Real limit = c.rolling_friction * std::max(pressure, Real(0));
  const Vec3 relative = s.state[c.b].angular_velocity - s.state[c.a].angular_velocity;
  const Vec3 roll = relative - dot(relative, c.normal) * c.normal;
  Vec3 wanted = c.rolling;
  const Vec3 axis = normalized_or(roll, Vec3::Zero());
  const Real k = dot(axis, s.body[c.a].inv_inertia * axis) + dot(axis, s.body[c.b].inv_inertia * axis);
  if (k > 0) wanted -= roll / k;
  const Real size = length(wanted);
  return size > limit ? Vec3(wanted * (limit / size)) : wanted;
}

void push_point(const ImpulseContact& c, const ImpulsePoint& p, const Vec3& impulse, const ImpulseScene& s) {
  push(s, c.a, -impulse, -cross(p.arm_a, impulse));
  push(s, c.b, impulse, cross(p.arm_b, impulse));
}

void push_rolling(const ImpulseContact& c, const Vec3& impulse, const ImpulseScene& s) {
  push(s, c.a, Vec3::Zero(), -impulse);
  push(s, c.b, Vec3::Zero(), impulse);
}

Real rolling_arm(const ImpulseContact& c) { return std::max(length(c.points[0].arm_a), length(c.points[0].arm_b)); }

// Rounding error of the relative velocity, m/s: smaller errors are not real.
Real rounding(const ImpulseContact& c, const ImpulsePoint& p, const ImpulseScene& s) {
  const SolverBody &a = s.state[c.a], &b = s.state[c.b];
  return 4 * kEpsilon *
         (length(a.velocity) + length(b.velocity) + length(a.angular_velocity) * length(p.arm_a) +
          length(b.angular_velocity) * length(p.arm_b));
}

// Mean slip of the points, weighted by their normal impulse, and the slip that full static friction stops in a substep,
// m/s.
struct Slip {
  Real speed, limit;
};

Slip slip_of(const ImpulseContact& c, const ImpulseScene& s) {
  Real pressure = 0, sum = 0;
  for (int i = 0; i < c.count; ++i) {
    const ImpulsePoint& p = c.points[i];
    const Real push = std::max(dot(c.normal, p.impulse) + p.bounced, Real(0));
    const Vec3 v = point_velocity(c, p, s) - c.surface_velocity;
    pressure += push;
    sum += push * length(Vec3(v - dot(c.normal, v) * c.normal));
  }
  Real inv_mass = 0;
  for (const std::uint32_t i : {c.a, c.b})
    if (s.body[i].movable) inv_mass += s.mass[i].inv_mass;
  return {pressure > 0 ? sum / pressure : Real(0), c.friction_static * pressure * inv_mass};
}

// Target normal speed of a resting point: it may close the gap that is left.
Real resting_target(const ImpulsePoint& p, const ImpulseScene& s) { return -std::max(p.separation, Real(0)) / s.h; }

// Impacts: sets the targets of points that hit faster than the rest speed. Returns whether there are any, and in
// `impact_time` the time from the start of the substep to the fastest of them.
//
// Velocities are those of the leapfrog scheme: with the acceleration a, closing speed u after the kick, the speed at
// the start of the substep is u - a h/2. Contact at t from s = (u - a h/2) t + a t^2/2 with speed U; after it
// e U - a (h - t) at the end of the substep, stored with a h/2 added.
bool find_impacts(ImpulseContact& c, const ImpulseScene& s, Real& impact_time) {
  Real fastest = 0;
  for (int i = 0; i < c.count; ++i) {
    ImpulsePoint& p = c.points[i];
    const Real closing = -dot(c.normal, point_velocity(c, p, s));
    if (closing - p.force_speed <= s.rest_speed || p.separation - s.h * closing >= 0) continue;
    const Real gap = std::max(p.separation, Real(0)), accel = p.force_speed / s.h;
    const Real start = closing - p.force_speed / 2;
    const Real t = std::min(s.h, 2 * gap / (start + std::sqrt(start * start + 2 * accel * gap)));
    const Real rebound = c.restitution * (start + accel * t) - accel * (s.h - t);
    if (rebound <= 0) continue;
    p.target = rebound + p.force_speed / 2;
    if (closing > fastest) fastest = closing, impact_time = t;
  }
  return fastest > 0;
}

void sweep_points(ImpulseContact& c, const ImpulseScene& s, Real tolerance) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    Real change = 0;
    for (int i = 0; i < c.count; ++i) {
      ImpulsePoint& p = c.points[i];
      const Vec3 wanted = wanted_impulse(c, p, point_velocity(c, p, s) - c.surface_velocity);
      const Vec3 delta = wanted - p.impulse;
      p.impulse = wanted;
      push_point(c, p, delta, s);
      change = std::max(change, length(p.k * delta) - rounding(c, p, s));
    }
    if (c.rolling_friction > 0) {
      const Vec3 wanted = wanted_rolling(c, s);
      const Vec3 relative = s.state[c.b].angular_velocity - s.state[c.a].angular_velocity;
      push_rolling(c, wanted - c.rolling, s);
      c.rolling = wanted;
      const Vec3 angular_velocity_change = s.state[c.b].angular_velocity - s.state[c.a].angular_velocity - relative;
      change = std::max(change, length(angular_velocity_change) * rolling_arm(c) - rounding(c, c.points[0], s));
    }
    if (change <= tolerance) return;
  }
}

// Makes the impulses of an impact final.
void settle(ImpulseContact& c, const ImpulseScene& s) {
  for (int i = 0; i < c.count; ++i) {
    ImpulsePoint& p = c.points[i];
    p.bounced += dot(c.normal, p.impulse);
    p.impulse = Vec3::Zero();
    p.target = resting_target(p, s);
    p.force_speed = 0;
  }
  c.rolling = Vec3::Zero();
}

// An impact at the time t acts for h - t only: the travel with the new velocity before t is subtracted. Only against
// immovable partners, since between two solver bodies it would not conserve angular momentum.
void remove_early_travel(std::uint32_t i, const SolverBody& before, Real impact_time, const ImpulseScene& s) {
  s.body[i].impact_delta_position -= impact_time * (s.state[i].velocity - before.velocity);
  s.body[i].impact_delta_rotation -= impact_time * (s.state[i].angular_velocity - before.angular_velocity);
}

// Separation to first order in the rotations, with arms and normal of the start of the step: the contact point of a
// rolling ball stays where it was.
Real separation_now(const ImpulseContact& c, const ImpulsePoint& p, const ImpulseScene& s) {
  const SolverBody &a = s.state[c.a], &b = s.state[c.b];
  return p.start_separation + dot(c.normal, b.delta_position + cross(b.delta_rotation, p.arm_b) - a.delta_position -
                                                cross(a.delta_rotation, p.arm_a));
}

}  // namespace

void load_contact(const Contact& from, const ImpulseScene& s, ImpulseContact& c) {
  FEDER_ASSERT(from.touching && from.point_count >= 1 && from.point_count <= kMaxContactPoints);
  c.count = from.point_count;
  c.normal = from.normal;
  c.surface_velocity = from.surface_velocity;
  c.friction_static = std::max(from.friction_static, from.friction_dynamic);
  c.friction_dynamic = from.friction_dynamic;
  c.restitution = from.restitution;
  c.rolling_friction = from.rolling_friction;
  c.rolling = from.rolling_impulse;
  Vec3 t1, t2;
  tangent_frame(c.normal, t1, t2);
  Real pressure = 0;
  for (int i = 0; i < c.count; ++i) pressure += from.points[i].normal_impulse;
  const Vec3 friction = from.tangent_impulse[0] * t1 + from.tangent_impulse[1] * t2;
  for (int i = 0; i < c.count; ++i) {
    ImpulsePoint& p = c.points[i];
    p = ImpulsePoint{};
    p.arm_a = from.points[i].arm_a;
    p.arm_b = from.points[i].arm_b;
    add_inverse_mass(s, c.a, p.arm_a, p.k);
    add_inverse_mass(s, c.b, p.arm_b, p.k);
    p.k_inverse = inverse_response(p.k);
    p.start_separation = from.points[i].separation;
    const Real push = from.points[i].normal_impulse;
    if (push > 0) p.impulse = push * c.normal + (push / pressure) * friction;
  }
}

void store_contact(const ImpulseContact& c, Contact& to) {
  Vec3 t1, t2, sum = Vec3::Zero();
  tangent_frame(c.normal, t1, t2);
  for (int i = 0; i < c.count; ++i) {
    to.points[i].normal_impulse = dot(c.normal, c.points[i].impulse);
    sum += c.points[i].impulse;
  }
  to.tangent_impulse[0] = dot(t1, sum);
  to.tangent_impulse[1] = dot(t2, sum);
  to.twist_impulse = 0;
  to.rolling_impulse = c.rolling;
}

void start_contact(ImpulseContact& c, const ImpulseScene& s) {
  const ImpulseBody &a = s.body[c.a], &b = s.body[c.b];
  c.slides = false;
  for (int i = 0; i < c.count; ++i) {
    ImpulsePoint& p = c.points[i];
    p.separation = separation_now(c, p, s);
    p.target = resting_target(p, s);
    const Vec3 gained = b.force_velocity + cross(b.force_angular_velocity, p.arm_b) - a.force_velocity -
                        cross(a.force_angular_velocity, p.arm_a);
    p.force_speed = std::max(-dot(c.normal, gained), Real(0));
    p.bounced = 0;
    push_point(c, p, p.impulse, s);
  }
  push_rolling(c, c.rolling, s);
}

Real contact_speed_error(const ImpulseContact& c, const ImpulseScene& s) {
  Real worst = 0;
  for (int i = 0; i < c.count; ++i) {
    const ImpulsePoint& p = c.points[i];
    const Vec3 delta = wanted_impulse(c, p, point_velocity(c, p, s) - c.surface_velocity) - p.impulse;
    worst = std::max(worst, length(p.k * delta) - rounding(c, p, s));
  }
  if (c.rolling_friction > 0) {
    const Vec3 delta = wanted_rolling(c, s) - c.rolling;
    const Vec3 angular_velocity_change = s.body[c.a].inv_inertia * delta + s.body[c.b].inv_inertia * delta;
    worst = std::max(worst, length(angular_velocity_change) * rolling_arm(c) - rounding(c, c.points[0], s));
  }
  return worst;
}

void solve_contact_speed(ImpulseContact& c, const ImpulseScene& s, Real tolerance) {
  FEDER_ASSERT(s.body[c.a].movable || s.body[c.b].movable);
  Real impact_time = 0;
  if (!(c.restitution > 0) || !find_impacts(c, s, impact_time)) return sweep_points(c, s, tolerance);
  // targets of an impact are for the impulses from here on
  for (int i = 0; i < c.count; ++i) {
    c.points[i].bounced += dot(c.normal, c.points[i].impulse);
    c.points[i].impulse = Vec3::Zero();
  }
  c.rolling = Vec3::Zero();
  const SolverBody before_a = s.state[c.a], before_b = s.state[c.b];
  sweep_points(c, s, tolerance);
  if (begins_to_slide(c, s)) {
    c.slides = true;
    sweep_points(c, s, tolerance);
  }
  if (!s.body[c.a].movable) remove_early_travel(c.b, before_b, impact_time, s);
  if (!s.body[c.b].movable) remove_early_travel(c.a, before_a, impact_time, s);
  settle(c, s);
}

// Slip below the limit is an error of the iteration: static friction removes it in the next substep.
bool begins_to_slide(const ImpulseContact& c, const ImpulseScene& s) {
  if (c.slides || !(c.friction_dynamic < c.friction_static)) return false;
  const Slip slip = slip_of(c, s);
  return slip.speed > slip.limit;
}

Real contact_depth(const ImpulseContact& c, const ImpulseScene& s) {
  Real deepest = 0;
  for (int i = 0; i < c.count; ++i) deepest = std::max(deepest, -separation_now(c, c.points[i], s) - s.slop);
  return deepest;
}

void push_contact_apart(const ImpulseContact& c, const ImpulseScene& s) {
  int deepest = 0;
  Real depth = -kInfinity;
  for (int i = 0; i < c.count; ++i) {
    const Real d = -separation_now(c, c.points[i], s) - s.slop;
    if (d > depth) depth = d, deepest = i;
  }
  const ImpulsePoint& p = c.points[deepest];
  const Real k = dot(c.normal, p.k * c.normal);
  if (!(depth > 0) || !(k > 0)) return;
  const Vec3 move = (depth / k) * c.normal;
  shift(s, c.a, -move, -cross(p.arm_a, move));
  shift(s, c.b, move, cross(p.arm_b, move));
}

}  // namespace feder
