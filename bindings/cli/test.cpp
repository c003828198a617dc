// feder test: scenes with a check and *_test.lua scripts, here or in a process of their own.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>

#include "cli/command.h"
#include "cli/isolate.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/test_artifacts.h"
#include "cli/test_file.h"
#include "cli/test_print.h"
#include "cli/test_watch.h"

namespace feder::cli {
namespace {

using report::TestResult;
using report::TestStatus;
using Results = std::vector<TestResult>;

// A format writes all results at the end; TAP to stdout comes test by test.
struct Format {
  const char* name;
  std::string (*text)(const Results& results);
};
std::string tap_text(const Results& results) {
  std::string out = report::tap_head(results.size());
  for (std::size_t i = 0; i < results.size(); ++i) out += report::tap_line(results[i], i + 1);
  return out;
}
constexpr Format kFormats[] = {
    {"text", nullptr},
    {"tap", tap_text},
    {"junit", report::junit_text},
    {"json", [](const Results& r) { return report::to_text(report::test_json(r)); }},
    {"github", report::github_text},
    {"csv", report::csv_text},
};

// Where a format goes; an empty file is stdout.
struct Output {
  const Format* format;
  std::string file;
};

Output read_output(const std::string& given) {
  const std::size_t equals = given.find('=');
  const std::string name = given.substr(0, equals);
  std::vector<std::string> known;
  for (const Format& f : kFormats) {
    if (name == f.name) return {&f, equals == std::string::npos ? "" : given.substr(equals + 1)};
    known.emplace_back(f.name);
  }
  throw Failure(kUsage, "--format: unknown format '{}'{}; known: {}", name, did_you_mean("; ", name, known),
                fmt::join(known, ", "));
}

void write_file(const std::string& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw Failure(kUsage, file + ": cannot be written");
}

bool runs_in_ci() {
  const char* const ci = std::getenv("CI");
  return ci && *ci;
}

class Test final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("PATHS", choice_.paths, "files, folders, and files with values: 'tower.lua[height=3]' (default: scenes)");
    a.text("--filter", choice_.filter, "only files whose path contains this text");
    a.list("--tag", choice_.tags, "only files with this word in their line '-- tags: ...'; ~word: without it");
    a.text("--shard", choice_.shard, "I/N: the I-th of N shares");
    a.list("--sweep", choice_.sweeps, "NAME=A,B,C or NAME=FROM:TO:STEP: a test for each value of a feder.param");
    a.flag("--shuffle", choice_.shuffle, "run in a random order; --seed decides it, else --order, else the clock");
    a.text("--order", order_, "seed of the order of --shuffle, as a shuffled run prints it");
    a.flag("--list", list_, "print the names and tags of the tests, run nothing");
    a.whole("--repeat", settings_.repeat, 1, 100000, "runs of each test, which must end in the same state");
    a.whole("--random", settings_.random, 0, 10000,
            "random draws of the parameters that each scene is tested with (default: what the scene says)");
    a.flag("--watch", watch_, "go on: run again what reads a file that was saved");
    declare_outputs(a);
    a.flag("--isolate,!--no-isolate", isolate_,
           "run the tests in a process of their own, so that a crash is one failed test (default when CI is set)");
    a.flag("--allow-empty", allow_empty_, "exit status 0 when nothing ran");
    a.hidden_flag("--worker", worker_);
  }

  int run(const Options& options) override {
    host_options(options);  // complain about the options before the first test
    read_outputs(options);
    if (choice_.paths.empty()) choice_.paths = {"scenes"};
    if (settings_.update_golden && runs_in_ci())
      throw Failure(kUsage, "feder test: --update-golden: golden runs are not written where CI is set");
    settings_.coverage = !coverage_.empty();
    const StopSignals signals;
    if (worker_) return work(options);
    read_order(options);
    std::vector<TestCase> tests = choose_tests(choice_);
    if (list_) return list(tests, options.json);
    Results results = run_all(tests, options);
    while (watch_ && !stop_flag()) run_again(tests, results, options);
    const bool stopped = stop_reason() == StopReason::interrupt || stop_reason() == StopReason::terminate;
    if (stopped && !watch_)
      fmt::print(stderr, "feder test: interrupted, {} of {} tests ran\n", results.size(), tests.size());
    const int status = watch_ ? stop_status() : finish(results);
    return stopped ? stop_status() : status;
  }

 private:
  void declare_outputs(Arguments& a) {
    a.list("--format", formats_, "text, tap, junit, json, github or csv, to stdout; NAME=FILE: to a file");
    a.text("--output", output_, "file of the --format without one");
    a.text("--junit", junit_, "also write the results as JUnit XML to this file");
    a.flag("--tap", tap_, "print TAP version 13");
    a.text("--artifacts", artifacts_, "folder for what failed tests leave: output, picture of the last frame");
    a.text("--coverage", coverage_, "count the lines of scripts that ran, and write them to this file (LCOV)");
    a.flag("--update-golden", settings_.update_golden, "write golden runs beside their scenes, and print what changed");
  }

  // All ways to name a format, in one list. One of them has stdout.
  void read_outputs(const Options& options) {
    for (const std::string& given : formats_) outputs_.push_back(read_output(given));
    if (tap_) outputs_.push_back(read_output("tap"));
    if (options.json) outputs_.push_back(read_output("json"));
    if (!junit_.empty()) outputs_.push_back(read_output("junit=" + junit_));
    const auto on_stdout = [](const Output& o) { return o.file.empty(); };
    if (!output_.empty()) {
      const auto at = std::ranges::find_if(outputs_, on_stdout);
      if (at == outputs_.end()) throw Failure(kUsage, "feder test: --output: there is no --format without a file");
      at->file = output_;
    }
    // annotations of GitHub are lines among others
    const auto first = std::ranges::find_if(
        outputs_, [&](const Output& o) { return on_stdout(o) && std::string_view(o.format->name) != "github"; });
    stdout_ = first == outputs_.end() ? &kFormats[0] : first->format;
    for (const Output& o : outputs_)
      if (on_stdout(o) && std::string_view(o.format->name) != "github" && o.format != stdout_)
        throw Failure(kUsage, "feder test: choose one of --{} and --{}, or give one a file", stdout_->name,
                      o.format->name);
    printer_ = TestPrinter(options.quiet, command_text(scene_arguments(options)));
  }

  void read_order(const Options& options) {
    if (!order_.empty()) choice_.shuffle = true;
    if (!choice_.shuffle) return;
    const std::string seed = order_.empty() ? options.seed : order_;
    choice_.order = seed.empty() ? std::random_device()() : static_cast<std::uint64_t>(read_number(seed, "--order"));
    if (prints_lines()) fmt::print("order: --order {}\n", choice_.order);
  }

  int list(const std::vector<TestCase>& tests, bool json) const {
    report::Json rows = report::Json::array();
    for (const TestCase& test : tests) {
      const std::vector<std::string> tags = tags_of(test.file);
      rows.push_back({{"name", test.name()}, {"file", test.file}, {"set", test.set}, {"tags", tags}});
      if (!json) fmt::print("{}{}{}\n", test.name(), tags.empty() ? "" : "  ", fmt::join(tags, " "));
    }
    if (json) print_json(rows);
    return tests.empty() && !allow_empty_ ? kNothingRan : kPass;
  }

  // The child of an isolated run.
  int work(const Options& options) {
    for (const std::string& name : choice_.paths) {
      settings_.begun = [&name] { send_line({{"start", name}}); };
      send_line(report::written(run_test(read_case(name), options, settings_)));
      if (stop_flag() && stop_reason() != StopReason::timeout) return stop_status();
    }
    return kPass;
  }

  static std::vector<std::string> scene_arguments(const Options& o) {
    std::vector<std::string> words;
    add_scene_options(words, o);
    add_options(words, {{"--seed", o.seed}, {"--limit", o.limit}, {"--memory", o.memory}, {"--timeout", o.timeout}});
    return words;
  }

  std::vector<std::string> worker_arguments(const Options& o) const {
    std::vector<std::string> words = scene_arguments(o);
    add_options(words, {{"--repeat", std::to_string(settings_.repeat)}, {"--coverage", coverage_}});
    if (settings_.random >= 0) add_options(words, {{"--random", std::to_string(settings_.random)}});
    if (settings_.update_golden) words.emplace_back("--update-golden");
    return words;
  }

  bool prints_lines() const { return stdout_->text == nullptr; }

  // Runs tests, and prints each as soon as it is done.
  Results run_all(const std::vector<TestCase>& tests, const Options& options) {
    Results results;
    const bool tap = stdout_->text == tap_text;
    if (tap) std::fputs(report::tap_head(tests.size()).c_str(), stdout);
    const auto take = [&](TestResult result) {
      if (!artifacts_.empty() && result.status == TestStatus::failed && !worker_) {
        const std::string files = save_artifacts(artifacts_, result, options);
        result.notice += (result.notice.empty() ? "" : "; ") + ("left " + files);
      }
      results.push_back(std::move(result));
      if (prints_lines()) printer_.print(results.back());
      if (tap) std::fputs(report::tap_line(results.back(), results.size()).c_str(), stdout);
      std::fflush(stdout);
      write_files(results);
    };
    if (isolate_) {
      std::vector<std::string> names;
      for (const TestCase& test : tests) names.push_back(test.name());
      run_isolated(names, worker_arguments(options), take);
      return results;
    }
    for (const TestCase& test : tests) {
      if (stop_flag() && stop_reason() != StopReason::timeout) break;
      take(run_test(test, options, settings_));
    }
    return results;
  }

  // --watch: waits for a save, runs the tests that read the file.
  void run_again(const std::vector<TestCase>& tests, Results& results, const Options& options) {
    std::vector<std::string> files;
    for (const TestCase& test : tests) files.push_back(test.file);
    for (const TestResult& r : results) files.insert(files.end(), r.files.begin(), r.files.end());
    report_counts(results);
    watcher_.set(files);
    const std::set<std::string> changed = watcher_.wait();
    std::vector<TestCase> touched;
    for (const TestCase& test : tests) {
      const auto reads = [&](const TestResult& r) {
        return r.name == test.name() &&
               std::ranges::any_of(r.files, [&](const auto& f) { return changed.contains(f); });
      };
      if (changed.contains(test.file) || std::ranges::any_of(results, reads)) touched.push_back(test);
    }
    for (TestResult& r : run_all(touched, options)) {
      const auto at = std::ranges::find(results, r.name, &TestResult::name);
      if (at == results.end())
        results.push_back(std::move(r));
      else
        *at = std::move(r);
    }
  }

  // Files are rewritten after each test: a run that is killed leaves what it had.
  void write_files(const Results& results) const {
    for (const Output& o : outputs_)
      if (!o.file.empty() && o.format->text) write_file(o.file, o.format->text(results));
    if (!coverage_.empty()) write_file(coverage_, report::lcov_text(results));
  }

  void report_counts(const Results& results) const {
    const report::TestCounts counts = report::count(results);
    if (prints_lines()) return printer_.close(counts);
    if (stdout_->text == tap_text)
      fmt::print("# {} passed, {} failed, {} skipped\n", counts.passed, counts.failed, counts.skipped);
  }

  int finish(const Results& results) const {
    write_files(results);
    for (const Output& o : outputs_)
      if (o.file.empty() && o.format->text && o.format->text != tap_text)
        std::fputs(o.format->text(results).c_str(), stdout);
    report_counts(results);
    std::fflush(stdout);
    if (std::ranges::any_of(results, [](const TestResult& r) { return r.exceeded; })) return kBudget;
    if (std::ranges::any_of(results, [](const TestResult& r) { return !r.loaded; })) return kLoadError;
    const report::TestCounts counts = report::count(results);
    if (counts.failed) return kFailed;
    if (counts.passed > 0 || allow_empty_) return kPass;
    fmt::print(stderr, "feder test: nothing ran\n");
    return kNothingRan;
  }

  TestChoice choice_;
  TestSettings settings_;
  std::vector<std::string> formats_;
  std::vector<Output> outputs_;
  const Format* stdout_ = &kFormats[0];
  std::string order_, output_, junit_, artifacts_, coverage_;
  TestPrinter printer_{false, ""};
  TestWatch watcher_;
  bool list_ = false, watch_ = false, tap_ = false, worker_ = false, allow_empty_ = false;
  bool isolate_ = runs_in_ci();
};

}  // namespace

Row cli_test() { return command_row<Test>("test", "runs scenes that have a check, and *_test.lua scripts"); }

}  // namespace feder::cli
