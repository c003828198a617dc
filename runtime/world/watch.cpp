// Watchdog, last stage: suspects of this step against the energy that the whole world could have given them.
#include "step/watch.h"

#include <cmath>
#include <cstdio>
#include <cstring>

#include "feder/world.h"

namespace feder {
namespace {

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

}  // namespace

void World::warn_of_energy(const StepContext& c) {
  double all = 0, drive = 0;
  for (const Present& p : systems_) {
    all += p.system->held(c);
    drive = std::fmax(drive, p.system->drive(c));
  }
  const auto others_hold = [&](const char* system) {
    for (const Present& p : systems_)
      if (std::strcmp(p.descriptor->name, system) != 0 && p.system->held(c) > 0) return true;
    return false;
  };
  const auto episode = static_cast<std::uint64_t>(std::ceil(kEpisode / desc_.dt));
  std::erase_if(watch_.alarms, [&](const Watch::Alarm& a) { return c.step > a.step + episode || c.step < a.step; });
  std::string message;
  ObjectId object;
  for (const Suspect& s : watch_.suspects) {
    // a kinematic body throws others at up to twice its speed
    double given = s.given + 2 * s.mass * drive * drive;
    if (s.shared || others_hold(s.system)) given += all;
    if (!Watch::jumped(s.before, given, s.after)) continue;
    Watch::Alarm* known = nullptr;
    for (Watch::Alarm& a : watch_.alarms)
      if (a.object == s.object) known = &a;
    if (known) {
      known->step = c.step;
      continue;
    }
    watch_.alarms.push_back({s.object, c.step});
    message += (message.empty() ? "" : "; ") + objects_.describe(s.object) + ": kinetic energy went from " +
               number(s.before) + " J to " +
               (std::isfinite(s.after) ? number(s.after) + " J" : "a value that is not finite") +
               " in one step, with " + number(given) + " J of work and stored energy to account for it; " + s.cure;
    if (!object) object = s.object;
  }
  watch_.suspects.clear();
  if (!message.empty()) events_.warn("diverged", message, object);
}

}  // namespace feder
