// Results of a test run in the formats that test runners exchange.
#pragma once
#include <string>
#include <vector>

#include "report/json_fields.h"

namespace feder::report {

enum class TestStatus { passed, failed, skipped };
const char* name_of(TestStatus status);

struct TestFailure {
  std::string where;  // file:line, may be empty
  std::string message;
};

struct TestResult {
  std::string name;  // path of the file
  TestStatus status = TestStatus::passed;
  double seconds = 0;     // wall time
  int checks = 0;         // expectations that held
  std::string notice;     // why it was skipped
  std::string output;     // what the script printed
  bool loaded = true;     // false: the file could not be loaded
  bool exceeded = false;  // a limit ended it
  std::vector<TestFailure> failures;
};

struct TestCounts {
  int passed = 0, failed = 0, skipped = 0;
};
TestCounts count(const std::vector<TestResult>& results);

std::string junit_text(const std::vector<TestResult>& results);
std::string tap_text(const std::vector<TestResult>& results);  // version 13
Json test_json(const std::vector<TestResult>& results);

// One result between two processes.
void fields(auto& f, auto& v, const TestFailure*) { v("where", f.where)("message", f.message); }
void fields(auto& r, auto& v, const TestResult*) {
  v("name", r.name).named("status", r.status, {TestStatus::passed, TestStatus::failed, TestStatus::skipped});
  v("seconds", r.seconds)("checks", r.checks)("notice", r.notice).part("failures", r.failures);
  v("output", r.output)("loaded", r.loaded)("exceeded", r.exceeded);
}

}  // namespace feder::report
