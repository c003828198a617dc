// Sleep. Each body keeps an exponential average of its kinetic energy per mass, capped so that it falls below the lower
// threshold about half a second after the body has come to rest; two thresholds are a hysteresis. Islands are found by
// union-find over active contacts and joints, only when there is a sleep candidate; an island sleeps when all its
// members are candidates and none is in contact with a moving kinematic body. A thrown body is no candidate at its
// apex, because the average includes the flight. The lower threshold is the body's (sleep_threshold), the upper one
// twice that speed. Sleeping islands are rings through next_in_island; waking one member
// wakes all. Kept between steps: averages, candidates, rings. Weak spot: a body that creeps below its threshold falls
// asleep.
#include <algorithm>
#include <iterator>
#include <tuple>

#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kRestless = 4;         // the upper threshold over the lower one, of energies
constexpr Real kCap = 25;             // decays to 1 in log(25) = 3.2 time constants
constexpr Real kMemory = Real(0.15);  // s, time constant

// Energy per mass of the speed below which a body falls asleep, m^2/s^2.
Real sleep_energy(const Bodies& b, std::uint32_t i) { return Real(0.5) * b.sleep_threshold[i] * b.sleep_threshold[i]; }

}  // namespace

void Rigid::Impl::wake_one(std::uint32_t i, WakeCause cause, ObjectId other) {
  if (bodies.awake[i] || bodies.type[i] != BodyType::dynamic) return;
  bodies.awake[i] = 1;
  bodies.sleep_energy[i] = kCap * sleep_energy(bodies, i);
  bodies.island[i] = kNone;
  sleep_candidate[i] = 0;
  each_collider(i, [&](std::uint32_t k) { colliders.set_awake(k, true); });
  list_stale = true;
  if (cause == WakeCause::none) return;  // newly made
  Event e;
  e.kind = EventKind::wake;
  e.cause = cause;
  e.a = bodies.object[i];
  e.b = other;
  events.add_pending(e);
}

void Rigid::Impl::wake(std::uint32_t i, WakeCause cause, ObjectId other) {
  if (bodies.type[i] != BodyType::dynamic) return;
  if (bodies.awake[i]) {
    bodies.sleep_energy[i] = kCap * sleep_energy(bodies, i);
    sleep_candidate[i] = 0;
    return;
  }
  FEDER_ASSERT(sleeping_count > 0 && next_in_island[i] != kNone);
  std::uint32_t next = next_in_island[i];
  next_in_island[i] = kNone;
  wake_one(i, cause, other);
  --sleeping_count;
  while (next != kNone && next != i) {
    const std::uint32_t k = next;
    next = next_in_island[k];
    FEDER_ASSERT(next != kNone && bodies.type[k] == BodyType::dynamic && !bodies.awake[k]);
    next_in_island[k] = kNone;
    wake_one(k, WakeCause::neighbor, bodies.object[i]);
    --sleeping_count;
  }
}

// Wakes sleepers that came into contact with something awake.
void Rigid::Impl::wake_touched(StepContext&) {
  const auto asleep = [&](std::uint32_t k) {
    return colliders.owner[k] == ColliderOwner::body && colliders.motion[k] == ColliderMotion::dynamic &&
           !colliders.awake[k];
  };
  for (const ColliderPair& t : contacts.arrivals) {
    std::uint32_t sleeper = t.b, other = t.a;
    if (!colliders.awake[other] || !asleep(sleeper)) std::swap(sleeper, other);
    if (colliders.awake[other] && asleep(sleeper))
      wake(colliders.owner_index[sleeper], WakeCause::contact, colliders.object[other]);
  }
}

// Wakes sleepers in contact with body i, and those joined to it.
void Rigid::Impl::wake_touching(std::uint32_t i, WakeCause cause) {
  if (sleeping_count == 0) return;
  const auto touches = [&](std::uint32_t slot) {
    const Contact& contact = contacts.slots[slot];
    return contact.point_count > 0 &&
           (colliders.body_of(contact.collider_a) == i || colliders.body_of(contact.collider_b) == i);
  };
  // its contacts, in their order
  touching.clear();
  std::copy_if(contacts.order.begin(), contacts.order.end(), std::back_inserter(touching), touches);
  each_collider(i, [&](std::uint32_t k) {
    contacts.resting.each_of(k, [&](std::uint32_t pair) {
      for (const std::uint32_t slot : contacts.resting.pairs[pair].contact)
        if (slot != kNone && touches(slot)) touching.push_back(slot);
    });
  });
  std::sort(touching.begin(), touching.end(), [&](std::uint32_t x, std::uint32_t y) {
    const Contact &p = contacts.slots[x], &q = contacts.slots[y];
    return std::tie(p.collider_a, p.collider_b, p.sub) < std::tie(q.collider_a, q.collider_b, q.sub);
  });
  for (const std::uint32_t slot : touching) {
    const std::uint32_t a = colliders.body_of(contacts.slots[slot].collider_a);
    const std::uint32_t other = a == i ? colliders.body_of(contacts.slots[slot].collider_b) : a;
    if (other != kNone && !bodies.awake[other]) wake(other, cause, bodies.object[i]);
  }
  for (const JointRecord& r : records) {
    if (!r.alive || (r.body_a != i && r.body_b != i)) continue;
    const std::uint32_t other = r.body_a == i ? r.body_b : r.body_a;
    if (other != kNone && !bodies.awake[other]) wake(other, cause, bodies.object[i]);
  }
}

// One body alone: a ring of one.
void Rigid::Impl::put_to_sleep(std::uint32_t i) {
  if (bodies.type[i] != BodyType::dynamic || !bodies.awake[i]) return;
  FEDER_ASSERT(next_in_island[i] == kNone && sleeping_count < bodies.size());
  bodies.awake[i] = 0;
  bodies.velocity[i] = bodies.angular_velocity[i] = Vec3::Zero();
  bodies.sleep_energy[i] = 0;
  bodies.island[i] = i;
  next_in_island[i] = i;
  place_colliders(i, 0, Vec3::Zero());
  ++sleeping_count;
  list_stale = true;
  Event e;
  e.kind = EventKind::sleep;
  e.a = bodies.object[i];
  events.add_pending(e);
}

// Energies of this step: candidates, and jumps for the watchdog.
void Rigid::Impl::measure_motion(StepContext& c) {
  const Real keep = 1 / (1 + c.dt / kMemory);
  const Real least = static_cast<Real>(quiet_energy(c));
  any_candidate = false;
  for (const std::uint32_t i : moving) {
    if (bodies.type[i] != BodyType::dynamic) continue;
    FEDER_ASSERT(is_finite(bodies.velocity[i]) &&
                 is_finite(bodies.angular_velocity[i]));  // commit has quarantined others
    const Vec3 w = rotate_inverse(bodies.rotation[i], bodies.angular_velocity[i]);
    const Vec3 momentum = bodies.inertia[i] * w;
    const Real energy =
        Real(0.5) * (dot(bodies.velocity[i], bodies.velocity[i]) + dot(w, momentum) * bodies.inv_mass[i]);
    if (jumps(i, energy, least)) jumpers.push_back(i);
    const Real mean = energy + (bodies.sleep_energy[i] - energy) * keep;
    const Real low = sleep_energy(bodies, i), restless = kRestless * low, cap = kCap * low;
    bodies.sleep_energy[i] = mean < cap ? mean : cap;
    if (bodies.sleep_energy[i] < low && energy < restless) sleep_candidate[i] = 1;
    if (bodies.sleep_energy[i] > restless || energy > cap || !bodies.can_sleep[i]) sleep_candidate[i] = 0;
    any_candidate = any_candidate || sleep_candidate[i];
  }
}

// Calls f(a, b) for the bodies that active contacts and joints connect; kNone where that is none.
template <class F>
void Rigid::Impl::each_link(F&& f) {
  for (const ColliderPair& pair : contacts.active_pairs) {
    FEDER_ASSERT(pair.a < colliders.size() && pair.b < colliders.size());
    f(colliders.body_of(pair.a), colliders.body_of(pair.b));
  }
  for (const std::uint32_t j : active_joints)
    if (records[j].alive) f(records[j].body_a, records[j].body_b);
}

// Once a step, unless bodies or joints are lost in it.
void Rigid::Impl::join_islands() {
  if (islands_joined) return;
  islands_joined = true;
  for (const std::uint32_t i : moving) islands.isolate(i);
  each_link([&](std::uint32_t a, std::uint32_t b) {
    if (bodies.moves(a) && bodies.moves(b)) islands.join(a, b);
  });
}

// A moving kinematic partner keeps a body awake: no candidate.
void Rigid::Impl::keep_driven_awake() {
  const auto drives = [&](std::uint32_t k) {
    return k != kNone && bodies.type[k] == BodyType::kinematic &&
           (!bodies.velocity[k].isZero(0) || !bodies.angular_velocity[k].isZero(0));
  };
  if (std::none_of(moving.begin(), moving.end(), drives)) return;
  each_link([&](std::uint32_t a, std::uint32_t b) {
    if (bodies.moves(a) && drives(b)) sleep_candidate[a] = 0;
    if (bodies.moves(b) && drives(a)) sleep_candidate[b] = 0;
  });
}

void Rigid::Impl::sleep_islands() {
  // a member that is no candidate keeps its island awake: it is noted at the root
  for (const std::uint32_t i : moving)
    if (bodies.type[i] == BodyType::dynamic) bodies.island[i] = kNone;
  for (const std::uint32_t i : moving)
    if (bodies.type[i] == BodyType::dynamic && !sleep_candidate[i]) bodies.island[islands.root(i)] = i;
  for (const std::uint32_t i : moving) {
    if (bodies.type[i] != BodyType::dynamic) continue;
    const std::uint32_t r = islands.root(i);
    if (bodies.island[r] != kNone && bodies.island[r] != r) continue;
    if (bodies.island[r] == r && !sleep_candidate[r]) continue;
    put_to_sleep(i);
    // members come in ascending order, the root first: insert behind the root
    bodies.island[i] = r;
    if (i == r) continue;
    FEDER_ASSERT(r < i && bodies.island[r] == r && !bodies.awake[r]);
    next_in_island[i] = next_in_island[r];
    next_in_island[r] = i;
  }
  for (const std::uint32_t i : moving)
    if (bodies.awake[i]) bodies.island[i] = kNone;
}

void Rigid::Impl::update_sleep(StepContext& c) {
  jumpers.reserve(bodies.size());  // an impact must not allocate
  if (c.sleeping)
    measure_motion(c);
  else
    measure_pace(c);
  if (!jumpers.empty()) watch(c);
  if (!warned_far) check_far(c);
  say_of_fields(c);
  if (joint_count > 0 && !gap_warned) check_open_joints(c);
  if (!c.sleeping) return;
  if (!any_candidate) return;
  join_islands();
  keep_driven_awake();
  sleep_islands();
}

}  // namespace feder
