// feder test: scenes with a check and *_test.lua scripts, each in a Lua state and world of its own.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "base/profile.h"
#include "cli/command.h"
#include "cli/session.h"
#include "report/test_report.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;
using report::TestResult;
using report::TestStatus;

bool is_plain_test(const std::string& file) {
  const std::string stem = fs::path(file).stem().string();
  return file.ends_with(".lua") && (stem.ends_with("_test") || stem.starts_with("test_"));
}

// Folders also hold modules and material tables: a file counts when its text looks like a scene's.
bool looks_like_test(const std::string& file) {
  if (is_plain_test(file)) return true;
  if (file.ends_with(".lua")) return read_text(file).find(".scene") != std::string::npos;
  if (!is_yaml(file)) return false;
  const std::string text = "\n" + read_text(file);
  for (const char* key : {"\nbodies:", "\nnets:", "\ncloths:", "\nfluids:"})
    if (text.find(key) != std::string::npos) return true;
  return false;
}

std::vector<std::string> discover(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Failure(kUsage, path + ": no such file or folder");
    if (!fs::is_directory(path, ignored)) {
      files.push_back(path);
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(path))
      if (entry.is_regular_file() && looks_like_test(entry.path().string())) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

// "scene.lua:12: message" taken apart again.
report::TestFailure failure_from(const std::string& text, const std::string& file) {
  std::size_t at = text.starts_with(file) ? file.size() : text.find(':');
  if (at == std::string::npos || at >= text.size() || text[at] != ':') return {"", text};
  const std::size_t end = text.find_first_not_of("0123456789", at + 1);
  if (end == at + 1 || end == std::string::npos || text.compare(end, 2, ": ") != 0) return {"", text};
  return {text.substr(0, end), text.substr(end + 2)};
}

void step_and_check(Session& session, TestResult& result) {
  const double own = session.script().seconds();
  const std::uint64_t steps = session.steps_for(own > 0 ? own : 10);
  for (std::uint64_t i = 0; i < steps; ++i) session.step();
  const lua::CheckResult check = session.script().check();
  result.checks = check.passed;
  for (const auto& f : check.failures) result.failures.push_back({f.where, f.message});
  if (!session.world()->is_finite()) result.failures.push_back({"", "the state is not finite at the end"});
  if (!check.has_check) {
    result.status = TestStatus::skipped;
    result.notice = "has no check";
  }
}

TestResult run_test(const std::string& file, const Options& options) {
  TestResult result;
  result.name = file;
  const std::uint64_t start = clock_nanoseconds();
  try {
    lua::HostOptions host = host_options(options);
    host.print = [&result](std::string_view text) { result.output += text; };
    Session session(std::move(host), nullptr);
    session.load(file);
    if (session.is_scene()) {
      step_and_check(session, result);
    } else if (!is_plain_test(file)) {
      result.status = TestStatus::skipped;
      result.notice = "is neither a scene nor a *_test.lua";
    }
    for (const auto& e : session.script().handler_errors())
      result.failures.push_back(
          {e.where, fmt::format("{} ({} x, in a handler)", failure_from(error_text(e), file).message, e.count)});
  } catch (const Failure& e) {
    // a plain test fails by its error; whatever else does not get as far as its first step was not loaded
    result.loaded = e.status() == kFailed && is_plain_test(file);
    result.failures.push_back(failure_from(e.what(), file));
  } catch (const std::exception& e) {
    result.failures.push_back(failure_from(e.what(), file));
  }
  if (!result.failures.empty()) result.status = TestStatus::failed;
  result.seconds = static_cast<double>(clock_nanoseconds() - start) * 1e-9;
  return result;
}

class Test final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("PATHS", paths_, "files and folders (default: scenes)");
    a.text("--filter", filter_, "only files whose path contains this text");
    a.text("--junit", junit_, "also write the results as JUnit XML to this file");
    a.flag("--tap", tap_, "print TAP version 13");
  }

  int run(const Options& options) override {
    host_options(options);  // complain about the options before the first test
    if (tap_ && options.json) throw Failure(kUsage, "feder test: choose one of --tap and --json");
    if (paths_.empty()) paths_ = {"scenes"};
    std::vector<std::string> files = discover(paths_);
    std::erase_if(files, [&](const std::string& f) { return f.find(filter_) == std::string::npos; });
    const bool lines = !tap_ && !options.json;
    std::vector<TestResult> results;
    for (const std::string& file : files) {
      results.push_back(run_test(file, options));
      if (lines) print(results.back(), options.quiet);
    }
    return finish(results, options);
  }

 private:
  static void print(const TestResult& r, bool quiet) {
    const bool failed = r.status == TestStatus::failed;
    if (quiet && !failed) return;
    const char* const word = failed ? "FAIL" : r.status == TestStatus::skipped ? "skip" : "ok";
    std::string note = r.notice;
    if (r.status == TestStatus::passed && r.checks) note = fmt::format("{} checks", r.checks);
    fmt::print("{:<4} {:8.3f} s  {}{}\n", word, r.seconds, r.name, note.empty() ? "" : " (" + note + ")");
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
      std::fputs(report::to_text(report::test_json(results)).c_str(), stdout);
    } else {
      if (tap_) std::fputs(report::tap_text(results).c_str(), stdout);
      fmt::print("{}{} passed, {} failed, {} skipped\n", tap_ ? "# " : "", counts.passed, counts.failed,
                 counts.skipped);
    }
    const bool unloaded = std::any_of(results.begin(), results.end(), [](const TestResult& r) { return !r.loaded; });
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
  bool tap_ = false;
};

}  // namespace

Row cli_test() {
  return {"test", "runs scenes that have a check, and *_test.lua scripts",
          [] { return std::unique_ptr<Command>(new Test); }};
}

}  // namespace feder::cli
