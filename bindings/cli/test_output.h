// Where the results of feder test go: lines, and formats that other programs read, to stdout and to files.
#pragma once
#include <string>
#include <vector>

#include "cli/options.h"
#include "cli/test_print.h"
#include "report/test_report.h"

namespace feder::cli {

// A format writes all results at the end; TAP to stdout comes test by test. Without a function: lines for a reader.
struct TestFormat {
  const char* name;
  std::string (*text)(const std::vector<report::TestResult>& results);
};

class TestOutput {
 public:
  using Results = std::vector<report::TestResult>;

  void declare(Arguments& arguments);
  // Failure (usage) for formats that do not go together.
  void open(const Options& options);
  bool prints_lines() const;
  const std::string& coverage() const { return coverage_; }  // file; empty: not wanted

  void begin(std::size_t count);
  void add(const Results& results);  // the last one is new
  void count(const Results& results) const;
  void write_files(const Results& results) const;
  void finish(const Results& results) const;

 private:
  // An empty file is stdout.
  struct Output {
    const TestFormat* format;
    std::string file;
    bool on_stdout() const { return file.empty(); }
  };
  static Output read(const std::string& given);

  std::vector<std::string> formats_;
  std::string output_, junit_, coverage_;
  bool tap_ = false;
  std::vector<Output> outputs_;
  const TestFormat* stdout_ = nullptr;
  TestPrinter printer_{false};
  std::uint64_t written_ = 0;  // ns, when files were last written
};

}  // namespace feder::cli
