// Invariants of a world after each step, asserted where asserts are on (feder/error.h): the plan's passes lie in the
// order they run in, the table of objects and the events are consistent, forces have a target, and each system checks
// its own structures (System::validate).
#include <algorithm>
#include <cmath>
#include <cstring>

#include "feder/error.h"
#include "feder/world.h"
#include "forces/forces.h"
#include "state/contact_book.h"
#include "step/watch.h"

namespace feder {
namespace {

void check_order(std::span<const PlanNode> nodes) {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const PlanNode& node = nodes[k];
    FEDER_ASSERT(k == 0 || !(node.place < nodes[k - 1].place));
    if (!node.is_loop) {
      FEDER_ASSERT(node.loop == loop_of(node.place.rank));
      continue;
    }
    FEDER_ASSERT(node.end > k + 1 && node.end <= nodes.size());  // no loop without passes
    FEDER_ASSERT(nodes[node.end - 1].place.rank <= kLoops[static_cast<int>(node.loop)].last);
  }
}

}  // namespace

// The profile and `explain` know a pass by its name within its system.
void World::check_names() const {
  const std::span<const PlanNode> nodes = plan_.nodes();
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t j = 0; j < k; ++j)
      FEDER_ASSERT(std::strcmp(nodes[k].system, nodes[j].system) || std::strcmp(nodes[k].name, nodes[j].name));
}

void World::validate() const {
  check_order(plan_.nodes());
  FEDER_ASSERT(std::isfinite(time_) && time_ >= 0);
  objects_.validate();
  events_.validate();
  if (const ContactBook* book = store_.find<ContactBook>()) book->validate(objects_, events_);
  if (const Forces* forces = store_.find<Forces>())
    for (const ForceEntry& f : forces->list) {
      FEDER_ASSERT(f.all || f.tags || f.target);
      FEDER_ASSERT(std::is_sorted(f.points.begin(), f.points.end()));
    }
  FEDER_ASSERT(watch_.suspects.empty());
  for (const Present& p : systems_) p.system->validate();
}

}  // namespace feder
