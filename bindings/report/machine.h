// Where and with what a number was measured.
#pragma once
#include <string>

#include "report/json_fields.h"

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

// A run of the program as its report names it.
struct RunContext {
  MachineInfo machine;
  std::string command;  // the command line
};

// Now; load_after is filled by load_now() when the work is done.
MachineInfo machine_info(const std::string& tool_version, const std::string& real);
double load_now();

// The key `run` of a report.
void fields(auto& m, auto& v, const MachineInfo*) {
  v("git", m.git)("tool", m.tool)("date", m.date);
  v.object("build", [&m](auto& build) {
    build("compiler", m.compiler)("flags", m.flags)("real", m.real)("fma", m.fma)("ftz", m.ftz);
  });
  v.object("machine", [&m](auto& machine) {
    machine("cpu", m.cpu)("cores", m.cores)("os", m.os)("virtual", m.virtualization)("load_before", m.load_before);
    machine("load_after", m.load_after)("timer_resolution_ns", m.timer_resolution_ns);
  });
}

}  // namespace feder::report
