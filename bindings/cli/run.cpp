// feder run: a scene or a plain script without a window.
#include <fmt/format.h>

#include <csignal>
#include <cstdio>

#include "cli/command.h"
#include "cli/progress.h"
#include "cli/session.h"
#include "cli/summary.h"

namespace feder::cli {
namespace {

volatile std::sig_atomic_t interrupted = 0;

// While it lives, the first ctrl-C ends the run and its summary is still printed; the second one kills.
class Interrupt {
 public:
  Interrupt() {
    interrupted = 0;
    struct sigaction action = {};
    action.sa_handler = [](int) { interrupted = 1; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(SIGINT, &action, &before_);
  }
  ~Interrupt() { sigaction(SIGINT, &before_, nullptr); }

 private:
  struct sigaction before_ = {};
};

class Run final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("SCENE", scene_, "a .lua or .yaml file");
    a.require("SCENE");
    a.text("--seconds", seconds_, "simulated time (default: what the scene says, else 10)");
    a.flag("--check", check_, "run the scene's check at the end; exit status 1 when it fails");
    a.text("--record", record_, "write a recording (not in this version)");
    a.text("--export", export_, "write an animation (not in this version)");
  }

  int run(const Options& options) override {
    if (!record_.empty()) throw Failure(kUsage, "feder run: this version writes no recordings (--record)");
    if (!export_.empty()) throw Failure(kUsage, "feder run: this version exports nothing (--export)");
    lua::HostOptions host = host_options(options);
    // stdout belongs to the JSON value
    if (options.json) host.print = [](std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); };
    const double wanted = seconds_.empty() ? -1 : read_number(seconds_, "--seconds");
    Session session(std::move(host), [](const std::string& line) {
      std::fflush(stdout);
      fmt::print(stderr, "{}\n", line);
    });
    session.load(scene_);
    if (session.is_scene()) step_scene(session, wanted, options);
    return finish(session, options);
  }

 private:
  void step_scene(Session& session, double wanted, const Options& options) {
    const double own = session.script().seconds();
    const double seconds = wanted >= 0 ? wanted : own > 0 ? own : 10;
    const std::uint64_t steps = session.steps_for(seconds);
    const Interrupt guard;
    Progress progress(!options.quiet);
    for (std::uint64_t i = 0; i < steps && !interrupted; ++i) {
      session.step();
      const double time = session.world()->time();
      if (progress.due())
        progress.show(seconds > 0 ? time / seconds : 1, fmt::format("{:.2f} / {:g} s", time, seconds));
    }
  }

  int finish(Session& session, const Options& options) {
    lua::CheckResult result;
    if (check_ && !interrupted) result = run_check(session);
    Summary summary = summarize(session);
    summary.interrupted = interrupted != 0;
    if (options.json) {
      report::Json json = summary_json(summary);
      if (check_) json["check"] = check_json(result);
      std::fputs(report::to_text(json).c_str(), stdout);
    } else if (!options.quiet) {
      std::fputs(summary_text(summary).c_str(), stdout);
      if (check_) fmt::print("  check   {} held, {} failed\n", result.passed, result.failures.size());
    }
    std::fflush(stdout);
    for (const auto& failure : result.failures) fmt::print(stderr, "{}: {}\n", failure.where, failure.message);
    if (!summary.finite) fmt::print(stderr, "{}: the state is not finite\n", scene_);
    if (summary.interrupted) return kInterrupted;
    return summary.finite && summary.handler_errors.empty() && result.failures.empty() ? kPass : kFailed;
  }

  lua::CheckResult run_check(Session& session) {
    try {
      lua::CheckResult result = session.script().check();
      if (!result.has_check) throw Failure(kFailed, scene_ + ": --check: this scene has no check");
      return result;
    } catch (const lua::ScriptError& e) {
      throw Failure(kFailed, e.what());
    }
  }

  static report::Json check_json(const lua::CheckResult& result) {
    report::Json failures = report::Json::array();
    for (const auto& f : result.failures) failures.push_back({{"where", f.where}, {"message", f.message}});
    return {{"passed", result.passed}, {"failed", result.failures.size()}, {"failures", failures}};
  }

  std::string scene_, seconds_, record_, export_;
  bool check_ = false;
};

}  // namespace

Row cli_run() {
  return {"run", "runs a scene without a window and prints a summary",
          [] { return std::unique_ptr<Command>(new Run); }};
}

}  // namespace feder::cli
