// One test: a scene with a check or a *_test.lua script, in a Lua state and a world of its own.
#pragma once
#include <cstdint>
#include <functional>
#include <map>

#include "cli/options.h"
#include "cli/test_case.h"
#include "report/test_report.h"

namespace feder::lua {
struct ParamInfo;
}

namespace feder::cli {

// Limits of one run, s.
inline constexpr double kTestProcessorTime = 60, kTestWallTime = 600;

struct TestSettings {
  int repeat = 1;               // runs, which must end in the same state
  int random = -1;              // draws of the parameters; < 0: as the scene says
  bool update_golden = false;   // writes golden runs
  bool coverage = false;        // counts lines
  bool events = false;          // keeps the last events
  bool replay = false;          // records the run, which its replay must be
  std::function<void()> begun;  // before each run
};

bool runs_in_ci();  // by the environment

report::TestResult run_test(const TestCase& test, const Options& options, const TestSettings& settings);

// Values of parameters in place of their defaults.
using Draw = std::map<std::string, std::string>;
std::vector<std::string> set_words(const Draw& draw);  // NAME=VALUE
Draw draw_of(const std::vector<std::string>& words);

// Property tests: `fails` runs the test with the drawn values of parameters that have min and max, or choices. The
// first of `count` draws that fails is shrunk: each value as near to its default as still fails.
struct CounterExample {
  int number = 0;  // of the draw; 0: none failed
  Draw drawn, shrunk;
};
// Has every parameter of the draw that value still?
bool takes(const std::vector<lua::ParamInfo>& params, const Draw& draw);
CounterExample find_counter_example(const std::vector<lua::ParamInfo>& params, int count, std::uint64_t seed,
                                    const std::function<bool(const Draw&)>& fails);

}  // namespace feder::cli
