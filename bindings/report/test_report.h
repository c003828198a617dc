// Results of a test run in the formats that test runners exchange.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "report/json_fields.h"

namespace feder::report {

// How often each line with code has run, by file.
using Coverage = std::map<std::string, std::map<int, std::uint64_t>>;

enum class TestStatus { passed, failed, skipped };
const char* name_of(TestStatus status);

struct TestFailure {
  std::string where = {};  // file:line, may be empty
  std::string message = {};
  std::string source = {};  // that line of the script
  std::string marks = {};   // below it: a caret under the call that failed
  double time = 0;          // s, simulated
  int step = 0;             // steps done; 0: not said
  std::string object = {}, expected = {}, actual = {}, delta = {}, tolerance = {};  // may be empty
};

struct TestResult {
  std::string name;              // path of the file, with parameters: "tower.lua[height=3]"
  std::string file;              // path
  std::vector<std::string> set;  // NAME=VALUE
  TestStatus status = TestStatus::passed;
  double seconds = 0;     // wall time
  int checks = 0;         // expectations that held
  double time = -1;       // s, simulated at the end; < 0: no world
  std::string hash;       // of the state then
  std::string notice;     // why it was skipped, or what else is to be said
  std::string output;     // what the script printed
  std::string diff;       // lines on what differs from a golden run
  std::string events;     // lines of the last events
  bool scene = false;     // a plain script otherwise
  bool loaded = true;     // false: the file could not be loaded
  bool exceeded = false;  // a limit ended it
  std::vector<TestFailure> failures;
  std::vector<TestFailure> notes;  // that fail nothing
  std::vector<std::string> drawn;  // NAME=VALUE of a counter-example
  std::string seed;                // of --seed when it was found
  std::string again;               // the command that shows the failure
  std::vector<std::string> files;  // that it has read
  Coverage lines;
};

struct TestCounts {
  int passed = 0, failed = 0, skipped = 0;
};
TestCounts count(const std::vector<TestResult>& results);

// "file:line: message", and the lines of what else is known: source, time, object, expected, actual, tolerance.
std::string failure_text(const TestFailure& failure);
std::vector<std::string> failure_details(const TestFailure& failure);

std::string junit_text(const std::vector<TestResult>& results);
// TAP, version 13: the head, and a test with its number from 1 on.
std::string tap_head(std::size_t count);
std::string tap_line(const TestResult& result, std::size_t number);
// Annotations of GitHub: workflow commands, a line each.
std::string github_text(const std::vector<TestResult>& results);
// Comma-separated, with a column for each parameter.
std::string csv_text(const std::vector<TestResult>& results);
// Line coverage of all results in the format of LCOV.
std::string lcov_text(const std::vector<TestResult>& results);
Json test_json(const std::vector<TestResult>& results);

// One result between two processes.
void fields(auto& f, auto& v, const TestFailure*) {
  v("where", f.where)("message", f.message)("source", f.source)("marks", f.marks)("time", f.time)("step", f.step);
  v("object", f.object)("expected", f.expected)("actual", f.actual)("delta", f.delta)("tolerance", f.tolerance);
}
void fields(auto& r, auto& v, const TestResult*) {
  v("name", r.name).named("status", r.status, {TestStatus::passed, TestStatus::failed, TestStatus::skipped});
  v("file", r.file)("set", r.set)("seconds", r.seconds)("checks", r.checks)("time", r.time)("hash", r.hash);
  v("notice", r.notice).part("failures", r.failures).part("notes", r.notes);
  v("output", r.output)("diff", r.diff)("events", r.events)("scene", r.scene)("loaded", r.loaded)("exceeded",
                                                                                                  r.exceeded);
  v("drawn", r.drawn)("seed", r.seed)("again", r.again)("files", r.files)("lines", r.lines);
}

}  // namespace feder::report
