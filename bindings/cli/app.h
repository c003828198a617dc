// The feder program: picks the command, parses its options, turns whatever goes wrong into one line and an exit status.
#pragma once
#include "cli/options.h"

namespace feder::cli {

int run_program(int argc, char* argv[], const Build& build = {});

}  // namespace feder::cli
