#include "rigid/joint_impacts.h"

#include <algorithm>

#include "rigid/jointed_body.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "state/solver_bodies.h"

namespace feder {
namespace {

constexpr Real kSlowest = Real(1e-6);  // m/s across the normal: slower does not rub

// Change of the angular velocity by an angular impulse.
Vec3 turned_by(const StruckBodies& in, std::uint32_t i, const Vec3& moment) {
  const JointedBody* j = in.input.uneven(i);
  return j ? jointed_response(*j, moment) : Vec3(in.share[i] * (in.input.solver_bodies->mass[i].inv_inertia * moment));
}

Vec3 velocity_at(const SolverBody& s, const Vec3& arm) { return s.velocity + cross(s.angular_velocity, arm); }

// Of a point along `n`, unit, kg; 0 where nothing moves.
Real mass_along(const PointImpact& p, const Vec3& n, const StruckBodies& in) {
  Real inverse = 0;
  for (const bool first : {true, false}) {
    const std::uint32_t i = first ? p.index_a : p.index_b;
    const Vec3& arm = first ? p.arm_a : p.arm_b;
    const Vec3 moment = cross(arm, n);
    inverse +=
        dot(n.cwiseProduct(in.input.solver_bodies->mass[i].inv_mass_axes), n) + dot(turned_by(in, i, moment), moment);
  }
  return inverse > 0 ? 1 / inverse : Real(0);
}

void push_side(const StruckBodies& in, std::uint32_t i, const Vec3& arm, const Vec3& impulse) {
  if (i == 0) return;
  SolverBody& s = in.input.solver_bodies->state[i];
  s.velocity += in.input.solver_bodies->mass[i].inv_mass_axes.cwiseProduct(impulse);
  const Vec3 moment = cross(arm, impulse);
  if (JointedBody* j = in.input.uneven(i))
    push_jointed(*j, moment.cast<double>(), s);
  else
    s.angular_velocity += turned_by(in, i, moment);
}

void push_both(const StruckBodies& in, const PointImpact& p, const Vec3& impulse) {
  push_side(in, p.index_a, p.arm_a, -impulse);
  push_side(in, p.index_b, p.arm_b, impulse);
}

Vec3 speed_of(const StruckBodies& in, const PointImpact& p) {
  const SolverBody *a = &in.input.solver_bodies->state[p.index_a], *b = &in.input.solver_bodies->state[p.index_b];
  return velocity_at(*b, p.arm_b) - velocity_at(*a, p.arm_a);
}

}  // namespace

std::span<PointImpact> list_impacts(const ContactGroup& contacts, const StruckBodies& in, StepContext& c) {
  std::size_t count = 0;
  contacts.each_strike([&](const ContactGroup::Place&) { ++count; });
  PointImpact* list = c.scratch->take<PointImpact>(count);
  std::size_t at = 0;
  contacts.each_strike([&](const ContactGroup::Place& place) {
    const Contact& contact = in.input.contacts->slots[place.slot];
    PointImpact& p = list[at++];
    p = {place,
         contact.normal,
         contact.points[place.point].arm_a,
         contact.points[place.point].arm_b,
         in.input.solver_index(contact.collider_a),
         in.input.solver_index(contact.collider_b),
         0,
         contact.friction_dynamic,
         0,
         0};
    p.mass = mass_along(p, p.normal, in);
  });
  return {list, count};
}

void strike(std::span<PointImpact> impacts, int rounds, ContactGroup& contacts, const StruckBodies& in) {
  for (int round = 0; round < rounds; ++round)
    for (PointImpact& p : impacts) {
      const Real wanted = std::max(p.impulse - p.mass * dot(speed_of(in, p), p.normal), Real(0));
      push_both(in, p, (wanted - p.impulse) * p.normal);
      p.impulse = wanted;
      const Vec3 v = speed_of(in, p), across = v - dot(v, p.normal) * p.normal;
      const Real speed = length(across), left = p.friction * p.impulse - p.rubbed;
      if (!(speed > kSlowest && left > 0)) continue;
      const Vec3 along = across / speed;
      const Real rub = std::min(mass_along(p, along, in) * speed, left);
      push_both(in, p, -rub * along);
      p.rubbed += rub;
    }
  for (const PointImpact& p : impacts) contacts.note_strike(p.at, p.impulse);
}

}  // namespace feder
