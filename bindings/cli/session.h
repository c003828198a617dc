// One script from its file to its last step: loads, builds and steps it, and collects what happened on the way.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cli/command.h"
#include "feder/lua.h"

namespace feder::cli {

struct Warning {
  std::string code, message;  // of the first one
  std::uint64_t count = 0;    // steps that had it
};

class Session {
 public:
  // Errors in handlers go to `report` once per line of a script, as "file:line: message"; null keeps them silent.
  Session(lua::HostOptions host, std::function<void(const std::string&)> report);
  // Loads the file too.
  Session(lua::HostOptions host, std::function<void(const std::string&)> report, const std::string& file);

  // Reads and compiles the file, runs it and, for a scene, builds its world. Failure: kLoadError when the file cannot
  // be read, compiled or built, kFailed when a script fails while it runs, kUsage for values of --set and --world that
  // it does not take, kBudget at a limit, kInterrupted and kTerminated.
  void load(const std::string& file);

  // Called after every step of session.world(), those of plain scripts too.
  void after_each_step(std::function<void(World&)> callback) { callback_ = std::move(callback); }

  const std::string& file() const { return file_; }
  bool is_scene() const { return script_->is_scene(); }
  lua::Script& script() { return *script_; }
  World* world() { return script_->world(); }
  std::string title() const;  // of the scene, or the file's name
  // Steps that make `seconds` of this world. Failure (usage) above a billion.
  std::uint64_t steps_for(double seconds);
  // One step of a scene; its wall time is counted.
  void step();
  // False once a limit ended a handler, or the command has to end.
  bool goes_on() const;
  // The status and line of that; Failure when it does not go on.
  int end_status() const;
  void need_to_go_on() const;

  std::uint64_t steps() const { return steps_; }  // of the scene, or of all worlds of a plain script
  double step_milliseconds() const;               // wall time per step; handlers included for scenes
  const std::vector<Warning>& warnings() const { return warnings_; }

 private:
  void after_step(World& world);
  void report_errors();

  std::string file_;
  std::function<void(const std::string&)> report_;
  std::function<void(World&)> callback_;
  std::unique_ptr<lua::Script> script_;
  std::vector<Warning> warnings_;
  std::size_t reported_errors_ = 0, limit_error_ = kNone;
  static constexpr std::size_t kNone = ~std::size_t(0);
  std::uint64_t steps_ = 0;
  std::uint64_t nanoseconds_ = 0;  // in step()
};

// "file:line: message" of a handler error.
std::string error_text(const lua::HandlerError& error);
// What a script that ended at a limit says, and with which status the command ends.
std::string limit_text(const std::string& message, lua::Limit limit);
int limit_status(lua::Limit limit);

// In a handler of everything: throws what a script or a scene has thrown as a Failure: at a limit, usage for values of
// --set and --world, `status` for all else. `scene`: put in front of what a scene refuses.
[[noreturn]] void fail_by_script(int status, const std::string& scene = "");

// Compiles without running. Failure (kLoadError) "file:line: message".
void check_syntax(const std::string& file, const lua::HostOptions& host);

bool is_yaml(const std::string& file);
// Failure (kLoadError) when it cannot be read, as one of those ("a scene") and of so many MB.
std::string read_text(const std::string& file, const char* what = "a scene", std::uintmax_t largest = 64);

}  // namespace feder::cli
