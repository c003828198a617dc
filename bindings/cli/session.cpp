#include "cli/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "cli/stop.h"
#include "feder/profile.h"
#ifdef FEDER_HAS_YAML
#include "feder/yaml.h"
#endif

namespace feder::cli {

std::string error_text(const lua::HandlerError& error) {
  const std::string message = limit_text(error.message, error.limit);
  if (error.where.empty() || message.starts_with(error.where + ":")) return message;
  return error.where + ": " + message;
}

std::string limit_text(const std::string& message, lua::Limit limit) {
  switch (limit) {
    case lua::Limit::instructions:
    case lua::Limit::time: return message + "; --limit N allows more";
    case lua::Limit::memory: return message + "; --memory BYTES allows more";
    case lua::Limit::interrupted: {
      std::string text = message;
      const std::string word = "interrupted";
      if (text.ends_with(word)) text.replace(text.size() - word.size(), word.size(), stop_text());
      return text;
    }
    default: return message;
  }
}

int limit_status(lua::Limit limit) {
  return limit == lua::Limit::interrupted && stop_reason() != StopReason::none ? stop_status() : kBudget;
}

void fail_by_script(int status, const std::string& scene) {
  try {
    throw;
  } catch (const lua::LimitError& e) {
    throw Failure(limit_status(e.limit()), limit_text(e.what(), e.limit()));
  } catch (const lua::OptionError& e) {
    throw Failure(kUsage, e.what());
  } catch (const lua::ScriptError& e) {
    throw Failure(status, e.what());
  } catch (const SceneError& e) {
    throw Failure(status, scene + e.what());
  }
}

bool is_yaml(const std::string& file) { return file.ends_with(".yaml") || file.ends_with(".yml"); }

std::string read_text(const std::string& file, const char* what, std::uintmax_t largest) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) throw Failure(kLoadError, file + ": no such file");
  if (std::filesystem::is_directory(file, ignored))
    throw Failure(kLoadError, "{}: expected {}, got a folder", file, what);
  if (!std::filesystem::is_regular_file(file, ignored))
    throw Failure(kLoadError, "{}: expected {}, got a device or a pipe", file, what);
  if (std::filesystem::file_size(file, ignored) > largest << 20)
    throw Failure(kLoadError, "{}: larger than {} MB", file, largest);
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw Failure(kLoadError, file + ": cannot be read");
  return text.str();
}

void check_syntax(const std::string& file, const lua::HostOptions& host) {
  const std::string text = read_text(file);
  try {
    if (is_yaml(file)) {
#ifdef FEDER_HAS_YAML
      yaml::check(file, text);
#endif
      return;
    }
    // the whole text is compiled, and nothing of it runs
    lua::Script probe(host);
    probe.load_string((text.starts_with("#") ? "do return end --" : "do return end ") + text, file);
  } catch (const lua::ScriptError& e) {
    throw Failure(kLoadError, e.what());
  }
}

Session::Session(lua::HostOptions host, std::function<void(const std::string&)> report) : report_(std::move(report)) {
  try {
    script_ = std::make_unique<lua::Script>(std::move(host));
  } catch (const lua::ScriptError& e) {
    throw Failure(kBudget, limit_text(e.what(), lua::Limit::memory));
  }
  script_->on_step([this](World& world) { after_step(world); });
}

Session::Session(lua::HostOptions host, std::function<void(const std::string&)> report, const std::string& file)
    : Session(std::move(host), std::move(report)) {
  load(file);
}

void Session::load(const std::string& file) {
  file_ = file;
  check_syntax(file, {});
  int status = is_yaml(file) ? kLoadError : kFailed;
  try {
    script_->load_file(file);
    status = kLoadError;
    if (script_->is_scene()) script_->build();
  } catch (...) {
    report_errors();
    fail_by_script(status, file + ": ");
  }
  report_errors();
}

std::string Session::title() const {
  const std::string title = script_->title();
  return title.empty() ? std::filesystem::path(file_).stem().string() : title;
}

std::uint64_t Session::steps_for(double seconds) {
  constexpr double kMaxSteps = 1e9;
  const double dt = world()->desc().dt;
  if (!(seconds / dt <= kMaxSteps))
    throw Failure(kUsage, "{}: expected at most {:g} s, a billion steps, got {:g} s", file_, kMaxSteps * dt, seconds);
  return static_cast<std::uint64_t>(std::llround(seconds / dt));
}

bool Session::goes_on() const { return limit_error_ == kNone && !stop_flag(); }

int Session::end_status() const {
  if (limit_error_ != kNone) return limit_status(script_->handler_errors()[limit_error_].limit);
  return stop_status();
}

void Session::need_to_go_on() const {
  if (goes_on()) return;
  if (limit_error_ != kNone) throw Failure(end_status(), error_text(script_->handler_errors()[limit_error_]));
  throw Failure(end_status(), "{}: {}", file_, stop_text());
}

void Session::step() {
  const std::uint64_t start = clock_nanoseconds();
  script_->step();
  nanoseconds_ += clock_nanoseconds() - start;
  report_errors();
}

double Session::step_milliseconds() const {
  if (steps_ == 0) return 0;
  std::uint64_t sum = nanoseconds_;
  // a plain script steps its world itself: only its steps are timed, and only those of its last world
  if (!script_->is_scene() && script_->world()) {
    const std::uint64_t steps = script_->world()->step_count();
    sum += static_cast<std::uint64_t>(script_->world()->plan().total_nanoseconds());
    return steps ? static_cast<double>(sum) * 1e-6 / static_cast<double>(steps) : 0;
  }
  return static_cast<double>(sum) * 1e-6 / static_cast<double>(steps_);
}

void Session::after_step(World& world) {
  ++steps_;
  for (const Event& e : world.events().list()) {
    if (e.kind != EventKind::warning) continue;
    const std::string& code = world.events().warning_code(e);
    auto at = std::ranges::find_if(warnings_, [&](const Warning& w) { return w.code == code; });
    if (at == warnings_.end()) at = warnings_.insert(at, {code, world.events().warning_message(e), 0});
    ++at->count;
  }
  if (callback_ && &world == this->world()) callback_(world);
  report_errors();
}

void Session::report_errors() {
  const auto& errors = script_->handler_errors();
  for (; reported_errors_ < errors.size(); ++reported_errors_) {
    const lua::HandlerError& error = errors[reported_errors_];
    if (error.limit != lua::Limit::none && limit_error_ == kNone) limit_error_ = reported_errors_;
    if (report_) report_(error_text(error));
  }
}

}  // namespace feder::cli
