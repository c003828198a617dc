// What a failed test leaves for a reader: a picture of its last frame, its recording, its messages and
// output, and the last events.
#pragma once
#include <string>

#include "cli/options.h"
#include "report/test_report.h"

namespace feder::cli {

// Into `folder`, made when it is missing, under the name of the test. Each is written by a process of its own, so that
// what crashed the test does not end the command. Returns the files as "a.png, a.txt".
std::string save_artifacts(const std::string& folder, const report::TestResult& result, const Options& options);

}  // namespace feder::cli
