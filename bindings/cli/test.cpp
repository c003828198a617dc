// feder test: scenes with a check and *_test.lua scripts, here or in a process of their own.
#include <algorithm>
#include <cstdio>
#include <random>

#include "cli/command.h"
#include "cli/isolate.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/test_artifacts.h"
#include "cli/test_file.h"
#include "cli/test_output.h"
#include "cli/test_watch.h"

namespace feder::cli {
namespace {

using report::TestResult;
using report::TestStatus;
using Results = std::vector<TestResult>;

class Test final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("PATHS", choice_.paths, "files, folders, and files with values: 'tower.lua[height=3]' (default: scenes)");
    a.text("--filter", choice_.filter, "only files whose path contains this text");
    a.list("--tag", choice_.tags, "only files with this word in their line '-- tags: ...'; ~word: without it");
    a.text("--shard", choice_.shard, "I/N: the I-th of N shares");
    a.list("--sweep", choice_.sweeps, "NAME=A,B,C or NAME=FROM:TO:STEP: a test for each value of a feder.param");
    a.flag("--shuffle", choice_.shuffle, "run in a random order, which --order decides, else --seed, else the clock");
    a.text("--order", order_, "seed of the order of --shuffle, as a shuffled run prints it");
    a.flag("--list", list_, "print the names and tags of the tests, run nothing");
    a.whole("--repeat", settings_.repeat, 1, 100000, "runs of each test, which must end in the same state");
    a.flag("--replay", settings_.replay, "record each run in memory; its replay, without Lua, must have every state");
    a.whole("--random", settings_.random, 0, 10000,
            "random draws of the parameters that each scene is tested with, behind the counter-examples that are kept "
            "(default: what the scene says; 0: neither)");
    a.flag("--watch", watch_, "go on: run again what reads a file that was saved");
    output_.declare(a);
    a.text("--artifacts", artifacts_,
           "folder for what failed tests leave: output, last events, picture of the last frame");
    a.flag("--update-golden", settings_.update_golden, "write golden runs beside their scenes, and print what changed");
    a.flag("--isolate,!--no-isolate", isolate_,
           "run the tests in a process of their own, so that a crash is one failed test (default when CI is set)");
    a.flag("--allow-empty", allow_empty_, "exit status 0 when nothing ran");
    a.hidden_flag("--worker", worker_);
  }

  int run(const Options& options) override {
    host_options(options);  // complain about the options before the first test
    output_.open(options);
    if (choice_.paths.empty()) choice_.paths = {"scenes"};
    if (settings_.update_golden && runs_in_ci())
      throw Failure(kUsage, "feder test: --update-golden: golden runs are not written where CI is set");
    settings_.events = !artifacts_.empty();
    settings_.coverage = !output_.coverage().empty();
    const StopSignals signals;
    if (worker_) return work(options);
    read_order(options);
    std::vector<TestCase> tests = choose_tests(choice_);
    if (list_) return list(tests, options.json);
    watcher_.set(files_of(tests, {}));
    Results results = run_all(tests, options);
    while (watch_ && !stop_flag()) run_again(tests, results, options);
    const bool stopped = stop_reason() == StopReason::interrupt || stop_reason() == StopReason::terminate;
    if (stopped && !watch_)
      fmt::print(stderr, "feder test: interrupted, {} of {} tests ran\n", results.size(), tests.size());
    const int status = watch_ ? stop_status() : finish(results);
    return stopped ? stop_status() : status;
  }

 private:
  void read_order(const Options& options) {
    if (!order_.empty()) choice_.shuffle = true;
    if (!choice_.shuffle) return;
    const std::string seed = order_.empty() ? options.seed : order_;
    choice_.order = seed.empty() ? std::random_device()() : static_cast<std::uint64_t>(read_number(seed, "--order"));
    const std::string line = fmt::format("order: --order {}", choice_.order);
    output_.prints_lines() ? fmt::print("{}\n", line) : print_error(line);
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
    add_options(words, {{"--repeat", std::to_string(settings_.repeat)},
                        {"--coverage", output_.coverage()},
                        {"--artifacts", artifacts_}});
    if (settings_.random >= 0) add_options(words, {{"--random", std::to_string(settings_.random)}});
    if (settings_.update_golden) words.emplace_back("--update-golden");
    if (settings_.replay) words.emplace_back("--replay");
    return words;
  }

  // What shows the failure again, to be pasted.
  std::string command_again(const TestResult& r, const Options& options) const {
    // command_text quotes spaces, and no brackets
    const bool quoted = r.name.find('[') != std::string::npos && r.name.find(' ') == std::string::npos;
    std::vector<std::string> words = {"feder", "test", quoted ? "'" + r.name + "'" : r.name};
    for (const std::string& set : r.drawn) add_options(words, {{"--set", set}});
    if (options.seed.empty()) add_options(words, {{"--seed", r.seed}});
    if (settings_.repeat > 1) add_options(words, {{"--repeat", std::to_string(settings_.repeat)}});
    for (const std::string& word : scene_arguments(options)) words.push_back(word);
    return command_text(words);
  }

  // Runs tests, and prints each as soon as it is done.
  Results run_all(const std::vector<TestCase>& tests, const Options& options) {
    Results results;
    output_.begin(tests.size());
    const auto take = [&](TestResult result) {
      if (result.status == TestStatus::failed) result.again = command_again(result, options);
      if (!artifacts_.empty() && result.status == TestStatus::failed) {
        const std::string files = save_artifacts(artifacts_, result, options);
        result.notice += (result.notice.empty() ? "" : "; ") + ("left " + files);
      }
      results.push_back(std::move(result));
      output_.add(results);
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

  static std::vector<std::string> files_of(const std::vector<TestCase>& tests, const Results& results) {
    std::vector<std::string> files;
    for (const TestCase& test : tests) files.push_back(test.file);
    for (const TestResult& r : results) files.insert(files.end(), r.files.begin(), r.files.end());
    return files;
  }

  // --watch: waits for a save, runs the tests that read the file.
  void run_again(const std::vector<TestCase>& tests, Results& results, const Options& options) {
    output_.count(results);
    watcher_.set(files_of(tests, results));
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
    output_.write_files(results);
  }

  int finish(const Results& results) const {
    output_.finish(results);
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
  TestOutput output_;
  TestWatch watcher_;
  std::string order_, artifacts_;
  bool list_ = false, watch_ = false, worker_ = false, allow_empty_ = false;
  bool isolate_ = runs_in_ci();
};

}  // namespace

Row cli_test() { return command_row<Test>("test", "runs scenes that have a check, and *_test.lua scripts"); }

}  // namespace feder::cli
