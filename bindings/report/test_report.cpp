#include "report/test_report.h"

#include <fmt/format.h>

#include "report/xml.h"

namespace feder::report {
namespace {

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

std::string failure_text(const TestFailure& f) { return f.where.empty() ? f.message : f.where + ": " + f.message; }

// "scenes/rigid/tower.lua:12" -> file and line
void junit_place(const std::string& where, std::string& out) {
  const std::size_t colon = where.rfind(':');
  if (colon == std::string::npos) return;
  out +=
      fmt::format(" file=\"{}\" line=\"{}\"", xml_escape(where.substr(0, colon)), xml_escape(where.substr(colon + 1)));
}

void junit_case(const TestResult& r, std::string& out) {
  const std::size_t slash = r.name.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : r.name.substr(0, slash);
  out += fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\"", xml_escape(folder),
                     xml_escape(r.name.substr(slash == std::string::npos ? 0 : slash + 1)), r.seconds);
  junit_place(r.failures.empty() ? r.name + ":1" : r.failures.front().where, out);
  out += ">\n";
  const char* const element = r.loaded ? "failure" : "error";
  for (const TestFailure& f : r.failures)
    out += fmt::format("    <{0} message=\"{1}\">{2}</{0}>\n", element, xml_escape(f.message),
                       xml_escape(failure_text(f)));
  if (r.status == TestStatus::skipped) out += fmt::format("    <skipped message=\"{}\"/>\n", xml_escape(r.notice));
  if (!r.output.empty()) out += fmt::format("    <system-out>{}</system-out>\n", xml_escape(r.output));
  out += "  </testcase>\n";
}

Json row_json(const TestResult& r) {
  Json row = {{"name", r.name}, {"status", name_of(r.status)}, {"seconds", r.seconds}, {"checks", r.checks}};
  if (!r.notice.empty()) row["notice"] = r.notice;
  row["failures"] = written(r.failures);
  return row;
}

}  // namespace

const char* name_of(TestStatus status) {
  static const char* const names[] = {"passed", "failed", "skipped"};
  return names[static_cast<int>(status)];
}

TestCounts count(const std::vector<TestResult>& results) {
  TestCounts c;
  for (const TestResult& r : results)
    ++(r.status == TestStatus::passed ? c.passed : r.status == TestStatus::failed ? c.failed : c.skipped);
  return c;
}

std::string junit_text(const std::vector<TestResult>& results) {
  const TestCounts c = count(results);
  int errors = 0;
  double seconds = 0;
  for (const TestResult& r : results) {
    errors += r.status == TestStatus::failed && !r.loaded;
    seconds += r.seconds;
  }
  const std::string attributes =
      fmt::format("tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" time=\"{:.3f}\"", results.size(),
                  c.failed - errors, errors, c.skipped, seconds);
  std::string out = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  out += fmt::format("<testsuites {}>\n<testsuite name=\"feder\" {}>\n", attributes, attributes);
  for (const TestResult& r : results) junit_case(r, out);
  return out + "</testsuite>\n</testsuites>\n";
}

std::string tap_text(const std::vector<TestResult>& results) {
  std::string out = fmt::format("TAP version 13\n1..{}\n", results.size());
  int number = 0;
  for (const TestResult& r : results) {
    out += fmt::format("{} {} - {}", r.status == TestStatus::failed ? "not ok" : "ok", ++number, one_line(r.name));
    if (r.status == TestStatus::skipped) out += " # SKIP " + one_line(r.notice);
    out += "\n";
    for (const TestFailure& f : r.failures) out += "# " + one_line(failure_text(f)) + "\n";
  }
  return out;
}

Json test_json(const std::vector<TestResult>& results) {
  const TestCounts c = count(results);
  Json tests = Json::array();
  for (const TestResult& r : results) tests.push_back(row_json(r));
  return {{"passed", c.passed}, {"failed", c.failed}, {"skipped", c.skipped}, {"tests", tests}};
}

}  // namespace feder::report
