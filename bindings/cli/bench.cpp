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
  std::string scene, title, hash, profile;
  std::vector<double> runs;  // ms per step, sorted
  int threads = 1;
  std::size_t bodies = 0;
  bool handlers_failed = false;

  double median() const {
    const std::size_t n = runs.size();
    return n % 2 ? runs[n / 2] : (runs[n / 2 - 1] + runs[n / 2]) / 2;
  }
};

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
      const Measured m = measure(scene, options);
      failed = failed || m.handlers_failed;
      all.push_back(json(m, before));
      if (!options.json) print(m, all.back(), options.quiet);
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
    m.scene = scene;
    for (int i = 0; i < runs_; ++i) {
      Session session(silent_host_options(options), nullptr, scene);
      if (!session.is_scene())
        throw Failure(kFailed, scene + ": bench needs a scene (a script that returns feder.scene{...})");
      session.step();
      World& world = *session.world();
      world.reset_profile();
      const std::uint64_t start = clock_nanoseconds();
      for (int k = 0; k < steps_ && session.goes_on(); ++k) session.script().step();
      m.runs.push_back(static_cast<double>(clock_nanoseconds() - start) * 1e-6 / steps_);
      session.need_to_go_on();
      if (i + 1 < runs_) continue;
      m.title = session.title();
      m.hash = hash_text(world.hash());
      m.threads = world.desc().threads;
      m.bodies = world.objects().count(kBodyKind);
      m.profile = profile_text(session, static_cast<std::uint64_t>(steps_));
      for (const auto& e : session.script().handler_errors()) {
        m.handlers_failed = true;
        print_error(error_text(e));
      }
    }
    std::ranges::sort(m.runs);
    return m;
  }

  report::Json json(const Measured& m, const report::Json& before) const {
    report::Json row = {{"scene", m.scene},
                        {"title", m.title},
                        {"ms_per_step", {{"median", m.median()}, {"min", m.runs.front()}, {"max", m.runs.back()}}},
                        {"threads", m.threads},
                        {"bodies", m.bodies},
                        {"runs", runs_},
                        {"steps", steps_},
                        {"real", kRealName},
                        {"hash", m.hash}};
    for (const auto& was : before) {
      if (!was.is_object() || was.value("scene", "") != m.scene || !was.contains("ms_per_step")) continue;
      const double median = was["ms_per_step"].value("median", 0.0);
      if (median > 0) row["compared"] = {{"median", median}, {"ratio", m.median() / median}};
    }
    return row;
  }

  void print(const Measured& m, const report::Json& row, bool quiet) const {
    fmt::print("{}: {:.4f} ms/step (min {:.4f}, max {:.4f}; {} runs of {} steps), {} bodies, {} thread{}\n", m.scene,
               m.median(), m.runs.front(), m.runs.back(), runs_, steps_, m.bodies, m.threads,
               m.threads == 1 ? "" : "s");
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
