#include "cli/test_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <optional>

#include "cli/recording.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "cli/test_golden.h"
#include "cli/test_property.h"
#include "cli/test_source.h"
#include "feder/profile.h"

namespace feder::cli {
namespace {

using report::TestFailure;
using report::TestResult;
using report::TestStatus;

constexpr std::size_t kKeptOutput = std::size_t(1) << 20;  // bytes of what a script prints

// "scene.lua:12: message" taken apart again.
TestFailure failure_from(const std::string& text, const std::string& file) {
  std::size_t at = text.starts_with(file) ? file.size() : text.find(':');
  if (at == std::string::npos || at >= text.size() || text[at] != ':') return {.message = text};
  const std::size_t end = text.find_first_not_of("0123456789", at + 1);
  if (end == at + 1 || end == std::string::npos || text.compare(end, 2, ": ") != 0) return {.message = text};
  return {.where = text.substr(0, end), .message = text.substr(end + 2)};
}

TestFailure failure_from(const lua::CheckFailure& f, const std::vector<std::string>& files) {
  TestFailure failure{.where = f.where, .message = f.message};
  failure.time = f.time, failure.step = static_cast<int>(f.step);
  failure.object = f.object, failure.expected = f.expected, failure.actual = f.actual;
  failure.delta = f.delta, failure.tolerance = f.tolerance;
  add_source(failure, files, f.call);
  return failure;
}

struct EventNumber {
  EventKind::Tells field;
  Real Event::*value;
  const char* unit;
};
constexpr EventNumber kEventNumbers[] = {{EventKind::kSpeed, &Event::speed, "m/s"},
                                         {EventKind::kImpulse, &Event::impulse, "N s"},
                                         {EventKind::kForce, &Event::force, "N"}};

// One run of one case.
class TestRun {
 public:
  TestRun(const TestCase& test, const Options& options, const TestSettings& settings)
      : test_(test), options_(options), settings_(settings) {
    options_.set.insert(options_.set.end(), test.set.begin(), test.set.end());
  }

  TestResult run() {
    result_.name = test_.name(), result_.file = test_.file, result_.set = test_.set;
    if (settings_.begun) settings_.begun();
    const std::uint64_t start = clock_nanoseconds();
    const TimeLimit time(timeout_seconds(options_, kTestProcessorTime), kTestWallTime);
    try {
      run_session();
    } catch (const Failure& e) {
      take(e);
    } catch (const std::exception& e) {
      result_.failures.push_back(failure_from(e.what(), test_.file));
    }
    if (session_) look_back();
    if (!result_.failures.empty()) result_.status = TestStatus::failed;
    for (TestFailure& f : result_.failures)
      if (f.source.empty()) add_source(f, result_.files, "");
    result_.seconds = static_cast<double>(clock_nanoseconds() - start) * 1e-9;
    return result_;
  }

  const std::vector<lua::ParamInfo>& params() const { return params_; }
  int random() const { return random_; }

 private:
  void skip(const std::string& why) {
    result_.status = TestStatus::skipped;
    result_.notice = why;
  }

  // A plain test fails by its error; whatever else does not get as far as its first step was not loaded.
  void take(const Failure& e) {
    const std::string text = e.what();
    const std::size_t lacks = text.find("this build leaves out");
    if (lacks != std::string::npos) return skip(text.substr(lacks));
    if (e.status() == kUsage && !test_.set.empty() && text.find("unknown parameter") != std::string::npos)
      return skip(text.substr(0, text.find(';')));
    result_.exceeded = e.status() == kBudget;
    result_.loaded = result_.exceeded || (e.status() == kFailed && is_plain_test(test_.file));
    result_.failures.push_back(failure_from(text, test_.file));
  }

  void run_session() {
    lua::HostOptions host = host_options(options_);
    host.make_field = {};
    host.print = [this](std::string_view text) {
      if (result_.output.size() < kKeptOutput) result_.output += text.substr(0, kKeptOutput - result_.output.size());
    };
    if (settings_.coverage) host.coverage = &result_.lines;
    if (settings_.replay) {
      recorder_.emplace([this](std::string_view more) { recorded_ += more; }, RecordingFacts{});
      host.made = [this](World& world) { recorder_->add(world); };
    }
    session_ = std::make_unique<Session>(std::move(host), nullptr);
    if (settings_.events) session_->script().on_step([this](World& world) { keep_events(world); });
    session_->load(test_.file);
    result_.scene = session_->is_scene();
    params_ = session_->script().params(), random_ = session_->script().random_tests();
    if (result_.scene) {
      step_and_check();
    } else if (!is_plain_test(test_.file)) {
      skip("is neither a scene nor a *_test.lua");
    }
  }

  void step_and_check() {
    Session& session = *session_;
    const double own = session.script().seconds();
    const std::uint64_t steps = session.steps_for(own > 0 ? own : 10);
    std::optional<GoldenRun> golden;
    if (session.script().golden().declared && compares_golden()) golden.emplace(session);
    if (golden) golden->look();
    for (std::uint64_t i = 0; i < steps && session.goes_on(); ++i) {
      session.step();
      if (golden && session.goes_on()) golden->look();
    }
    if (!session.goes_on()) return;
    if (golden) golden->finish(settings_.update_golden, result_);
    const lua::CheckResult check = session.script().check();
    result_.exceeded = check.limit != lua::Limit::none;
    if (!session.world()->is_finite()) result_.failures.push_back({.message = "the state is not finite at the end"});
    if (!check.has_check && !golden && check.passed == 0 && check.failures.empty()) {
      skip("has no check");
    }
  }

  // One line each, of the last ones.
  void keep_events(World& world) {
    constexpr std::size_t kKept = 1000;
    for (const Event& e : world.events().list()) {
      std::string line = fmt::format("step {}  {:.4f} s  {}", world.step_count(), world.time(), e.kind.text());
      for (const ObjectId id : {e.a, e.b})
        if (id) line += "  " + world.objects().describe(id);
      for (const EventNumber& n : kEventNumbers)
        if (e.kind.has(n.field)) line += fmt::format("  {:.4g} {}", e.*n.value, n.unit);
      if (e.kind == EventKind::warning) line += "  " + world.events().warning_message(e);
      events_.push_back(line + "\n");
      if (events_.size() > kKept) events_.pop_front();
    }
  }

  // Other values are another run, with nothing to be compared with.
  bool compares_golden() {
    if (options_.set.empty() && options_.world.empty() && options_.dt.empty() && options_.seed.empty()) return true;
    result_.notice = "the golden run is one without options";
    return false;
  }

  // What is known at the end, also of a run that failed.
  void look_back() {
    lua::Script& script = session_->script();
    const lua::CheckResult& checks = script.checks();
    result_.checks = checks.passed;
    for (const auto& file : script.files()) result_.files.push_back(file.string());
    for (const auto& f : checks.failures) {
      result_.failures.push_back(failure_from(f, result_.files));
      if (result_.exceeded && &f == &checks.failures.back())
        result_.failures.back().message = limit_text(f.message, checks.limit);
    }
    for (const auto& f : checks.notes) result_.notes.push_back(failure_from(f, result_.files));
    bool limited = false;
    for (const auto& e : script.handler_errors()) {
      limited = limited || e.limit != lua::Limit::none;
      if (e.expectation) continue;
      result_.failures.push_back({.where = e.where,
                                  .message = fmt::format("{} ({} x, in a handler)",
                                                         failure_from(error_text(e), test_.file).message, e.count)});
    }
    if (!session_->goes_on() && !limited && !result_.exceeded) result_.failures.push_back({.message = stop_text()});
    result_.exceeded = result_.exceeded || !session_->goes_on();
    for (const std::string& line : events_) result_.events += line;
    if (recorder_) compare_replay();
    const World* world = session_->world();
    if (!world) return;
    result_.time = world->time(), result_.hash = fmt::format("{:016x}", world->hash());
  }

  void compare_replay() {
    recorder_->finish("finished");
    const std::string why = replay_difference(std::move(recorded_), options_.build.systems);
    if (!why.empty()) result_.failures.push_back({.message = why});
  }

  TestCase test_;
  Options options_;
  const TestSettings& settings_;
  TestResult result_;
  std::string recorded_;
  std::optional<Recorder> recorder_;  // outlives the worlds
  std::unique_ptr<Session> session_;
  std::vector<lua::ParamInfo> params_;
  int random_ = 0;
  std::deque<std::string> events_;
};

// One more run of a test that has a result: its time and lines count, too.
TestResult run_again(const TestCase& test, const Options& options, const TestSettings& settings, TestResult& result) {
  TestResult next = TestRun(test, options, settings).run();
  result.seconds += next.seconds;
  for (const auto& [file, lines] : next.lines)
    for (const auto& [line, count] : lines) result.lines[file][line] += count;
  return next;
}

// Every run must end in the same state.
void repeat(const TestCase& test, const Options& options, const TestSettings& settings, TestResult& result) {
  for (int i = 2; i <= settings.repeat && result.status == TestStatus::passed && !stop_flag(); ++i) {
    const TestResult next = run_again(test, options, settings, result);
    if (next.status == TestStatus::failed) result.failures = next.failures;
    if (next.hash != result.hash)
      result.failures.push_back({.message = fmt::format("run {} of {} ended in another state: {} instead of {}", i,
                                                        settings.repeat, next.hash, result.hash)});
    if (!result.failures.empty()) result.status = TestStatus::failed;
  }
}

// Parameters that the command line leaves to chance.
std::vector<lua::ParamInfo> free_params(const TestRun& run, const TestCase& test, const Options& options) {
  std::vector<lua::ParamInfo> params = run.params();
  std::erase_if(params, [&](const lua::ParamInfo& p) {
    const auto sets = [&](const std::string& s) { return s.starts_with(p.name + "="); };
    return std::ranges::any_of(options.set, sets) || std::ranges::any_of(test.set, sets);
  });
  return params;
}

void try_random(const TestCase& test, const Options& options, const TestSettings& settings, const TestRun& first,
                TestResult& result) {
  const std::vector<lua::ParamInfo> params = free_params(first, test, options);
  if (settings.random == 0 || params.empty() || result.status != TestStatus::passed || stop_flag()) return;
  const auto run = [&](const TestCase& drawn, const Options& own) { return run_again(drawn, own, settings, result); };
  try {
    PropertyTest(test, options, run, result).run(params, settings.random < 0 ? first.random() : settings.random);
  } catch (const Failure& e) {
    result.status = TestStatus::failed;
    result.failures.push_back({.message = e.what()});
  }
}

}  // namespace

bool runs_in_ci() {
  const char* const ci = std::getenv("CI");
  return ci && *ci;
}

TestResult run_test(const TestCase& test, const Options& options, const TestSettings& settings) {
  TestRun first(test, options, settings);
  TestResult result = first.run();
  repeat(test, options, settings, result);
  try_random(test, options, settings, first, result);
  return result;
}

}  // namespace feder::cli
