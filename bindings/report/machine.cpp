#include "report/machine.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "report/build_info.h"

namespace feder::report {
namespace {

std::string first_value(const char* file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    std::size_t at = line.find_first_of(":=");
    if (at == std::string::npos) continue;
    at = line.find_first_not_of(" \t\"", at + 1);
    if (at == std::string::npos) return "";
    std::string value = line.substr(at);
    while (!value.empty() && (value.back() == '"' || value.back() == ' ')) value.pop_back();
    return value;
  }
  return "";
}

// Smallest difference the clock shows.
double timer_resolution() {
  using Clock = std::chrono::steady_clock;
  double best = 1e9;
  for (int k = 0; k < 200; ++k) {
    const auto a = Clock::now();
    auto b = Clock::now();
    while (b == a) b = Clock::now();
    best = std::min(best, std::chrono::duration<double, std::nano>(b - a).count());
  }
  return best;
}

std::string now_text() {
  // reproducible builds of reports: a fixed date when the environment gives one
  const char* const epoch = std::getenv("SOURCE_DATE_EPOCH");
  const std::time_t t = epoch ? static_cast<std::time_t>(std::atoll(epoch)) : std::time(nullptr);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(t));
}

}  // namespace

double load_now() {
  std::ifstream in("/proc/loadavg");
  double load = 0;
  in >> load;
  return in ? load : 0;
}

MachineInfo machine_info(const std::string& tool_version, const std::string& real) {
  MachineInfo m;
  m.git = build_commit();
  m.tool = "feder " + tool_version;
  m.date = now_text();
  m.compiler = build_compiler();
  m.flags = build_flags();
  m.real = real;
  m.cpu = first_value("/proc/cpuinfo", "model name");
  m.cores = static_cast<int>(std::thread::hardware_concurrency());
  m.os = first_value("/etc/os-release", "PRETTY_NAME");
  const std::string features = " " + first_value("/proc/cpuinfo", "flags");
  if (features != " ") m.virtualization = features.find(" hypervisor") != std::string::npos ? "yes" : "no";
  m.load_before = m.load_after = load_now();
  m.timer_resolution_ns = timer_resolution();
  return m;
}

}  // namespace feder::report
