// What survives a reload that keeps the world: objects with the same name go on from where they are.
#pragma once
#include <map>

#include "view/object_view.h"

namespace feder::view {

// Named objects that can move, by view and name; those that share a name are told apart by their order.
using NamedStates = std::map<const ObjectView*, std::map<std::string, std::vector<Kept>>>;

NamedStates named_states(World& world);

struct KeptState {
  NamedStates start;  // as the old scene file built them
  NamedStates now;    // when the new file came
  double time = 0;    // s, shown by the clock then
};

// `world` has just been built. An object that the old and the new file start in the same way goes on from where it was;
// where the file says something new, the file is right.
void apply_kept(World& world, const KeptState& kept);

}  // namespace feder::view
