// Tests in a process of their own: a crash is the failure of one test, by name. The program starts itself again (never
// fork alone: threads and GL do not survive it). The child writes JSON lines to descriptor 3, {"start": name} before a
// run and the result after a test; when it dies, the next child goes on behind the test that killed it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "report/test_report.h"

namespace feder::cli {

inline constexpr int kResultsDescriptor = 3;

// Runs `feder test --worker ARGUMENTS TESTS...` and calls `done` with the result of each, in order. Ends early
// when the command is asked to stop. A child, and all it started in its process group, ends with this call.
void run_isolated(const std::vector<std::string>& tests, const std::vector<std::string>& arguments,
                  const std::function<void(report::TestResult)>& done);

// Runs this program with other words, its output on stderr, and waits for its exit status; < 0 when it has none.
int run_own_program(std::vector<std::string> words);

// The child's side: one line, at once.
void send_line(const report::Json& line);

}  // namespace feder::cli
