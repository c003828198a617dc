#include "cli/test_output.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "cli/command.h"
#include "feder/profile.h"

namespace feder::cli {
namespace {

using report::TestResult;
using Results = TestOutput::Results;

std::string tap_text(const Results& results) {
  std::string out = report::tap_head(results.size());
  for (std::size_t i = 0; i < results.size(); ++i) out += report::tap_line(results[i], i + 1);
  return out;
}

constexpr TestFormat kFormats[] = {
    {"text", nullptr},
    {"tap", tap_text},
    {"junit", report::junit_text},
    {"json", [](const Results& r) { return report::to_text(report::test_json(r)); }},
    {"github", report::github_text},
    {"csv", report::csv_text},
};

// Annotations of GitHub are lines among others.
bool shares_stdout(const TestFormat& format) { return format.text == report::github_text; }

void write_file(const std::string& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw Failure(kUsage, file + ": cannot be written");
}

}  // namespace

void TestOutput::declare(Arguments& a) {
  a.list("--format", formats_, "text, tap, junit, json, github or csv, to stdout; NAME=FILE: to a file");
  a.text("--output", output_, "file of the --format without one");
  a.text("--junit", junit_, "also write the results as JUnit XML to this file");
  a.flag("--tap", tap_, "print TAP version 13");
  a.text("--coverage", coverage_, "count the lines of scripts that ran, and write them to this file (LCOV)");
}

TestOutput::Output TestOutput::read(const std::string& given) {
  const std::size_t equals = given.find('=');
  const std::string name = given.substr(0, equals);
  std::vector<std::string> known;
  for (const TestFormat& f : kFormats) {
    if (name == f.name) return {&f, equals == std::string::npos ? "" : given.substr(equals + 1)};
    known.emplace_back(f.name);
  }
  throw Failure(kUsage, "--format: unknown format '{}'{}; known: {}", name, did_you_mean("; ", name, known),
                fmt::join(known, ", "));
}

void TestOutput::open(const Options& options) {
  // all ways to name a format, in one list
  for (const std::string& given : formats_) outputs_.push_back(read(given));
  if (tap_) outputs_.push_back(read("tap"));
  if (options.json) outputs_.push_back(read("json"));
  if (!junit_.empty()) outputs_.push_back(read("junit=" + junit_));
  if (!output_.empty()) {
    const auto at = std::ranges::find_if(outputs_, &Output::on_stdout);
    if (at == outputs_.end()) throw Failure(kUsage, "feder test: --output: there is no --format without a file");
    at->file = output_;
  }
  // one of them has stdout
  for (const Output& o : outputs_) {
    if (!o.on_stdout() || shares_stdout(*o.format)) continue;
    if (stdout_ && stdout_ != o.format)
      throw Failure(kUsage, "feder test: choose one of --{} and --{}, or give one a file", stdout_->name,
                    o.format->name);
    stdout_ = o.format;
  }
  if (!stdout_) stdout_ = &kFormats[0];
  printer_ = TestPrinter(options.quiet);
}

bool TestOutput::prints_lines() const { return stdout_->text == nullptr; }

void TestOutput::begin(std::size_t count) {
  if (stdout_->text == tap_text) std::fputs(report::tap_head(count).c_str(), stdout);
}

void TestOutput::add(const Results& results) {
  if (prints_lines()) printer_.print(results.back());
  if (stdout_->text == tap_text) std::fputs(report::tap_line(results.back(), results.size()).c_str(), stdout);
  std::fflush(stdout);
  // a run that is killed leaves what it had
  constexpr std::uint64_t kWriteTime = 500'000'000;  // ns
  if (clock_nanoseconds() - written_ < kWriteTime) return;
  write_files(results);
  written_ = clock_nanoseconds();
}

void TestOutput::count(const Results& results) const {
  const report::TestCounts counts = report::count(results);
  if (prints_lines()) return printer_.close(counts);
  if (stdout_->text == tap_text)
    fmt::print("# {} passed, {} failed, {} skipped\n", counts.passed, counts.failed, counts.skipped);
}

void TestOutput::write_files(const Results& results) const {
  for (const Output& o : outputs_)
    if (!o.on_stdout() && o.format->text) write_file(o.file, o.format->text(results));
  if (!coverage_.empty()) write_file(coverage_, report::lcov_text(results));
}

void TestOutput::finish(const Results& results) const {
  write_files(results);
  for (const Output& o : outputs_)
    if (o.on_stdout() && o.format->text && o.format->text != tap_text)
      std::fputs(o.format->text(results).c_str(), stdout);
  count(results);
  std::fflush(stdout);
}

}  // namespace feder::cli
