// feder test: scenes with a check and *_test.lua scripts, here or in a process of their own.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "cli/command.h"
#include "cli/isolate.h"
#include "cli/scene_files.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/test_file.h"

namespace feder::cli {
namespace {

using report::TestResult;
using report::TestStatus;

// Folders also hold modules and material tables.
bool looks_like_test(const std::string& file) { return is_plain_test(file) || looks_like_scene(file, ".scene"); }

class Test final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("PATHS", paths_, "files and folders (default: scenes)");
    a.text("--filter", filter_, "only files whose path contains this text");
    a.text("--junit", junit_, "also write the results as JUnit XML to this file");
    a.flag("--tap", tap_, "print TAP version 13");
    a.flag("--isolate,!--no-isolate", isolate_,
           "run the tests in a process of their own, so that a crash is one failed test (default when CI is set)");
    a.hidden_flag("--worker", worker_);
  }

  int run(const Options& options) override {
    host_options(options);  // complain about the options before the first test
    if (tap_ && options.json) throw Failure(kUsage, "feder test: choose one of --tap and --json");
    if (paths_.empty()) paths_ = {"scenes"};
    std::vector<std::string> files = find_files(paths_, looks_like_test);
    std::erase_if(files, [&](const std::string& f) { return f.find(filter_) == std::string::npos; });
    const bool lines = !tap_ && !options.json;
    const StopSignals signals;
    if (worker_) return work(files, options);
    std::vector<TestResult> results;
    const auto take = [&](TestResult result) {
      results.push_back(std::move(result));
      if (lines) print(results.back(), options.quiet);
    };
    if (isolate_) {
      run_isolated(files, worker_arguments(options), take);
    } else {
      for (const std::string& file : files) {
        if (stop_flag() && stop_reason() != StopReason::timeout) break;
        take(run_test(file, options));
      }
    }
    const bool stopped = stop_reason() == StopReason::interrupt || stop_reason() == StopReason::terminate;
    if (stopped) fmt::print(stderr, "feder test: interrupted, {} of {} tests ran\n", results.size(), files.size());
    const int status = finish(results, options);
    return stopped ? stop_status() : status;
  }

 private:
  // The child of an isolated run.
  static int work(const std::vector<std::string>& files, const Options& options) {
    for (const std::string& file : files) {
      send_line({{"start", file}});
      send_line(report::written(run_test(file, options)));
      if (stop_flag() && stop_reason() != StopReason::timeout) return stop_status();
    }
    return kPass;
  }

  static std::vector<std::string> worker_arguments(const Options& o) {
    std::vector<std::string> words;
    add_scene_options(words, o);
    add_options(words, {{"--seed", o.seed}, {"--limit", o.limit}, {"--memory", o.memory}, {"--timeout", o.timeout}});
    return words;
  }

  static void print(const TestResult& r, bool quiet) {
    const bool failed = r.status == TestStatus::failed;
    if (quiet && !failed) return;
    const char* const word = failed ? "FAIL" : r.status == TestStatus::skipped ? "skip" : "ok";
    std::string detail = r.notice;
    if (r.status == TestStatus::passed && r.checks) detail = fmt::format("{} checks", r.checks);
    fmt::print("{:<4} {:8.3f} s  {}{}\n", word, r.seconds, r.name, detail.empty() ? "" : " (" + detail + ")");
    constexpr std::size_t kShown = 10;  // a check in a loop fails for every body
    for (std::size_t i = 0; i < std::min(kShown, r.failures.size()); ++i)
      fmt::print("{}: {}\n", r.failures[i].where.empty() ? r.name : r.failures[i].where, r.failures[i].message);
    if (r.failures.size() > kShown) fmt::print("{}: and {} more failures\n", r.name, r.failures.size() - kShown);
    if (failed && !r.output.empty())
      fmt::print("--- printed by {}\n{}{}", r.name, r.output, r.output.ends_with('\n') ? "" : "\n");
    std::fflush(stdout);
  }

  int finish(const std::vector<TestResult>& results, const Options& options) const {
    if (!junit_.empty()) {
      std::ofstream out(junit_, std::ios::binary);
      out << report::junit_text(results);
      if (!out.flush()) throw Failure(kUsage, junit_ + ": cannot be written");
    }
    const report::TestCounts counts = report::count(results);
    if (options.json) {
      print_json(report::test_json(results));
    } else {
      if (tap_) std::fputs(report::tap_text(results).c_str(), stdout);
      fmt::print("{}{} passed, {} failed, {} skipped\n", tap_ ? "# " : "", counts.passed, counts.failed,
                 counts.skipped);
    }
    if (std::ranges::any_of(results, [](const TestResult& r) { return r.exceeded; })) return kBudget;
    const bool unloaded = std::ranges::any_of(results, [](const TestResult& r) { return !r.loaded; });
    if (unloaded) return kLoadError;
    if (counts.failed) return kFailed;
    if (counts.passed == 0) {
      std::fflush(stdout);
      fmt::print(stderr, "feder test: nothing ran\n");
      return kNothingRan;
    }
    return kPass;
  }

  std::vector<std::string> paths_;
  std::string filter_, junit_;
  bool tap_ = false, worker_ = false;
  bool isolate_ = std::getenv("CI") != nullptr;
};

}  // namespace

Row cli_test() { return command_row<Test>("test", "runs scenes that have a check, and *_test.lua scripts"); }

}  // namespace feder::cli
