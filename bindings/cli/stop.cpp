#include "cli/stop.h"

#include <sys/time.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstring>

#include "cli/command.h"

namespace feder::cli {
namespace {

std::atomic<bool> stop_requested = false;
std::atomic<int> reason = 0;
std::atomic<int> watchers = 0;    // StopSignals alive
char timeout_words[2][120] = {};  // of SIGPROF and SIGALRM
std::atomic<int> timeout_kind = 0;

static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void request_stop(StopReason why) {
  int none = 0;
  reason.compare_exchange_strong(none, static_cast<int>(why));
  stop_requested = true;
}

void on_signal(int signal) { request_stop(signal == SIGTERM ? StopReason::terminate : StopReason::interrupt); }

// Only what a signal handler may do: atomics, write and _exit.
void on_time(int signal) {
  const int kind = signal == SIGALRM;
  const bool again = stop_reason() == StopReason::timeout;
  if (watchers > 0 && !again) {
    timeout_kind = kind;
    request_stop(StopReason::timeout);
    return;
  }
  const char* const words = timeout_words[kind];
  [[maybe_unused]] const auto ignored = write(STDERR_FILENO, words, std::strlen(words));
  _exit(kBudget);
}

void handle(int signal, void (*handler)(int), bool once) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART | (once ? static_cast<int>(SA_RESETHAND) : 0);
  sigaction(signal, &action, nullptr);
}

void start_timer(int which, double seconds) {
  itimerval timer = {};
  if (seconds > 0) {
    const double whole = std::floor(std::min(seconds, 1e8));
    timer.it_value.tv_sec = static_cast<time_t>(whole);
    timer.it_value.tv_usec = static_cast<suseconds_t>(std::max(1.0, (std::min(seconds, 1e8) - whole) * 999999));
    timer.it_interval.tv_sec = TimeLimit::kGrace;
  }
  setitimer(which, &timer, nullptr);
}

}  // namespace

StopReason stop_reason() { return static_cast<StopReason>(reason.load()); }
const std::atomic<bool>& stop_flag() { return stop_requested; }

int stop_status() {
  switch (stop_reason()) {
    case StopReason::interrupt: return kInterrupted;
    case StopReason::terminate: return kTerminated;
    case StopReason::timeout: return kBudget;
    case StopReason::none: break;
  }
  return kPass;
}

std::string stop_text() {
  if (stop_reason() != StopReason::timeout) return "interrupted";
  std::string text = timeout_words[timeout_kind];
  if (text.starts_with("feder: ")) text.erase(0, 7);
  if (text.ends_with('\n')) text.pop_back();
  return text;
}

StopSignals::StopSignals() {
  ++watchers;
  for (const int signal : {SIGINT, SIGTERM}) handle(signal, on_signal, true);
}

StopSignals::~StopSignals() {
  --watchers;
  for (const int signal : {SIGINT, SIGTERM}) handle(signal, SIG_DFL, false);
}

TimeLimit::TimeLimit(double processor, double wall) {
  if (stop_reason() == StopReason::timeout) reason = 0, stop_requested = false;
  const auto words = [](char(&to)[120], double seconds, const char* what) {
    const std::string text = fmt::format("feder: time limit of {:g} s of {} reached (--timeout)\n", seconds, what);
    to[text.copy(to, sizeof to - 1)] = '\0';
  };
  words(timeout_words[0], processor, "processor time");
  words(timeout_words[1], wall, "wall time");
  for (const int signal : {SIGPROF, SIGALRM}) handle(signal, on_time, false);
  start_timer(ITIMER_PROF, processor);
  start_timer(ITIMER_REAL, wall);
}

TimeLimit::~TimeLimit() {
  start_timer(ITIMER_PROF, 0);
  start_timer(ITIMER_REAL, 0);
}

}  // namespace feder::cli
