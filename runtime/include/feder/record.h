// Recordings: all that is done to worlds between their steps, as commands, with a state hash every n steps; a replay
// needs neither script nor host, and is exact. Bytes in blocks with checksums, the same for both scalar types and on
// every machine; whatever is not a complete recording of this format is refused by a SceneError that says where.
// One thread at a time.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "feder/world.h"

namespace feder {

inline constexpr int kRecordingFormat = 4;

// What a reader may want to know, in order: ("scene", "scenes/tower.lua"), ("file scenes/tower.lua", its text) ...
using RecordingFacts = std::vector<std::pair<std::string, std::string>>;

class Recorder {
 public:
  using Sink = std::function<void(std::string_view bytes)>;
  // The state hash is kept every `hash_every` steps; 0: never.
  Recorder(Sink sink, const RecordingFacts& facts, int hash_every = 1);
  ~Recorder();
  void add_facts(const RecordingFacts& facts);
  // From now on, what is done to this world: a fresh one, without steps and objects. It may end before the recorder.
  void add(World& world);
  // For readers: kind ("script") and text, at this place of the world's commands.
  void note(World& world, std::string_view kind, std::string_view text);
  // Writes what is left, and the end; without it a recording is truncated. `how`: "finished", or why it was not.
  // Worlds are no longer recorded then.
  void finish(std::string_view how);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A recording as it was read, with all its checksums right.
class Recording {
 public:
  explicit Recording(std::string bytes);
  const RecordingFacts& facts() const { return facts_; }
  std::string fact(std::string_view name) const;  // "" when it is not there
  const std::string& real() const { return real_; }
  const std::string& how() const { return how_; }  // it ended
  std::size_t world_count() const { return worlds_.size(); }
  std::uint64_t steps(std::size_t world) const { return worlds_[world]->steps; }
  WorldDesc desc(std::size_t world) const;

 private:
  friend class Replay;
  struct World {
    std::string desc, items;
    std::uint64_t steps = 0;
  };
  RecordingFacts facts_;
  std::string real_, how_;
  std::vector<std::shared_ptr<World>> worlds_;  // a replay has its share
};

// One command of a recording.
struct RecordedCommand {
  std::string name;       // "rigid.set_velocity"
  std::string arguments;  // as bytes: equal for equal calls
  std::string text;       // "rigid.set_velocity body "crate", (0, 5, 0)"; objects as they are called then
};

// Makes a world of a recording again, step by step. SceneError where this build cannot: other scalar type, an unknown
// or different command, a system that it leaves out.
class Replay {
 public:
  // `threads`: 0, as recorded. The catalog outlives it.
  Replay(const Recording& recording, std::size_t world, Catalog catalog, int threads = 0);
  ~Replay();
  // Does what was done before the next step, and the step. False at the end, when what was done behind the last step is
  // done. `commands`: what was done, when not null.
  bool step(std::vector<RecordedCommand>* commands = nullptr);
  World& world();
  // Of the last step: whether a hash was kept, and which.
  bool has_hash() const;
  std::uint64_t hash() const;
  // Whether every hash so far was that of the replay, and the first step after which it was not.
  bool same() const;
  std::uint64_t parted() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Why a replay of all worlds in the bytes is not as recorded; "" when it is.
std::string replay_difference(std::string bytes, Catalog catalog);

}  // namespace feder
