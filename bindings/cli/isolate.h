// Tests in a process of their own: a crash is the failure of one test, by name. The program starts itself again (never
// fork alone: threads and GL do not survive it). The child writes JSON lines to descriptor 3, {"start": file} before a
// test and its result after it; when it dies, the next child goes on behind the test that killed it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "report/test_report.h"

namespace feder::cli {

inline constexpr int kResultsDescriptor = 3;

// Runs `feder test --worker ARGUMENTS FILES...` and calls `done` with the result of each file, in order. Ends early
// when the command is asked to stop. A child, and all it started in its process group, ends with this call.
void run_isolated(const std::vector<std::string>& files, const std::vector<std::string>& arguments,
                  const std::function<void(report::TestResult)>& done);

// The child's side: one line, at once.
void send_line(const report::Json& line);

}  // namespace feder::cli
