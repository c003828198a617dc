// One life of a scene: its script, its world, and what was done to it by hand. Two lives of one recipe with the same
// deeds are equal bit for bit, which is what going back in time rests on: Lua's own state (timers, tasks, variables)
// cannot be copied, but it can be lived again.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "feder/lua.h"
#include "view/picking.h"

namespace feder::view {

// What survives a reload that keeps the world: objects with the same name go on from where they are.
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

// What a scene is made from.
struct Recipe {
  std::filesystem::path file;
  lua::HostOptions host;                  // set and world hold what the user changed
  std::shared_ptr<const KeptState> kept;  // of the scene before, when the world goes on
};

struct Deed {
  std::uint64_t step = 0;  // steps done before it
  Command command;
};

struct LoadFailure {
  std::string message;                       // "file:line: ..."
  std::vector<std::filesystem::path> files;  // that were read, the broken one included
};

class SceneRun {
 public:
  // Null, with `failure` filled, when the file cannot be read, run or built.
  static std::unique_ptr<SceneRun> make(const Recipe& recipe, LoadFailure& failure);

  // The deeds of the life before, up to a step: they will be done again at their steps.
  void relive(std::vector<Deed> deeds) { due_ = std::move(deeds); }
  // Does it now and remembers it. What the command throws goes on to the caller, and it is remembered all the same:
  // it may have done a part.
  void act(Command command);
  // Deeds done before the step count was `step`.
  std::vector<Deed> deeds_before(std::uint64_t step) const;
  // One step, after the deeds that are due.
  void step();

  lua::Script& script() { return *script_; }
  World& world() { return *script_->world(); }
  const NamedStates& start() const { return start_; }

 private:
  SceneRun() = default;
  void do_due();

  std::unique_ptr<lua::Script> script_;
  NamedStates start_;
  std::vector<Deed> deeds_, due_;
  std::size_t next_due_ = 0;
};

}  // namespace feder::view
