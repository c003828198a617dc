// A command of the feder program: its options and what it does. One file per command; the table is generated.
#pragma once
#include <fmt/format.h>

#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "cli/arguments.h"
#include "cli/options.h"
#include "report/json.h"

namespace feder::cli {

// Exit statuses of every command. Internal: a mistake of the program, not of what it was given (EX_SOFTWARE).
inline constexpr int kPass = 0, kFailed = 1, kUsage = 2, kLoadError = 3, kBudget = 4, kNothingRan = 5, kInternal = 70,
                     kInterrupted = 130, kTerminated = 143;
inline constexpr const char* kStatusText =
    "0 done, 1 failures, 2 usage, 3 load error, 4 limit, 5 nothing ran, 70 internal error, 130 and 143 interrupted";

// Ends a command: what() goes to stderr as one line ("file:line: message" where these are known).
class Failure : public std::runtime_error {
 public:
  Failure(int status, const std::string& message) : std::runtime_error(message), status_(status) {}
  template <class T, class... More>
  Failure(int status, fmt::format_string<T, More...> format, T&& first, More&&... more)
      : Failure(status, fmt::format(format, std::forward<T>(first), std::forward<More>(more)...)) {}
  int status() const { return status_; }

 private:
  int status_;
};

class Command {
 public:
  virtual ~Command() = default;
  // Declares the options beside the common ones.
  virtual void declare(Arguments& arguments) = 0;
  // Commands that run no scene take the options of scenes too, and do not list them.
  virtual bool runs_scenes() const { return true; }
  virtual bool makes_worlds() const { return runs_scenes(); }  // takes and lists --threads
  // Returns the exit status, or throws Failure.
  virtual int run(const Options& options) = 0;
};

struct Row {
  const char* name;
  const char* summary;
  std::unique_ptr<Command> (*make)();
};

std::span<const Row> commands();

template <class C>
Row command_row(const char* name, const char* summary) {
  return {name, summary, [] { return std::unique_ptr<Command>(new C); }};
}

// "; did you mean 'oscillator'?" behind `lead`; empty when nothing is near.
std::string did_you_mean(const char* lead, const std::string& word, const std::vector<std::string>& known);

// To stdout: one JSON value. To stderr: a line, behind what stdout has so far.
void print_json(const report::Json& value);
void print_error(const std::string& line);

}  // namespace feder::cli
