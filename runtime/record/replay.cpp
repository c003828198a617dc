// Reading a recording, and doing again what it holds.
#include <algorithm>

#include "record/command_text.h"
#include "record/commands.h"
#include "record/format.h"
#include "state/command_log.h"

namespace feder {
namespace {

// A reader of bytes without shapes.
struct Plain {
  explicit Plain(std::string_view bytes) : in(shapes) { in.read_from(bytes); }
  std::vector<ShapePtr> shapes;
  CommandReader in;
};

}  // namespace

Recording::Recording(std::string bytes) {
  recording::Blocks blocks(bytes);
  bool ended = false;
  while (!blocks.at_end()) {
    const recording::Block block = blocks.next();
    const std::string where = "block " + std::to_string(blocks.count()) + " of the recording";
    if (ended) throw SceneError(where + " comes behind its end");
    if ((block.kind == recording::kHeader) != (blocks.count() == 1))
      throw SceneError(where + (block.kind == recording::kHeader ? " is a second header" : " should be its header"));
    Plain p(block.content);
    if (block.kind == recording::kHeader) real_ = p.in.text();
    if (block.kind == recording::kHeader || block.kind == recording::kFacts) {
      for (std::uint64_t n = p.in.count(); n > 0; --n) {
        std::string name = p.in.text();
        facts_.emplace_back(std::move(name), p.in.text());
      }
    } else if (block.kind == recording::kWorld) {
      if (p.in.whole() != worlds_.size()) throw SceneError(where + " is of a world out of order");
      worlds_.push_back(std::make_shared<World>(World{std::string(p.in.rest()), "", 0}));
    } else if (block.kind == recording::kItems) {
      const std::uint64_t number = p.in.whole();
      if (number >= worlds_.size()) throw SceneError(where + " is of a world that is not there");
      worlds_[number]->steps += p.in.whole();
      worlds_[number]->items += p.in.rest();
    } else if (block.kind == recording::kEnd) {
      how_ = p.in.text();
      if (p.in.whole() + 1 != blocks.count()) throw SceneError("the recording lacks blocks before its end");
      ended = true;
    } else {
      throw SceneError(where + " is of an unknown kind");
    }
  }
  std::uint64_t steps = 0;
  for (const auto& w : worlds_) steps += w->steps;
  if (!ended) throw SceneError("the recording has no end: it is truncated, behind step " + std::to_string(steps));
}

std::string Recording::fact(std::string_view name) const {
  for (const auto& [key, value] : facts_)
    if (key == name) return value;
  return "";
}

WorldDesc Recording::desc(std::size_t world) const {
  Plain p(worlds_.at(world)->desc);
  WorldDesc out;
  command::read(p.in, out);
  return out;
}

struct Replay::Impl {
  explicit Impl(std::shared_ptr<const Recording::World> of) : recorded(std::move(of)), in(none), arguments(shapes) {
    in.read_from(recorded->items);
  }

  // Which snapshots are restored later: the others need not be taken.
  void find_restored() {
    Plain p(recorded->items);
    std::vector<std::string> all;
    while (!p.in.at_end()) {
      switch (static_cast<LogItem>(p.in.whole())) {
        case LogItem::name: all.push_back(p.in.text()), p.in.text(); break;
        case LogItem::command: {
          const std::uint64_t number = p.in.whole();
          const std::string given = p.in.text();
          if (number < all.size() && all[number] == "world.restore") state.restored.push_back(Plain(given).in.whole());
          break;
        }
        case LogItem::forces: p.in.view(8 * p.in.whole()); break;
        case LogItem::step:
          if (p.in.whole()) p.in.whole();
          break;
        case LogItem::note: p.in.text(), p.in.text(); break;
        default: throw SceneError("recording: an item of an unknown kind");
      }
    }
    std::sort(state.restored.begin(), state.restored.end());
  }

  void name() {
    const std::string name = in.text(), signature = in.text();
    const CommandRow* row = find_command(name);
    if (!row) throw SceneError("recording: this build has no command '" + name + "'");
    if (row->signature != signature)
      throw SceneError("recording: its command '" + name + "' has the arguments " + signature +
                       ", that of this build " + row->signature);
    rows.push_back(row);
  }

  void command(std::vector<RecordedCommand>* list) {
    const std::uint64_t number = in.whole();
    if (number >= rows.size()) throw SceneError("recording: command number " + std::to_string(number) + " is unknown");
    const CommandRow& row = *rows[number];
    const std::string_view given = in.view(in.whole());
    if (list) {
      const Objects& objects = world->objects();
      list->push_back({row.name, std::string(given), command_text(row.name, row.signature, given, objects)});
    }
    if (row.first != ObjectKind::none) {
      ObjectId first;
      arguments.read_from(given);
      command::read(arguments, first);
      world->objects().index(first, row.first);  // throws
    }
    arguments.read_from(given);
    row.run(state, arguments);
  }

  void note(std::vector<RecordedCommand>* list) {
    const std::string kind = in.text(), text = in.text();
    if (list) list->push_back({"note", kind + "\n" + text, kind + ": " + text.substr(0, text.find('\n'))});
  }

  void forces() {
    for (std::uint64_t n = in.whole(); n > 0; --n) state.forces.push_back(in.number());
  }

  void step() {
    has_hash = in.whole() != 0;
    if (has_hash) hash = in.whole();
    world->step();
    const bool good =
        state.forces_fit && state.next_force == state.forces.size() && (!has_hash || world->hash() == hash);
    if (!good && same) same = false, parted = world->step_count();
    state.forces.clear(), state.next_force = 0, state.forces_fit = true;
  }

  std::shared_ptr<const Recording::World> recorded;
  std::vector<ShapePtr> none, shapes;
  CommandReader in, arguments;
  std::vector<const CommandRow*> rows;  // by number
  ReplayState state;
  std::unique_ptr<World> world;
  bool has_hash = false, same = true;
  std::uint64_t hash = 0, parted = 0;
};

Replay::Replay(const Recording& recording, std::size_t world, Catalog catalog, int threads)
    : impl_(std::make_unique<Impl>(recording.worlds_.at(world))) {
  if (recording.real() != kRealName)
    throw SceneError("the recording is of the scalar type " + recording.real() + ", this build is of " + kRealName);
  impl_->find_restored();
  WorldDesc desc = recording.desc(world);
  if (threads > 0) desc.threads = threads;
  impl_->world = std::make_unique<World>(desc, catalog);
  impl_->state.world = impl_->world.get();
}

Replay::~Replay() = default;

bool Replay::step(std::vector<RecordedCommand>* commands) {
  if (commands) commands->clear();
  Impl& m = *impl_;
  while (!m.in.at_end()) {
    switch (static_cast<LogItem>(m.in.whole())) {
      case LogItem::name: m.name(); break;
      case LogItem::command: m.command(commands); break;
      case LogItem::forces: m.forces(); break;
      case LogItem::note: m.note(commands); break;
      case LogItem::step: return m.step(), true;
      default: throw SceneError("recording: an item of an unknown kind");
    }
  }
  return false;
}

std::string replay_difference(std::string bytes, Catalog catalog) {
  try {
    const Recording recording(std::move(bytes));
    for (std::size_t k = 0; k < recording.world_count(); ++k) {
      Replay replay(recording, k, catalog);
      while (replay.step() && replay.same()) {
      }
      if (!replay.same())
        return "the replay of world " + std::to_string(k + 1) + " is another from step " +
               std::to_string(replay.parted()) + " on";
    }
  } catch (const SceneError& e) {
    return std::string("the replay fails: ") + e.what();
  }
  return "";
}

World& Replay::world() { return *impl_->world; }
bool Replay::has_hash() const { return impl_->has_hash; }
std::uint64_t Replay::hash() const { return impl_->hash; }
bool Replay::same() const { return impl_->same; }
std::uint64_t Replay::parted() const { return impl_->parted; }

}  // namespace feder
