// Snapshots of a world's forces: whom they act on, by value, and which generator, by its index.
#include "forces/forces.h"

#include <algorithm>

#include "feder/error.h"
#include "feder/snapshot.h"

namespace feder {
namespace {

template <class E, class F>
void each_saved_field(E& e, F&& f) {
  f(e.object), f(e.all), f(e.tags), f(e.target), f(e.enabled), f(e.warned);
}

}  // namespace

void Forces::save(Writer& w) const {
  w.add(static_cast<std::uint64_t>(list.size()));
  for (const ForceEntry& e : list) {
    each_saved_field(e, [&](const auto& x) { w.add(x); });
    w.list(e.points);
    std::uint32_t pin = kNone;
    if (e.force) {
      const auto at = std::find(pinned_.begin(), pinned_.end(), e.force);
      pin = static_cast<std::uint32_t>(at - pinned_.begin());
      if (at == pinned_.end()) pinned_.push_back(e.force);
    }
    w.add(pin);
  }
}

void Forces::load(Reader& r) {
  std::uint64_t count = 0;
  r.get(count);
  list.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    ForceEntry e;
    each_saved_field(e, [&](auto& x) { r.get(x); });
    r.list(e.points);
    const auto pin = r.get<std::uint32_t>();
    if (pin != kNone && pin >= pinned_.size()) throw SceneError("snapshot: made by another world (unknown force)");
    if (pin != kNone) e.force = pinned_[pin];
    list.push_back(std::move(e));
  }
}

}  // namespace feder
