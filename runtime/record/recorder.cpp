// Recorder: listens to the command logs of worlds, and writes what they hold in blocks.
// Weak spot: a world's items between two steps are in memory until its next step.
#include <algorithm>

#include "feder/record.h"
#include "record/format.h"
#include "state/command_log.h"

namespace feder {
namespace {

constexpr std::size_t kBlockBytes = 1 << 18;  // after which a block is written

class Listener final : public LogListener {
 public:
  Listener(World& world, std::uint64_t number, int hash_every, const Recorder::Sink& sink, std::uint64_t& blocks)
      : world_(&world), number_(number), hash_every_(hash_every), sink_(sink), blocks_(blocks) {
    CommandBytes content;
    content.whole(number);
    command::write(content, world.desc());
    write(recording::kWorld, content.bytes());
    world.commands().listen(this);
  }
  ~Listener() override {
    if (world_) world_->commands().listen(nullptr);
  }

  bool listens_to(const World& world) const { return world_ == &world; }
  CommandLog& log() { return world_->commands(); }

  void stepped() override {
    const std::uint64_t hash = due() ? world_->hash() : 0;
    log().add_step(due() ? &hash : nullptr);
    ++steps_;
    if (log().items().size() >= kBlockBytes) flush();
  }
  void closed() override {
    flush();
    world_ = nullptr;
  }
  void flush() {
    if (!world_ || log().items().empty()) return;
    CommandBytes head;
    head.whole(number_), head.whole(steps_);
    write(recording::kItems, head.bytes() + log().items());
    log().clear_items();
    steps_ = 0;
  }

 private:
  bool due() const { return hash_every_ > 0 && world_->step_count() % static_cast<std::uint64_t>(hash_every_) == 0; }
  void write(char kind, std::string_view content) {
    sink_(recording::block(kind, content));
    ++blocks_;
  }

  World* world_;
  std::uint64_t number_;
  int hash_every_;
  const Recorder::Sink& sink_;
  std::uint64_t& blocks_;
  std::uint64_t steps_ = 0;  // in the items
};

}  // namespace

struct Recorder::Impl {
  Sink sink;
  int hash_every;
  std::uint64_t blocks = 0;
  std::vector<std::unique_ptr<Listener>> listeners;  // by the number of the world
};

static void write_facts(CommandBytes& out, const RecordingFacts& facts) {
  out.whole(facts.size());
  for (const auto& [name, value] : facts) out.text(name), out.text(value);
}

Recorder::Recorder(Sink sink, const RecordingFacts& facts, int hash_every)
    : impl_(new Impl{std::move(sink), hash_every, 0, {}}) {
  CommandBytes content;
  content.text(kRealName);
  write_facts(content, facts);
  impl_->sink(recording::first_line() + recording::block(recording::kHeader, content.bytes()));
  ++impl_->blocks;
}

void Recorder::add_facts(const RecordingFacts& facts) {
  CommandBytes content;
  write_facts(content, facts);
  impl_->sink(recording::block(recording::kFacts, content.bytes()));
  ++impl_->blocks;
}

Recorder::~Recorder() = default;

void Recorder::add(World& world) {
  if (world.step_count() > 0 || !world.report().empty())
    throw SceneError("recording: expected a world without steps and systems");
  if (world.commands().recording()) throw SceneError("recording: the world is recorded already");
  const std::uint64_t number = impl_->listeners.size();
  impl_->listeners.push_back(std::make_unique<Listener>(world, number, impl_->hash_every, impl_->sink, impl_->blocks));
}

void Recorder::note(World& world, std::string_view kind, std::string_view text) {
  for (auto& l : impl_->listeners)
    if (l && l->listens_to(world)) l->log().add_note(kind, text);
}

void Recorder::finish(std::string_view how) {
  for (auto& l : impl_->listeners)
    if (l) l->flush();
  impl_->listeners.clear();
  CommandBytes content;
  content.text(how);
  content.whole(impl_->blocks);
  impl_->sink(recording::block(recording::kEnd, content.bytes()));
}

}  // namespace feder
