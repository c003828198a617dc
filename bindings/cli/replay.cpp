// feder replay: does again what a recording holds, without its script, and compares the state.
#include <cstdio>

#include "cli/progress.h"
#include "cli/recording.h"
#include "cli/stop.h"
#include "cli/summary.h"

namespace feder::cli {
namespace {

class ReplayRun final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("FILE", file_, "a recording, from feder run --record");
    a.require("FILE");
    a.whole("--steps", steps_, 0, 1000000000, "only so many steps of each world");
    a.flag("--commands", commands_, "print what was done to the worlds, and before which step");
    a.flag("--facts", facts_, "print what the recording knows of its run, with the files of the scene, and end");
  }

  bool runs_scenes() const override { return false; }
  bool makes_worlds() const override { return true; }

  int run(const Options& options) override {
    const Recording recording = read_recording(file_);
    if (facts_) return print_facts(recording, options);
    if (recording.world_count() == 0) throw Failure(kNothingRan, "{}: the recording has no world", file_);
    const StopSignals signals;
    if (!options.json && !options.quiet)
      fmt::print("{}\n  of      {}, {}\n", file_, recording.fact("scene"), recorded_by(recording));
    report::Json worlds = report::Json::array();
    int status = kPass;
    for (std::size_t k = 0; k < recording.world_count() && stop_reason() == StopReason::none; ++k)
      status = std::max(status, run_world(recording, k, options, worlds));
    if (options.json)
      print_json({{"file", file_},
                  {"scene", recording.fact("scene")},
                  {"recorded_by", recorded_by(recording)},
                  {"ended", recording.how()},
                  {"interrupted", stop_reason() != StopReason::none},
                  {"worlds", worlds}});
    return stop_reason() != StopReason::none ? stop_status() : status;
  }

 private:
  int run_world(const Recording& recording, std::size_t number, const Options& options, report::Json& worlds) {
    const std::unique_ptr<Replay> owned = make_replay(file_, recording, number, options);
    Replay& replay = *owned;
    std::vector<RecordedCommand> list;
    std::uint64_t done = 0, commands = 0;
    Progress progress(!options.quiet);
    const std::uint64_t all = recording.steps(number);
    bool more = true;
    while (more && stop_reason() == StopReason::none && (steps_ < 0 || done < static_cast<std::uint64_t>(steps_))) {
      more = step_replay(file_, replay, &list);
      done += more;
      commands += list.size();
      if (commands_) print_commands(number, done + !more, list);
      if (progress.due())
        progress.show(static_cast<double>(done) / static_cast<double>(std::max<std::uint64_t>(1, all)),
                      fmt::format("{} / {} steps", done, all));
    }
    const std::string hash = hash_text(replay.world().hash());
    if (options.json) {
      report::Json parted = nullptr;
      if (!replay.same()) parted = replay.parted();
      worlds.push_back({{"steps", done},
                        {"commands", commands},
                        {"hash", hash},
                        {"same", replay.same()},
                        {"parted", parted},
                        {"threads", replay.world().desc().threads}});
    } else if (!options.quiet) {
      fmt::print("  world {} {} of {} steps, {} commands: {}\n", number + 1, done, all, commands,
                 replay.same() ? "as recorded, hash " + hash : "not as recorded");
      std::fflush(stdout);
    }
    if (replay.same()) return kPass;
    print_error(fmt::format("{}: world {} is not as recorded from step {} on (by {})", file_, number + 1,
                            replay.parted(), recorded_by(recording)));
    return kFailed;
  }

  static void print_commands(std::size_t number, std::uint64_t step, const std::vector<RecordedCommand>& list) {
    for (const RecordedCommand& c : list) fmt::print("world {} step {}: {}\n", number + 1, step, c.text);
  }

  int print_facts(const Recording& recording, const Options& options) const {
    report::Json json = report::Json::array();
    for (const auto& [name, text] : recording.facts()) {
      if (options.json)
        json.push_back({{"name", name}, {"text", text}});
      else
        fmt::print("{}:{}{}\n", name, text.find('\n') == std::string::npos ? " " : "\n", text);
    }
    if (options.json) print_json({{"facts", json}, {"ended", recording.how()}});
    return kPass;
  }

  std::string file_;
  int steps_ = -1;
  bool commands_ = false, facts_ = false;
};

}  // namespace

Row cli_replay() { return command_row<ReplayRun>("replay", "does again what a recording holds, and compares"); }

}  // namespace feder::cli
