#include "cli/test_print.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace feder::cli {
namespace {

using report::TestFailure;
using report::TestResult;
using report::TestStatus;

constexpr const char* kRed = "31";
constexpr const char* kGreen = "32";
constexpr const char* kYellow = "33";
constexpr const char* kGray = "90";
constexpr std::size_t kShown = 10;  // a check in a loop fails for every body

// https://no-color.org: set and not empty
bool wants_color() {
  const char* const no = std::getenv("NO_COLOR");
  const char* const terminal = std::getenv("TERM");
  return isatty(STDOUT_FILENO) != 0 && (!no || !*no) && (!terminal || std::string(terminal) != "dumb");
}

std::string detail_of(const TestResult& r) {
  if (r.status != TestStatus::passed || r.checks == 0) return r.notice;
  return fmt::format("{} checks{}{}", r.checks, r.notice.empty() ? "" : "; ", r.notice);
}

}  // namespace

TestPrinter::TestPrinter(bool quiet) : quiet_(quiet), colored_(wants_color()) {}

std::string TestPrinter::painted(const char* color, const std::string& text) const {
  return colored_ ? fmt::format("\033[{}m{}\033[0m", color, text) : text;
}

void TestPrinter::print(const TestResult& r) const {
  const bool failed = r.status == TestStatus::failed, skipped = r.status == TestStatus::skipped;
  if (quiet_ && !failed) return;
  const std::string word = painted(failed    ? kRed
                                   : skipped ? kYellow
                                             : kGreen,
                                   fmt::format("{:<4}", failed    ? "FAIL"
                                                        : skipped ? "skip"
                                                                  : "ok"));
  const std::string detail = detail_of(r);
  fmt::print("{} {:8.3f} s  {}{}\n", word, r.seconds, r.name, detail.empty() ? "" : " (" + detail + ")");
  for (const TestFailure& note : r.notes)
    fmt::print("{}: {}\n", note.where.empty() ? r.name : note.where, painted(kYellow, "note: " + note.message));
  if (failed) print_failures(r);
  if (!r.diff.empty()) fmt::print("{}", r.diff);
  std::fflush(stdout);
}

void TestPrinter::print_failures(const TestResult& r) const {
  for (std::size_t i = 0; i < std::min(kShown, r.failures.size()); ++i) {
    const TestFailure& f = r.failures[i];
    fmt::print("{}: {}\n", f.where.empty() ? r.name : f.where, painted(kRed, f.message));
    for (const std::string& line : report::failure_details(f)) fmt::print("  {}\n", painted(kGray, line));
  }
  if (r.failures.size() > kShown) fmt::print("{}: and {} more failures\n", r.name, r.failures.size() - kShown);
  if (!r.output.empty()) fmt::print("--- printed by {}\n{}{}", r.name, r.output, r.output.ends_with('\n') ? "" : "\n");
  fmt::print("  again: {}\n", r.again);
}

void TestPrinter::close(const report::TestCounts& counts) const {
  const std::string text =
      fmt::format("{} passed, {} failed, {} skipped", counts.passed, counts.failed, counts.skipped);
  fmt::print("{}\n", painted(counts.failed ? kRed : kGreen, text));
  std::fflush(stdout);  // under --watch what reads it waits for this line
}

}  // namespace feder::cli
