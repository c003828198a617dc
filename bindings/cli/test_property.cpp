#include "cli/test_property.h"

#include <utility>

#include "cli/command.h"
#include "cli/stop.h"

namespace feder::cli {

using report::TestFailure;
using report::TestResult;

PropertyTest::PropertyTest(const TestCase& test, const Options& options, Run run, TestResult& result)
    : test_(test), options_(options), run_(std::move(run)), result_(result), saved_(test.file) {}

void PropertyTest::run(const std::vector<lua::ParamInfo>& params, int count) {
  if (try_saved(params) || stop_flag() || count == 0) return;
  const CounterExample found = find_counter_example(params, count, host_options(options_).seed,
                                                    [&](const Draw& draw) { return fails(draw, options_); });
  if (found.number == 0) return add_notice(fmt::format("{} random draws", count));
  const SavedExample example = SavedExamples::make(test_, options_, found.shrunk);
  const std::string seed = options_.seed.empty() ? "" : " --seed " + options_.seed;
  report(example, fmt::format("from draw {} of --random {}{}", found.number, count, seed));
  add_notice(saved_.add(example));
}

bool PropertyTest::try_saved(const std::vector<lua::ParamInfo>& params) {
  for (const SavedExample& example : saved_.of(test_, options_)) {
    Options options = options_;
    options.seed = example.seed;
    const Draw draw = draw_of(example.set);
    const bool failed = takes(params, draw) && fails(draw, options);
    if (stop_flag()) return false;
    if (failed) return report(example, "found by an earlier run"), true;
    add_notice(saved_.drop(example));
  }
  return false;
}

bool PropertyTest::fails(const Draw& draw, const Options& options) {
  TestCase drawn = test_;
  for (const std::string& word : set_words(draw)) drawn.set.push_back(word);
  TestResult next = run_(drawn, options);
  if (next.status != report::TestStatus::failed || stop_flag()) return false;
  failed_ = std::move(next);
  return true;
}

void PropertyTest::report(const SavedExample& example, const std::string& found) {
  const TestResult passed = std::exchange(result_, std::move(failed_));
  result_.name = passed.name, result_.set = passed.set, result_.seconds = passed.seconds, result_.lines = passed.lines;
  result_.notice = passed.notice, result_.drawn = example.set, result_.seed = example.seed;
  for (TestFailure& f : result_.failures)
    f.message += fmt::format(" (with --set {}, {})", fmt::join(example.set, " --set "), found);
}

void PropertyTest::add_notice(const std::string& text) {
  if (!text.empty()) result_.notice += (result_.notice.empty() ? "" : "; ") + text;
}

}  // namespace feder::cli
