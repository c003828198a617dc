// A command of the feder program: its options and what it does. One file per command; the table is generated.
#pragma once
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "cli/arguments.h"
#include "cli/options.h"

namespace feder::cli {

// Exit statuses of every command.
inline constexpr int kPass = 0, kFailed = 1, kUsage = 2, kLoadError = 3, kBudget = 4, kNothingRan = 5,
                     kInterrupted = 130, kTerminated = 143;

// Ends a command: what() goes to stderr as one line ("file:line: message" where a place is known).
class Failure : public std::runtime_error {
 public:
  Failure(int status, const std::string& message) : std::runtime_error(message), status_(status) {}
  int status() const { return status_; }

 private:
  int status_;
};

class Command {
 public:
  virtual ~Command() = default;
  // Declares the options beside the common ones.
  virtual void declare(Arguments& arguments) = 0;
  // Returns the exit status, or throws Failure.
  virtual int run(const Options& options) = 0;
};

struct Row {
  const char* name;
  const char* summary;
  std::unique_ptr<Command> (*make)();
};

std::span<const Row> commands();

}  // namespace feder::cli
