// One life of a scene: its script, its world, and what was done to it by hand. Two lives of one recipe with the same
// deeds are equal bit for bit, which is what going back in time rests on: Lua's own state (timers, tasks, variables)
// cannot be copied, but it can be lived again.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "feder/lua.h"
#include "view/kept_state.h"

namespace feder::view {

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
