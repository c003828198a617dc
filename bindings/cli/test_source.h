// The line of a script that a failure is about, with a caret under the call that failed.
#pragma once
#include <string>
#include <vector>

#include "report/test_report.h"

namespace feder::cli {

// Fills source and marks from the file and line of failure.where, one of `files`, which the script has read. `call`:
// the name that the script has for the failed function; empty: that of the message ("expect.near: expected ...").
void add_source(report::TestFailure& failure, const std::vector<std::string>& files, const std::string& call);

}  // namespace feder::cli
