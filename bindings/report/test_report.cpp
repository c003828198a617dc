#include "report/test_report.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "report/table.h"
#include "report/xml.h"

namespace feder::report {
namespace {

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

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
  for (const TestFailure& f : r.failures) {
    std::string text = failure_text(f);
    for (const std::string& line : failure_details(f)) text += "\n" + line;
    out += fmt::format("    <{0} message=\"{1}\">{2}</{0}>\n", element, xml_escape(f.message), xml_escape(text, true));
  }
  if (r.status == TestStatus::skipped) out += fmt::format("    <skipped message=\"{}\"/>\n", xml_escape(r.notice));
  if (!r.output.empty()) out += fmt::format("    <system-out>{}</system-out>\n", xml_escape(r.output));
  out += "  </testcase>\n";
}

Json row_json(const TestResult& r) {
  Json row = {{"name", r.name}, {"status", name_of(r.status)}, {"seconds", r.seconds}, {"checks", r.checks}};
  if (!r.notice.empty()) row["notice"] = r.notice;
  if (!r.hash.empty()) row["time"] = r.time, row["hash"] = r.hash;
  if (!r.set.empty()) row["set"] = r.set;
  row["failures"] = written(r.failures);
  if (!r.notes.empty()) row["notes"] = written(r.notes);
  if (!r.drawn.empty()) row["counter_example"] = r.drawn;
  if (!r.again.empty()) row["again"] = r.again;
  return row;
}

// Texts of GitHub's workflow commands; properties end at a comma or colon, too.
std::string github_escape(const std::string& text, bool property) {
  std::string out;
  for (const char c : text) {
    if (c == '%' || c == '\n' || c == '\r' || (property && (c == ',' || c == ':')))
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out;
}

std::string github_line(const char* command, const TestResult& r, const TestFailure& f) {
  const std::size_t colon = f.where.rfind(':');
  const std::string file = colon == std::string::npos ? r.file : f.where.substr(0, colon);
  const std::string line = colon == std::string::npos ? "1" : f.where.substr(colon + 1);
  std::string text = f.message;
  for (const std::string& more : failure_details(f)) text += "\n" + more;
  return fmt::format("::{} file={},line={},title={}::{}\n", command, github_escape(file, true), line,
                     github_escape(r.name, true), github_escape(text, false));
}

std::pair<std::string, std::string> name_and_value(const std::string& set) {
  const std::size_t equals = set.find('=');
  return {set.substr(0, equals), equals == std::string::npos ? "" : set.substr(equals + 1)};
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

std::string failure_text(const TestFailure& f) { return f.where.empty() ? f.message : f.where + ": " + f.message; }

std::vector<std::string> failure_details(const TestFailure& f) {
  std::vector<std::string> lines;
  if (!f.source.empty()) lines.push_back("> " + f.source);
  if (!f.marks.empty()) lines.push_back("  " + f.marks);
  std::string text = f.step > 0 ? fmt::format("at {:.4g} s, step {}", f.time, f.step) : "";
  const std::pair<const char*, const std::string*> parts[] = {{"", &f.object},
                                                              {"expected ", &f.expected},
                                                              {"got ", &f.actual},
                                                              {"delta ", &f.delta},
                                                              {"tolerance ", &f.tolerance}};
  // what the message says is not said again
  for (const auto& [word, value] : parts)
    if (!value->empty() && f.message.find(*value) == std::string::npos)
      text += (text.empty() ? "" : ", ") + (word + *value);
  if (!text.empty()) lines.push_back(text);
  return lines;
}

std::string tap_head(std::size_t count) { return fmt::format("TAP version 13\n1..{}\n", count); }

std::string tap_line(const TestResult& r, std::size_t number) {
  std::string out =
      fmt::format("{} {} - {}", r.status == TestStatus::failed ? "not ok" : "ok", number, one_line(r.name));
  if (r.status == TestStatus::skipped) out += " # SKIP " + one_line(r.notice);
  out += "\n";
  for (const TestFailure& f : r.failures) {
    out += "# " + one_line(failure_text(f)) + "\n";
    for (const std::string& line : failure_details(f)) out += "#   " + one_line(line) + "\n";
  }
  return out;
}

std::string github_text(const std::vector<TestResult>& results) {
  std::string out;
  for (const TestResult& r : results) {
    for (const TestFailure& f : r.failures) out += github_line("error", r, f);
    for (const TestFailure& f : r.notes) out += github_line("warning", r, f);
  }
  return out;
}

std::string csv_text(const std::vector<TestResult>& results) {
  std::set<std::string> names;
  for (const TestResult& r : results)
    for (const std::string& s : r.set) names.insert(name_and_value(s).first);
  std::string out = "file";
  for (const std::string& name : names) out += "," + csv_cell(name);
  out += ",status,checks,failures,time,seconds,hash\n";
  for (const TestResult& r : results) {
    out += csv_cell(r.file);
    for (const std::string& name : names) {
      out += ",";
      for (const std::string& s : r.set)
        if (name_and_value(s).first == name) out += csv_cell(name_and_value(s).second);
    }
    out += fmt::format(",{},{},{},{:.6g},{:.3f},{}\n", name_of(r.status), r.checks, r.failures.size(), r.time,
                       r.seconds, r.hash);
  }
  return out;
}

std::string lcov_text(const std::vector<TestResult>& results) {
  Coverage all;
  for (const TestResult& r : results)
    for (const auto& [file, lines] : r.lines)
      for (const auto& [line, count] : lines) all[file][line] += count;
  std::string out;
  for (const auto& [file, lines] : all) {
    std::size_t hit = 0;
    out += fmt::format("TN:\nSF:{}\n", file);
    for (const auto& [line, count] : lines) {
      out += fmt::format("DA:{},{}\n", line, count);
      hit += count > 0;
    }
    out += fmt::format("LF:{}\nLH:{}\nend_of_record\n", lines.size(), hit);
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
