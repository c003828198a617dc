// Sleep. A cloth whose mean kinetic energy per mass stays below that of kSleepSpeed for kSleepTime, under steady
// forces, is a sleep candidate and then sleeps; it wakes by script, by a force that changes, or by a contact with what
// moves. Kept between steps: the moving average of the energy, and since when it is low.
#include <algorithm>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr Real kSleepSpeed = Real(0.025);  // m/s, root mean square
constexpr Real kSleepTime = 1;             // s
constexpr Real kMemory = Real(0.5);  // s, of the moving average: about a swing, so that no turning point counts alone
}  // namespace

void Cloth::Impl::wake(Sheet& s, WakeCause cause, ObjectId other) {
  s.state.sleep_steps = 0;
  s.state.sleep_energy = kSleepSpeed * kSleepSpeed * 25;
  const bool slept = s.state.asleep != 0;
  s.state.asleep = 0;
  const std::uint32_t n = objects.index(s.object);
  if (n < surfaces.list.size() && surfaces.list[n].object == s.object)
    surfaces.list[n].active = s.active(), surfaces.list[n].sleep_candidate = false;
  if (!slept) return;
  events.add_pending({.kind = EventKind::wake, .cause = cause, .a = s.object, .b = other});
}

void Cloth::Impl::put_to_sleep(Sheet& s) {
  if (s.state.asleep || s.state.frozen) return;
  s.state.asleep = 1;
  s.set_flight(Vec3(0, 0, 0));
  s.kinetic = 0;
  for (std::uint32_t i = s.first; i < s.first + s.total; ++i) vertices.velocity[i] = Vec3::Zero();
  events.add_pending({.kind = EventKind::sleep, .a = s.object, .b = {}});
}

void Cloth::Impl::update_sleep(StepContext& c) {
  if (!c.sleeping) return;
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active()) continue;
    Real energy = 0;
    for (std::uint32_t i = s.first; i < s.first + s.points; ++i)
      energy += vertices.mass[i] * dot(vertices.velocity[i], vertices.velocity[i]);
    energy = Real(0.5) * energy / s.mass;
    const Real cap = kSleepSpeed * kSleepSpeed * 25, keep = 1 / (1 + c.dt / kMemory);
    s.state.sleep_energy = std::min(energy + (std::min(s.state.sleep_energy, cap) - energy) * keep, cap);
    bool steady = true;  // generators on areas may gust
    each_force(s, [&](const ForceEntry& f) { steady = steady && !f.force->on_area(); });
    if (!steady || untangles(s) || s.state.sleep_energy > Real(0.5) * kSleepSpeed * kSleepSpeed) {
      s.state.sleep_steps = 0;
      continue;
    }
    if (static_cast<Real>(++s.state.sleep_steps) * c.dt > kSleepTime) put_to_sleep(s);
  }
}

}  // namespace feder
