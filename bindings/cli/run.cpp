// feder run: a scene or a plain script without a window.
#include <algorithm>
#include <cstdio>
#include <optional>

#include "cli/command.h"
#include "cli/progress.h"
#include "cli/recording.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/summary.h"
#include "cli/trace.h"

namespace feder::cli {
namespace {

class Run final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("SCENE", scene_, "a .lua or .yaml file");
    a.require("SCENE");
    a.text("--seconds", seconds_, "simulated time (default: what the scene says, else 10)");
    a.whole("--steps", steps_, 0, 1000000000, "or so many steps");
    a.flag("--check", check_, "run the scene's check at the end; exit status 1 when it fails");
    a.text("--csv", csv_, "write time, energy, each feder.plot and --track to this file, a row per step");
    a.list(
        "--track", track_,
        "NAME: place, rotation and velocities of a body, or centre, box and velocity of what is made of points, into "
        "--csv; * and ? stand for any text and any character (may be repeated)");
    a.text("--record", record_, "write all that is done to the worlds to this file: see feder replay, feder diff");
    a.whole("--hash-every", hash_every_, 0, 1000000000, "steps between two hashes in --record (1); 0: none");
  }

  int run(const Options& options) override {
    if (csv_.empty() && !track_.empty()) throw Failure(kUsage, "feder run: --track needs --csv");
    lua::HostOptions host = host_options(options);
    // stdout belongs to the JSON value
    if (options.json) host.print = [](std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); };
    const double wanted = seconds_.empty() ? -1 : read_number(seconds_, "--seconds");
    if (wanted >= 0 && steps_ >= 0) throw Failure(kUsage, "feder run: expected --seconds or --steps, got both");
    std::optional<RecordFile> file;
    if (!record_.empty()) {
      file.emplace(record_, scene_, options, hash_every_ < 0 ? 1 : hash_every_);
      host.made = [&file](World& world) { file->recorder().add(world); };
    } else if (hash_every_ >= 0) {
      throw Failure(kUsage, "feder run: --hash-every needs --record");
    }
    Session session(std::move(host), print_error);
    const StopSignals signals;
    if (!csv_.empty()) trace_.emplace(csv_, track_);
    if (trace_) session.after_each_step([&](World& world) { trace_->record(session, world); });
    int status = load(session);
    if (session.is_scene() && trace_) trace_->record(session, *session.world());
    if (session.is_scene() && status == kPass) step_scene(session, wanted, options);
    if (status == kPass) status = report_end(session);
    status = finish(session, options, status);
    if (file)
      file->close(session.script().files(), status == kPass ? "finished" : fmt::format("exit status {}", status));
    return status;
  }

 private:
  // A plain script that was stopped has a world to sum up; other failures go on.
  int load(Session& session) {
    try {
      session.load(scene_);
    } catch (const Failure& e) {
      if (e.status() < kBudget || session.is_scene() || !session.world()) throw;
      print_error(e.what());
      return e.status();
    }
    return kPass;
  }

  // Why the steps ended early, unless a handler's error has reported it.
  int report_end(Session& session) const {
    const auto& errors = session.script().handler_errors();
    const bool reported = std::ranges::any_of(errors, [](const auto& e) { return e.limit != lua::Limit::none; });
    const int status = session.end_status();
    if (status != kPass && !reported) fmt::print(stderr, "{}: {}\n", scene_, stop_text());
    return status;
  }

  void step_scene(Session& session, double wanted, const Options& options) {
    const double own = session.script().seconds();
    const double given = steps_ >= 0 ? steps_ * session.world()->desc().dt : wanted;
    const double seconds = given >= 0 ? given : own > 0 ? own : 10;
    const std::uint64_t steps = steps_ >= 0 ? static_cast<std::uint64_t>(steps_) : session.steps_for(seconds);
    Progress progress(!options.quiet);
    for (std::uint64_t i = 0; i < steps && session.goes_on(); ++i) {
      session.step();
      const double time = session.world()->time();
      if (progress.due())
        progress.show(seconds > 0 ? time / seconds : 1, fmt::format("{:.2f} / {:g} s", time, seconds));
    }
  }

  // `status`: of what ended the run early, or kPass.
  int finish(Session& session, const Options& options, int status) {
    const int traced = close_trace(session);
    lua::CheckResult result;
    if (check_ && status == kPass) result = run_check(session);
    if (result.limit != lua::Limit::none) status = limit_status(result.limit);
    Summary summary = summarize(session);
    summary.interrupted = status != kPass;
    if (options.json) {
      report::Json json = summary_json(session, summary);
      if (check_) json["check"] = check_json(result);
      print_json(json);
    } else if (!options.quiet) {
      std::fputs(summary_text(session, summary).c_str(), stdout);
      if (check_) fmt::print("  check   {} held, {} failed\n", result.passed, result.failures.size());
    }
    std::fflush(stdout);
    for (const auto& failure : result.failures) fmt::print(stderr, "{}: {}\n", failure.where, failure.message);
    if (!summary.finite) fmt::print(stderr, "{}: the state is not finite\n", scene_);
    bool held = false;  // what was not finite has been stopped
    for (const Warning& w : session.warnings()) {
      if (w.code != "non_finite") continue;
      fmt::print(stderr, "{}: not finite on the way ({} x): {}\n", scene_, w.count, w.message);
      held = true;
    }
    if (status != kPass) return status;
    if (traced != kPass) return traced;
    return summary.finite && !held && session.script().handler_errors().empty() && result.failures.empty() ? kPass
                                                                                                           : kFailed;
  }

  // The status of it; what else there is to say goes on.
  int close_trace(Session& session) {
    try {
      const std::string wrong = trace_ ? trace_->close(session) : "";
      if (wrong.empty()) return kPass;
      print_error("feder run: " + wrong);
      return kUsage;
    } catch (const Failure& e) {
      print_error(e.what());
      return e.status();
    }
  }

  lua::CheckResult run_check(Session& session) {
    try {
      lua::CheckResult result = session.script().check();
      if (!result.has_check) throw Failure(kFailed, scene_ + ": --check: this scene has no check");
      return result;
    } catch (const lua::LimitError& e) {
      throw Failure(limit_status(e.limit()), limit_text(e.what(), e.limit()));
    } catch (const lua::ScriptError& e) {
      throw Failure(kFailed, e.what());
    }
  }

  static report::Json check_json(const lua::CheckResult& result) {
    report::Json failures = report::Json::array();
    for (const auto& f : result.failures) failures.push_back({{"where", f.where}, {"message", f.message}});
    return {{"passed", result.passed}, {"failed", result.failures.size()}, {"failures", failures}};
  }

  std::string scene_, seconds_, csv_, record_;
  int hash_every_ = -1;
  std::vector<std::string> track_;
  int steps_ = -1;
  bool check_ = false;
  std::optional<Trace> trace_;
};

}  // namespace

Row cli_run() { return command_row<Run>("run", "runs a scene without a window and prints a summary"); }

}  // namespace feder::cli
