// Sleep of fluids, each as a whole. A pool whose particles are slow for kRestTime, and whose centre of mass stays where
// it is, sleeps: no solver substeps, its pressures stay as they are. It stays awake beside bodies that are awake or
// move, beside faces of sheets and nets, and under forces other than gravity. It wakes when anything that it touches
// moves, comes or goes, when particles come or go, when gravity changes, and by scripts. Bodies in calm water may fall
// asleep (FluidRigid::keep_awake); they go first. Kept between steps: for how long it has been calm, its centre then,
// and a key of what it rests against. Weak spot: what creeps by less than kRestDrift a second stops.
#include <algorithm>
#include <cmath>

#include "feder/snapshot.h"
#include "fluid/impl.h"

namespace feder {
namespace {

constexpr double kRestSpeed = 0.03, kRestMost = 0.2;  // of sqrt(g d): root mean square, and of the fastest particle
constexpr double kRestDrift = 0.01;                   // spacings, of the centre of mass in kRestTime
constexpr Real kRestTime = 1;                         // s

bool stirs(const BoundaryBody& b) {
  return !b.velocity.isZero(0) || !b.angular_velocity.isZero(0) || !b.inv_mass.isZero(0);
}

}  // namespace

bool FluidPool::drowsy() const { return asleep || calm >= kRestTime / 2; }

void Fluid::Impl::wake(FluidPool& p, WakeCause cause, ObjectId other) {
  p.calm = 0;
  if (!p.asleep) return;
  p.asleep = false;
  events.add_pending({.kind = EventKind::wake, .cause = cause, .a = p.object, .b = other});
}

// Of all that a pool at rest depends on; 0 where something keeps it awake. Finds its contacts.
std::uint64_t Fluid::Impl::rest_key(FluidPool& p, const StepContext& c) {
  if (p.count == 0 || p.faces_near == c.step + 1 || is_forced(p)) return 0;
  p.copy(p.x, p.start, *c.jobs);
  p.find_contacts(*c.jobs, boundary, c.dt, c.gravity, false);
  Hash key;
  key.add(p.count), key.add(p.next_id), key.add(Vec3(p.desc.gravity_scale * c.gravity));
  for (std::uint32_t k = 0; k < p.contact_first[p.count]; ++k) {
    const BoundaryContact& contact = p.contacts[k];
    const BoundaryBody& b = boundary.body_of(contact);
    if (stirs(b)) return 0;
    key.add(contact.particle), key.add(b.object.slot), key.add(contact.offset), key.add(contact.normal);
  }
  return std::max<std::uint64_t>(key.value(), 1);
}

void Fluid::Impl::wake_disturbed(StepContext& c) {
  for (auto& pool : pools) {
    FluidPool& p = *pool;
    if (!p.asleep) continue;
    if (rest_key(p, c) == p.rest_key) continue;
    ObjectId by;
    for (std::uint32_t k = 0; k < p.contact_first[p.count] && !by; ++k)
      if (stirs(boundary.body_of(p.contacts[k]))) by = boundary.body_of(p.contacts[k]).object;
    wake(p, WakeCause::contact, by);
    // couplings with faces have passed it over, as none was near
    if (p.origin.empty() || p.faces_near == c.step + 1) continue;
    p.copy(p.x, p.origin, *c.jobs);
    std::fill(p.screen.begin(), p.screen.begin() + p.count, Real(0));
  }
}

void Fluid::Impl::update_sleep(FluidPool& p, const RestSums& sums, StepContext& c) {
  const double unit = static_cast<double>(length(Vec3(p.desc.gravity_scale * c.gravity)) * p.desc.spacing), n = p.count;
  const bool slow = c.sleeping && p.active() && unit > 0 && sums.square <= kRestSpeed * kRestSpeed * unit * n &&
                    sums.most <= kRestMost * kRestMost * unit;
  double moved = 0;
  for (int k = 0; k < 3; ++k) moved = std::max(moved, std::fabs(sums.place[k] / n - p.rest_center[k]));
  if (!slow || p.calm == 0 || moved > kRestDrift * static_cast<double>(p.desc.spacing)) {
    for (int k = 0; k < 3; ++k) p.rest_center[k] = slow ? sums.place[k] / n : 0;
    p.calm = slow ? c.dt : Real(0);
    return;
  }
  p.calm += c.dt;
  // fluids that touch sleep together; the others may not have counted this step yet
  if (p.calm < kRestTime || !all_calm(p, kRestTime - Real(1.5) * c.dt)) return;
  if (rest_key(p, c) == 0) return;
  p.asleep = true;
  for (std::uint32_t i = 0; i < p.count; ++i) p.v[i].set(Vec3::Zero());
  p.kinetic = 0;
  p.rest_key = rest_key(p, c);  // contacts reach as far as particles move
  events.add_pending({.kind = EventKind::sleep, .a = p.object, .b = {}});
}

}  // namespace feder
