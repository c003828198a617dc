#include "cli/test_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cli/session.h"
#include "cli/stop.h"
#include "feder/profile.h"

namespace feder::cli {
namespace {

using report::TestResult;
using report::TestStatus;

constexpr std::size_t kKeptOutput = std::size_t(1) << 20;  // bytes of what a script prints

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
  for (std::uint64_t i = 0; i < steps && session.goes_on(); ++i) session.step();
  if (!session.goes_on()) return;
  const lua::CheckResult check = session.script().check();
  result.checks = check.passed;
  result.exceeded = check.limit != lua::Limit::none;
  for (const auto& f : check.failures) {
    const bool limited = result.exceeded && &f == &check.failures.back();
    result.failures.push_back({f.where, limited ? limit_text(f.message, check.limit) : f.message});
  }
  if (!session.world()->is_finite()) result.failures.push_back({"", "the state is not finite at the end"});
  if (!check.has_check) {
    result.status = TestStatus::skipped;
    result.notice = "has no check";
  }
}

void run_session(const std::string& file, const Options& options, TestResult& result) {
  lua::HostOptions host = host_options(options);
  host.print = [&result](std::string_view text) {
    if (result.output.size() < kKeptOutput) result.output += text.substr(0, kKeptOutput - result.output.size());
  };
  Session session(std::move(host), nullptr, file);
  if (session.is_scene()) {
    step_and_check(session, result);
  } else if (!is_plain_test(file)) {
    result.status = TestStatus::skipped;
    result.notice = "is neither a scene nor a *_test.lua";
  }
  bool limited = false;
  for (const auto& e : session.script().handler_errors()) {
    limited = limited || e.limit != lua::Limit::none;
    result.failures.push_back(
        {e.where, fmt::format("{} ({} x, in a handler)", failure_from(error_text(e), file).message, e.count)});
  }
  if (!session.goes_on() && !limited) result.failures.push_back({"", stop_text()});
  result.exceeded = result.exceeded || !session.goes_on();
}

}  // namespace

bool is_plain_test(const std::string& file) {
  const std::string stem = std::filesystem::path(file).stem().string();
  return file.ends_with(".lua") && (stem.ends_with("_test") || stem.starts_with("test_"));
}

TestResult run_test(const std::string& file, const Options& options) {
  TestResult result;
  result.name = file;
  const std::uint64_t start = clock_nanoseconds();
  const TimeLimit time(timeout_seconds(options, kTestProcessorTime), kTestWallTime);
  try {
    run_session(file, options, result);
  } catch (const Failure& e) {
    // a plain test fails by its error; whatever else does not get as far as its first step was not loaded
    result.exceeded = e.status() == kBudget;
    result.loaded = result.exceeded || (e.status() == kFailed && is_plain_test(file));
    result.failures.push_back(failure_from(e.what(), file));
  } catch (const std::exception& e) {
    result.failures.push_back(failure_from(e.what(), file));
  }
  if (!result.failures.empty()) result.status = TestStatus::failed;
  result.seconds = static_cast<double>(clock_nanoseconds() - start) * 1e-9;
  return result;
}

}  // namespace feder::cli
