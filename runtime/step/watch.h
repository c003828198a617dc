// Watchdog over kinetic energy. A step may leave an object (rigid: an island, named by its worst body) with at most
// kDiverged times the sum of its kinetic energy before, the work done on it and its energy stored as strain or overlap;
// more, or a non-finite energy, is an instability of the method and not of the scene.
// A system compares the kinetic energies of its objects before and after each step, as cheaply as it can; only of those
// that jumped it computes bounds of work and stored energy, and reports a suspect. At the end of the step the world
// adds what other systems may have given (System::held, System::drive) and warns, once per object and episode. All
// bounds are from above, so that there are no false alarms, but late ones. tests/lua/test_watchdog.cpp.
#pragma once
#include "feder/error.h"
#include "feder/memory.h"
#include "feder/plan.h"
#include "feder/types.h"

namespace feder {

inline constexpr double kDiverged = 4;      // kinetic energy over what accounts for it
inline constexpr double kEpisode = 1;       // s without alarm, after which the same object is reported again
inline constexpr double kScriptWindow = 1;  // s after an edit in which the misfit that it left counts as stored

// J/kg, below which nothing is checked: 8 cm/s, and what gravity gives in two steps.
inline double quiet_energy(const StepContext& c) {
  const double v = static_cast<double>(length(c.gravity)) * static_cast<double>(c.dt);
  return 0.5 * 0.08 * 0.08 + 2 * v * v;
}

// Largest mean work of a force g per mass on a mass m whose kinetic energy went from k0 to k1 in dt.
inline double gravity_work(double g, double dt, double m, double k0, double k1) {
  FEDER_ASSERT(dt > 0);
  if (!(m > 0)) return 0;  // all of it pinned, or masses that are none in Real
  return m * g * dt * (std::sqrt(2 * std::fmax(k0, k1) / m) + g * dt);
}

struct Suspect {
  const char* system = "";
  ObjectId object;
  double before = 0, after = 0;  // kinetic energy, J
  double given = 0;              // work and stored energy within the system, J
  double mass = 0;               // kg, that shares that energy
  bool shared = false;           // other objects of the system may have given energy
  const char* cure = "";
};

struct Watch {
  explicit Watch(Arena& a) : suspects(&a), alarms(&a) {}
  struct Alarm {
    ObjectId object;
    std::uint64_t step = 0;  // of the last one
  };
  Array<Suspect> suspects;  // of this step
  Array<Alarm> alarms;      // episodes that go on

  // More energy than the object itself accounts for; the world adds the others.
  static bool jumped(double before, double given, double after) {
    return !(after <= kDiverged * (before + given));  // also what is not a number
  }
};

}  // namespace feder
