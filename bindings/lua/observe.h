// What expectations look back on: events and warnings of a world since it was made, and the energy it began with.
#pragma once
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "feder/events.h"
#include "feder/system.h"

namespace feder {
class World;
}

namespace feder::lua {

struct Observed {
  struct Warning {
    std::string code, message;  // of the first one
    std::uint64_t count = 0;
  };
  // Of two objects, in simulated s.
  struct Touch {
    ObjectId a, b;
    double begin = 0, end = std::numeric_limits<double>::infinity();  // infinite while it lasts
  };
  static constexpr std::size_t kMaxTouches = 1'000'000;

  bool on = true;  // somebody may ask: a check, or a plain script
  bool begun = false;
  Energy start;                                             // before the first step
  std::vector<std::pair<EventKind, std::uint64_t>> counts;  // of kinds that happened
  std::vector<Warning> warnings;
  std::vector<Touch> touches;                                  // the first kMaxTouches
  std::map<std::pair<ObjectId, ObjectId>, std::size_t> lasts;  // those that last, by pair

  std::uint64_t count(EventKind kind) const;
};

// Around a step of the world, before handlers run.
void observe_start(World& world, Observed& observed);
void observe_step(World& world, Observed& observed);

}  // namespace feder::lua
