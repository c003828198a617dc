// Results of tests for a reader: a line each, with colour on a terminal.
#pragma once
#include "report/test_report.h"

namespace feder::cli {

class TestPrinter {
 public:
  explicit TestPrinter(bool quiet);
  void print(const report::TestResult& result) const;
  void close(const report::TestCounts& counts) const;

 private:
  std::string painted(const char* color, const std::string& text) const;
  void print_failures(const report::TestResult& result) const;

  bool quiet_, colored_;
};

}  // namespace feder::cli
