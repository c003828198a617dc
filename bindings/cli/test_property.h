// A property test: a test that must hold for all values of its parameters. Counter-examples of earlier runs are tried
// first, then random draws; what fails is shrunk, reported and kept.
#pragma once
#include "cli/test_examples.h"

namespace feder::cli {

class PropertyTest {
 public:
  using Run = std::function<report::TestResult(const TestCase& test, const Options& options)>;
  // `result`: of the run with the values that the test has by itself, which passed.
  PropertyTest(const TestCase& test, const Options& options, Run run, report::TestResult& result);
  void run(const std::vector<lua::ParamInfo>& params, int count);

 private:
  bool try_saved(const std::vector<lua::ParamInfo>& params);  // true when one of them fails
  bool fails(const Draw& draw, const Options& options);
  // Takes the failures of the last run that failed; `found` says how its values came.
  void report(const SavedExample& example, const std::string& found);
  void add_notice(const std::string& text);

  const TestCase& test_;
  const Options& options_;
  const Run run_;
  report::TestResult& result_;
  report::TestResult failed_;
  SavedExamples saved_;
};

}  // namespace feder::cli
