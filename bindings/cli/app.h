// The feder program: picks the command, parses its options, turns whatever goes wrong into one line and an exit status.
#pragma once
#include "cli/options.h"

namespace feder::cli {

int run_program(int argc, char* argv[], const Build& build = {});

// In a handler of everything: what was thrown as a line, and the exit status. That of a Failure; kFailed for what the
// world outside refuses (std::runtime_error: files, scripts, devices; memory); kInternal for all else.
int print_exception();

}  // namespace feder::cli
