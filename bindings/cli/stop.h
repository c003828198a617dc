// Why a command ends before its work is done: a signal, or the time it may take. Signals know no objects, so this is
// the one file of the program with variables of its own.
#pragma once
#include <atomic>
#include <string>

namespace feder::cli {

enum class StopReason { none, interrupt, terminate, timeout };

// What asks the command to end; none while it may go on.
StopReason stop_reason();
// True as soon as there is a reason: scripts look at it while they run (lua::HostOptions::stop).
const std::atomic<bool>& stop_flag();
// Exit status (130, 143, 4) and words of the reason.
int stop_status();
std::string stop_text();

// While one lives, the command looks at stop_flag: the first SIGINT or SIGTERM asks it to end and to print what it has,
// the second one kills. Without one, signals kill and a time limit ends the process at once.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
};

// While it lives, the process may take so many seconds of processor time and of wall time; 0: any. At the limit it is
// asked to end, kGrace seconds later it ends with status 4. Only the last one made counts.
class TimeLimit {
 public:
  TimeLimit(double processor_seconds, double wall_seconds);
  ~TimeLimit();
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;

  static constexpr int kGrace = 5;  // s
};

}  // namespace feder::cli
