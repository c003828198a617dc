// feder bench: wall time per step. Each run is a fresh scene; its first step, which makes room, is not counted.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

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
  bool interrupted = false;  // fewer runs than asked for; none: there is no row
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
    a.text("--compare", compare_, "a file that bench --json wrote: prints the ratio to its minima");
    a.text("--fail-above", fail_above_,
           "PERCENT: exit status 1 when a scene's minimum is more than that above --compare, or not in it");
  }

  int run(const Options& options) override {
    host_options(options);
    if (!fail_above_.empty() && compare_.empty()) throw Failure(kUsage, "feder bench: --fail-above needs --compare");
    const double allowed = fail_above_.empty() ? INFINITY : read_number(fail_above_, "--fail-above");
    const StopSignals signals;
    report::Json before = report::Json::array();
    if (!compare_.empty()) before = read_before();
    report::Json all = report::Json::array();
    bool failed = false;
    for (const std::string& scene : scenes_) {
      if (stop_flag()) break;
      Measured m = measure(scene, options);
      if (m.row.empty()) break;
      compare(m.row, before);
      failed = failed || m.handlers_failed;
      if (!m.interrupted && !holds(m.row, allowed)) failed = true;
      if (!options.json) print(m, options.quiet);
      all.push_back(std::move(m.row));
    }
    if (options.json) print_json(all.size() == 1 ? all[0] : all);
    if (!stop_flag()) return failed ? kFailed : kPass;
    print_error(fmt::format("feder bench: {}, {} of {} scenes were measured", stop_text(), all.size(), scenes_.size()));
    return stop_status();
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
    for (int i = 0; i < runs_ && !m.interrupted; ++i) {
      try {
        Session session(silent_host_options(options), nullptr, scene);
        const double ms = time_run(session, scene);
        runs.push_back(ms);
        describe(session, scene, m);
      } catch (const Failure&) {
        // what was measured so far is kept
        if (stop_reason() != StopReason::interrupt && stop_reason() != StopReason::terminate) throw;
        m.interrupted = true;
      }
    }
    if (runs.empty()) return m;
    std::ranges::sort(runs);
    m.row["ms_per_step"] = {{"min", runs.front()}, {"median", median(runs)}, {"max", runs.back()}};
    m.row["runs"] = runs.size();
    if (m.interrupted) m.row["interrupted"] = true;
    return m;
  }

  // ms per step.
  double time_run(Session& session, const std::string& scene) const {
    if (!session.is_scene())
      throw Failure(kFailed, scene + ": bench needs a scene (a script that returns feder.scene{...})");
    session.step();
    session.world()->reset_profile();
    const std::uint64_t start = clock_nanoseconds();
    for (int k = 0; k < steps_ && session.goes_on(); ++k) session.script().step();
    const double ms = static_cast<double>(clock_nanoseconds() - start) * 1e-6 / steps_;
    session.need_to_go_on();
    return ms;
  }

  // All runs end alike: what the last one says.
  void describe(Session& session, const std::string& scene, Measured& m) const {
    World& world = *session.world();
    m.row = {{"scene", scene},
             {"title", session.title()},
             {"ms_per_step", nullptr},
             {"threads", world.desc().threads},
             {"bodies", world.objects().count(kBodyKind)},
             {"runs", 0},
             {"steps", steps_},
             {"real", kRealName},
             {"hash", hash_text(world.hash())}};
    m.profile = profile_text(session, static_cast<std::uint64_t>(steps_));
    const auto& errors = session.script().handler_errors();
    if (!std::exchange(m.handlers_failed, !errors.empty()))
      for (const auto& e : errors) print_error(error_text(e));
  }

  void compare(report::Json& row, const report::Json& before) const {
    try {
      for (const auto& was : before) {
        if (!was.is_object() || was.value("scene", "") != row["scene"] || !was.contains("ms_per_step")) continue;
        const double then = was["ms_per_step"].value("min", 0.0), now = row["ms_per_step"]["min"];
        if (then > 0) row["compared"] = {{"min", then}, {"ratio", now / then}};
      }
    } catch (const report::Json::exception&) {
      throw Failure(kUsage, "--compare: {}: not what bench --json writes", compare_);
    }
  }

  // --fail-above: as fast as before?
  bool holds(const report::Json& row, double allowed) const {
    if (std::isinf(allowed)) return true;
    const std::string scene = row["scene"];
    if (!row.contains("compared")) {
      print_error(fmt::format("{}: --fail-above: not in {}", scene, compare_));
      return false;
    }
    const double slower = 100 * (row["compared"]["ratio"].get<double>() - 1);
    if (slower <= allowed) return true;
    print_error(fmt::format("{}: {:.1f} % slower than in {}, more than {:g} %", scene, slower, compare_, allowed));
    return false;
  }

  void print(const Measured& m, bool quiet) const {
    const report::Json &row = m.row, &ms = row["ms_per_step"];
    const int threads = row["threads"];
    fmt::print("{}: min {:.4f} ms/step (median {:.4f}, max {:.4f}; {} runs of {} steps), {} bodies, {} thread{}\n",
               row["scene"].get<std::string>(), ms["min"].get<double>(), ms["median"].get<double>(),
               ms["max"].get<double>(), row["runs"].get<std::size_t>(), steps_, row["bodies"].get<std::size_t>(),
               threads, threads == 1 ? "" : "s");
    if (row.contains("compared")) {
      fmt::print("  {:.3f} x the {:.4f} ms/step of {}\n", row["compared"]["ratio"].get<double>(),
                 row["compared"]["min"].get<double>(), compare_);
    } else if (!compare_.empty()) {
      fmt::print("  not in {}\n", compare_);
    }
    if (!quiet) fmt::print("{}", m.profile);
    std::fflush(stdout);
  }

  std::vector<std::string> scenes_;
  std::string compare_, fail_above_;
  int runs_ = 5, steps_ = 200;
};

}  // namespace

Row cli_bench() { return command_row<Bench>("bench", "measures ms/step: minimum, median and maximum of several runs"); }

}  // namespace feder::cli
