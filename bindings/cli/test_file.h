// One test: a scene with a check or a *_test.lua script, in a Lua state and a world of its own.
#pragma once
#include <string>

#include "cli/options.h"
#include "report/test_report.h"

namespace feder::cli {

// Limits of one file, s.
inline constexpr double kTestProcessorTime = 60, kTestWallTime = 600;

bool is_plain_test(const std::string& file);
report::TestResult run_test(const std::string& file, const Options& options);

}  // namespace feder::cli
