// Command log: what is done to a world between its steps, in order, for recordings. Off unless someone listens: then a
// command costs a comparison. A function that edits opens with
//   const Command command(log, "rigid.set_velocity", body, v);
// which keeps the call when it ends well. What a command calls, and what a step does by itself, follows from it and is
// not kept. tests/record/test_commands.cpp: every edit in the public headers is a command.
#pragma once
#include <exception>

#include "state/command_codec.h"

namespace feder {

// Items of a log, by their first byte.
enum class LogItem : std::uint8_t {
  name = 1,     // a command's name and signature: numbered from 0 in the order they come
  command = 2,  // its number, the length of its arguments, the arguments
  forces = 3,   // what a host's force answered in the step that follows: numbers
  step = 4,     // 1 and the state hash, or 0
  note = 5,     // kind and text, for readers
};

class LogListener {
 public:
  virtual ~LogListener() = default;
  virtual void stepped() = 0;  // the world has done a step
  virtual void closed() = 0;   // the world is no more
};

class CommandLog {
 public:
  CommandLog() = default;
  CommandLog(const CommandLog&) = delete;
  CommandLog& operator=(const CommandLog&) = delete;
  ~CommandLog() {
    if (listener_) listener_->closed();
  }

  bool recording() const { return listener_ != nullptr; }
  void listen(LogListener* listener) { listener_ = listener; }
  // Around a step.
  void begin_step() {
    if (recording()) ++depth_, stepping_ = true;
  }
  void end_step() {
    if (!stepping_) return;
    --depth_, stepping_ = false;
    listener_->stepped();
  }
  bool stepping() const { return stepping_; }  // while recording

  void add_forces(const double* numbers, std::size_t count);
  void add_step(const std::uint64_t* hash);
  void add_note(std::string_view kind, std::string_view text);
  const std::string& items() const { return items_.bytes(); }
  void clear_items() { items_.clear(); }

 private:
  friend class Command;
  template <class... Args>
  void open(const char* name, const Args&... args) {
    if (names_.find(name) == names_.end()) {
      std::string signature;
      (command::sign<std::remove_cv_t<Args>>(signature), ...);
      add_name(name, signature);
    }
    arguments_.clear();
    const std::size_t shapes = arguments_.shapes();
    try {
      (command::write(arguments_, args), ...);
    } catch (...) {
      arguments_.forget_shapes(shapes);
      throw;
    }
  }
  void close(const char* name);
  void add_name(const char* name, const std::string& signature);

  LogListener* listener_ = nullptr;
  int depth_ = 0;
  bool stepping_ = false;
  std::map<std::string, std::uint64_t, std::less<>> names_;
  CommandBytes arguments_, items_;
};

class Command {
 public:
  template <class... Args>
  Command(CommandLog& log, const char* name, const Args&... args) : Command(&log, name, args...) {}
  template <class... Args>
  Command(CommandLog* log, const char* name, const Args&... args) {  // may be null
    if (!log || !log->recording()) return;
    if (log->depth_ == 0) {
      thrown_ = std::uncaught_exceptions();
      shapes_ = log->arguments_.shapes();
      log->open(name, args...);
      name_ = name;
    }
    log_ = log, ++log->depth_;
  }
  bool outermost() const { return name_ != nullptr; }
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  ~Command() {
    if (!log_) return;
    --log_->depth_;
    if (!name_) return;
    if (std::uncaught_exceptions() == thrown_)
      log_->close(name_);
    else
      log_->arguments_.forget_shapes(shapes_);
  }

 private:
  CommandLog* log_ = nullptr;
  const char* name_ = nullptr;  // of the outermost
  int thrown_ = 0;
  std::size_t shapes_ = 0;
};

}  // namespace feder
