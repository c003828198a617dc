// Sleep. A soft body whose mean kinetic energy per mass stays below that of kSoftSpeed for kSoftTime sleeps; it wakes
// by script, by a force that changes, or by a contact with what moves. Kept between steps: the moving average of the
// energy, and since when it is low.
#include <algorithm>

#include "soft/impl.h"

namespace feder {
namespace {
constexpr Real kSoftSpeed = Real(0.025);  // m/s, root mean square
constexpr Real kSoftTime = 1;             // s
constexpr Real kSoftMemory = Real(0.5);   // s, of the moving average
}  // namespace

void Soft::Impl::drain_wakes() {
  const auto ours = [&](ObjectId id) { return objects.alive(id) && objects.kind(id) == kSoftKind; };
  for (const Surfaces::Wake& w : surfaces.wakes)
    if (ours(w.object)) wake(body(w.object), w.cause, w.other);
  std::erase_if(surfaces.wakes, [&](const Surfaces::Wake& w) { return !objects.alive(w.object) || ours(w.object); });
}

void Soft::Impl::wake_touched(StepContext&) { drain_wakes(); }

void Soft::Impl::wake(SoftBody& b, WakeCause cause, ObjectId other) {
  b.state.sleep_steps = 0;
  b.state.sleep_energy = kSoftSpeed * kSoftSpeed * 25;
  const bool slept = b.state.asleep != 0;
  b.state.asleep = 0;
  if (b.surface < surfaces.list.size() && surfaces.list[b.surface].object == b.object)
    surfaces.list[b.surface].sleep_candidate = false;
  if (slept) events.add_pending({.kind = EventKind::wake, .cause = cause, .a = b.object, .b = other});
}

void Soft::Impl::put_to_sleep(SoftBody& b) {
  if (b.state.asleep || b.state.frozen) return;
  b.state.asleep = 1;
  b.set_flight(Vec3(0, 0, 0));
  for (Array<Vec3>* a : {&b.velocity, &b.contact, &b.steady_contact}) a->assign(b.size(), Vec3::Zero());
  events.add_pending({.kind = EventKind::sleep, .a = b.object, .b = {}});
}

void Soft::Impl::update_sleep(SoftBody& b, StepContext& c) {
  if (!c.sleeping) return;
  Real energy = 0;
  for (std::uint32_t i = 0; i < b.size(); ++i) energy += b.mass[i] * dot(b.velocity[i], b.velocity[i]);
  energy = Real(0.5) * energy / b.total_mass;
  const Real cap = kSoftSpeed * kSoftSpeed * 25, keep = 1 / (1 + c.dt / kSoftMemory);
  b.state.sleep_energy = std::min(energy + (std::min(b.state.sleep_energy, cap) - energy) * keep, cap);
  bool steady = true;  // wind may gust
  each_force(b, [&](const ForceEntry& f) { steady = steady && !f.force->on_area(); });
  if (!steady || b.state.sleep_energy > Real(0.5) * kSoftSpeed * kSoftSpeed) {
    b.state.sleep_steps = 0;
    return;
  }
  if (static_cast<Real>(++b.state.sleep_steps) * c.dt > kSoftTime) put_to_sleep(b);
}

}  // namespace feder
