// Counts what happens in a world, for expectations.
#include "lua/observe.h"

#include <algorithm>

#include "feder/world.h"

namespace feder::lua {
namespace {

void observe_contact(Observed& observed, const Event& e, double time) {
  const std::pair pair(e.a, e.b);
  if (e.kind == EventKind::contact_begin && observed.touches.size() < Observed::kMaxTouches) {
    observed.lasts[pair] = observed.touches.size();
    observed.touches.push_back({e.a, e.b, time});
  } else if (const auto at = observed.lasts.find(pair);
             e.kind == EventKind::contact_end && at != observed.lasts.end()) {
    observed.touches[at->second].end = time;
    observed.lasts.erase(at);
  }
}

}  // namespace

std::uint64_t Observed::count(EventKind kind) const {
  for (const auto& [known, n] : counts)
    if (known == kind) return n;
  return 0;
}

void observe_start(World& world, Observed& observed) {
  if (!observed.on || observed.begun) return;
  observed.begun = true;
  observed.start = world.energy();
}

void observe_step(World& world, Observed& observed) {
  if (!observed.on) return;
  const Events& events = world.events();
  for (const Event& e : events.list()) {
    // the list is sorted by kind
    if (observed.counts.empty() || !(observed.counts.back().first == e.kind)) {
      const auto at = std::ranges::find_if(observed.counts, [&](const auto& c) { return c.first == e.kind; });
      if (at == observed.counts.end())
        observed.counts.emplace_back(e.kind, 0);
      else
        std::rotate(at, at + 1, observed.counts.end());
    }
    ++observed.counts.back().second;
    observe_contact(observed, e, world.time());
    if (e.kind != EventKind::warning) continue;
    const std::string& code = events.warning_code(e);
    auto at = std::ranges::find_if(observed.warnings, [&](const auto& w) { return w.code == code; });
    if (at == observed.warnings.end()) at = observed.warnings.insert(at, {code, events.warning_message(e), 0});
    ++at->count;
  }
}

}  // namespace feder::lua
