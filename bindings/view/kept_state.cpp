#include "view/kept_state.h"

namespace feder::view {
namespace {

const Kept* find_nth(const NamedStates& states, const ObjectView* view, const std::string& name, std::size_t n) {
  const auto own = states.find(view);
  if (own == states.end()) return nullptr;
  const auto found = own->second.find(name);
  return found != own->second.end() && n < found->second.size() ? &found->second[n] : nullptr;
}

// Calls f(view, id, name, n) for the named objects that can move: the n-th of its name.
template <class F>
void each_named(World& world, F&& f) {
  for (const ObjectView* view : object_views()) {
    std::map<std::string, std::size_t> seen;
    world.objects().for_each(view->kind(), [&](ObjectId id) {
      const std::string& name = world.objects().name(id);
      if (!name.empty() && view->keeps(world, id)) f(*view, id, name, seen[name]++);
    });
  }
}

}  // namespace

NamedStates named_states(World& world) {
  NamedStates s;
  each_named(world, [&](const ObjectView& view, ObjectId id, const std::string& name, std::size_t) {
    s[&view][name].push_back(view.state(world, id));
  });
  return s;
}

void apply_kept(World& world, const KeptState& kept) {
  each_named(world, [&](const ObjectView& view, ObjectId id, const std::string& name, std::size_t n) {
    const Kept* start = find_nth(kept.start, &view, name, n);
    const Kept* now = find_nth(kept.now, &view, name, n);
    if (start && now) view.apply(world, id, *start, *now);
  });
}

}  // namespace feder::view
