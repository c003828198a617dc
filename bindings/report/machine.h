// Where and with what a number was measured.
#pragma once
#include <string>

#include "report/json.h"

namespace feder::report {

struct MachineInfo {
  std::string git, tool, date;  // date: ISO 8601, UTC
  std::string compiler, flags, real;
  bool fma = false, ftz = false;  // contraction, flush to zero
  std::string cpu, os, virtualization;
  int cores = 0;
  double load_before = 0, load_after = 0;  // of the last minute
  double timer_resolution_ns = 0;
};

// Now; load_after is filled by load_now() when the work is done.
MachineInfo machine_info(const std::string& tool_version, const std::string& real);
double load_now();

Json machine_json(const MachineInfo& m);  // the key `run` of a report
MachineInfo machine_from_json(const Json& run);

}  // namespace feder::report
