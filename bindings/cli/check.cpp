// feder check: finds mistakes without running a scene: syntax, and names that nothing has (options, events and their
// fields, methods, functions, globals, modules). It parses the text: a local, the handler of an event and the table of
// an options call are plain to see there, while bytecode has only registers, which lose what they hold at every jump,
// and gives no line to a key. Lua compiles the text first, so that the parser meets nothing else. All names come from
// the rows of the binding itself (check_names.h); what a value is, from what the text does with it (check_kinds.h).
// Where that is not certain, nothing is said. A scene in YAML runs nothing: it is built, so that its keys are checked
// by their readers.
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "cli/check_rules.h"
#include "cli/command.h"
#include "cli/scene_files.h"
#include "cli/session.h"
#include "lua/state.h"

namespace feder::cli {
namespace {

class Check final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("SCENE", paths_, "files (.lua, .yaml) or folders with such files");
    a.require("SCENE");
  }

  bool runs_scenes() const override { return false; }

  int run(const Options& options) override {
    const std::vector<std::string> files = files_of(paths_);
    if (files.empty()) throw Failure(kNothingRan, "feder check: no .lua file and no scene there");
    ScriptNames names(options);
    for (const std::string& file : files)
      if (!is_yaml(file)) names.add_globals(file);
    for (const std::string& file : files) check(file, names, options);
    if (options.json) {
      print_json({{"files", files.size()}, {"findings", json_}});
    } else if (!options.quiet && json_.empty()) {
      fmt::print("{} file{}: nothing found\n", files.size(), files.size() == 1 ? "" : "s");
    }
    return status_;
  }

 private:
  // A file that is named is checked, whatever it is called.
  static std::vector<std::string> files_of(const std::vector<std::string>& paths) {
    std::vector<std::string> files;
    std::error_code ignored;
    for (const std::string& path : paths) {
      if (!std::filesystem::is_directory(path, ignored)) {
        files.push_back(path);
        continue;
      }
      const auto wanted = [](const std::string& file) { return looks_like_scene(file, ""); };
      const std::vector<std::string> inside = find_files({path}, wanted);
      files.insert(files.end(), inside.begin(), inside.end());
    }
    return files;
  }

  void check(const std::string& file, const ScriptNames& names, const Options& options) {
    try {
      check_syntax(file, {});
      if (is_yaml(file)) return build(file, options);
      const std::filesystem::path folder = std::filesystem::path(file).parent_path();
      for (const Finding& f : check_names(read_text(file), folder, names))
        refuse(file, fmt::format("{}:{}: {}", file, f.line, f.message), kFailed, options.json);
    } catch (const Failure& e) {
      refuse(file, e.what(), e.status(), options.json);
    } catch (const std::runtime_error& e) {
      refuse(file, fmt::format("{}:{}", file, e.what()), kLoadError, options.json);
    }
  }

  static void build(const std::string& file, const Options& options) {
    if (looks_like_scene(file, "")) Session(silent_host_options(options), nullptr, file);
  }

  // What cannot be loaded says its place itself.
  void refuse(const std::string& file, const std::string& what, int status, bool json) {
    const lua::Failure failure = lua::split_location(what);
    const std::size_t colon = failure.where.rfind(':');
    const int line = colon == std::string::npos ? 0 : std::atoi(failure.where.c_str() + colon + 1);
    status_ = std::max(status_, status);
    json_.push_back({{"file", file}, {"line", line}, {"message", failure.message}});
    if (!json) print_error(what);
  }

  std::vector<std::string> paths_;
  report::Json json_ = report::Json::array();
  int status_ = kPass;
};

}  // namespace

Row cli_check() { return command_row<Check>("check", "looks for mistakes without running: syntax and unknown names"); }

}  // namespace feder::cli
