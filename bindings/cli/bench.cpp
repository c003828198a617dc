// feder bench: wall time per step. Each run is a fresh scene; its first step, which makes room, is not counted.
#include <algorithm>
#include <cstdio>

#include "cli/command.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/summary.h"
#include "feder/profile.h"
#include "state/bodies.h"

namespace feder::cli {
namespace {

struct Measured {
  report::Json row;  // as --json prints it
  std::string profile;
  bool handlers_failed = false;
};

// Of sorted values.
double median(const std::vector<double>& values) {
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

class Bench final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("SCENE", scenes_, "one or more .lua or .yaml files");
    a.require("SCENE");
    a.whole("--runs", runs_, 1, 10000, "runs per scene (default 5)");
    a.whole("--steps", steps_, 1, 10000000, "steps per run after the first (default 200)");
    a.text("--compare", compare_, "a file that bench --json wrote: prints the ratio to its medians");
  }

  int run(const Options& options) override {
    host_options(options);
    const StopSignals signals;
    report::Json before = report::Json::array();
    if (!compare_.empty()) before = read_before();
    report::Json all = report::Json::array();
    bool failed = false;
    for (const std::string& scene : scenes_) {
      Measured m = measure(scene, options);
      compare(m.row, before);
      failed = failed || m.handlers_failed;
      if (!options.json) print(m, options.quiet);
      all.push_back(std::move(m.row));
    }
    if (options.json) print_json(all.size() == 1 ? all[0] : all);
    return failed ? kFailed : kPass;
  }

 private:
  report::Json read_before() const {
    try {
      const report::Json read = report::read_json(compare_);
      return read.is_array() ? read : report::Json::array({read});
    } catch (const std::runtime_error& e) {
      throw Failure(kUsage, std::string("--compare: ") + e.what());
    }
  }

  Measured measure(const std::string& scene, const Options& options) const {
    Measured m;
    std::vector<double> runs;  // ms per step
    for (int i = 0; i < runs_; ++i) {
      Session session(silent_host_options(options), nullptr, scene);
      if (!session.is_scene())
        throw Failure(kFailed, scene + ": bench needs a scene (a script that returns feder.scene{...})");
      session.step();
      World& world = *session.world();
      world.reset_profile();
      const std::uint64_t start = clock_nanoseconds();
      for (int k = 0; k < steps_ && session.goes_on(); ++k) session.script().step();
      runs.push_back(static_cast<double>(clock_nanoseconds() - start) * 1e-6 / steps_);
      session.need_to_go_on();
      if (i + 1 < runs_) continue;
      // the last run knows them all
      std::ranges::sort(runs);
      m.row = {{"scene", scene},
               {"title", session.title()},
               {"ms_per_step", {{"median", median(runs)}, {"min", runs.front()}, {"max", runs.back()}}},
               {"threads", world.desc().threads},
               {"bodies", world.objects().count(kBodyKind)},
               {"runs", runs_},
               {"steps", steps_},
               {"real", kRealName},
               {"hash", hash_text(world.hash())}};
      m.profile = profile_text(session, static_cast<std::uint64_t>(steps_));
      for (const auto& e : session.script().handler_errors()) {
        m.handlers_failed = true;
        print_error(error_text(e));
      }
    }
    return m;
  }

  static void compare(report::Json& row, const report::Json& before) {
    for (const auto& was : before) {
      if (!was.is_object() || was.value("scene", "") != row["scene"] || !was.contains("ms_per_step")) continue;
      const double then = was["ms_per_step"].value("median", 0.0), now = row["ms_per_step"]["median"];
      if (then > 0) row["compared"] = {{"median", then}, {"ratio", now / then}};
    }
  }

  void print(const Measured& m, bool quiet) const {
    const report::Json &row = m.row, &ms = row["ms_per_step"];
    const int threads = row["threads"];
    fmt::print("{}: {:.4f} ms/step (min {:.4f}, max {:.4f}; {} runs of {} steps), {} bodies, {} thread{}\n",
               row["scene"].get<std::string>(), ms["median"].get<double>(), ms["min"].get<double>(),
               ms["max"].get<double>(), runs_, steps_, row["bodies"].get<std::size_t>(), threads,
               threads == 1 ? "" : "s");
    if (row.contains("compared")) {
      fmt::print("  {:.3f} x the {:.4f} ms/step of {}\n", row["compared"]["ratio"].get<double>(),
                 row["compared"]["median"].get<double>(), compare_);
    } else if (!compare_.empty()) {
      fmt::print("  not in {}\n", compare_);
    }
    if (!quiet) fmt::print("{}", m.profile);
    std::fflush(stdout);
  }

  std::vector<std::string> scenes_;
  std::string compare_;
  int runs_ = 5, steps_ = 200;
};

}  // namespace

Row cli_bench() { return command_row<Bench>("bench", "measures ms/step: median, min and max of several runs"); }

}  // namespace feder::cli
