// feder scenes: the examples that come with feder: file, title, and the systems that each of them uses.
#include <algorithm>
#include <cstdio>

#include "cli/command.h"
#include "cli/field_cache.h"
#include "cli/scene_files.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "report/table.h"

namespace feder::cli {
namespace {

struct Example {
  std::string file, title, error;
  std::vector<std::string> systems;
};

// Couplings come along with what they join.
std::vector<std::string> own_systems(World& world) {
  std::vector<std::string> names;
  for (const SystemDescriptor* d : world.catalog()) {
    const auto present = world.report();
    const auto is_it = [&](const SystemReport& s) { return s.name == d->name; };
    if (d->joins.empty() && std::ranges::any_of(present, is_it)) names.emplace_back(d->name);
  }
  return names;
}

class Scenes final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("WORD", word_, "only scenes with this text in their path, title or systems");
  }

  int run(const Options& options) override {
    host_options(options);
    const StopSignals signals;
    const std::vector<std::string> files =
        find_files({folder()}, [](const std::string& f) { return looks_like_scene(f, "feder.scene"); });
    std::vector<Example> examples;
    for (const std::string& file : files) {
      if (stop_flag()) break;
      Example e = open(file, options);
      if (!stop_flag() && (e.error.size() || contains(e))) examples.push_back(std::move(e));
    }
    print(examples, options);
    for (const Example& e : examples)
      if (!e.error.empty()) print_error(e.error);
    if (stop_flag()) {
      print_error("feder scenes: " + stop_text());
      return stop_status();
    }
    if (examples.empty())
      throw Failure(kNothingRan, "feder scenes: no scene has '{}' in its path, title or systems", word_);
    return std::ranges::all_of(examples, [](const Example& e) { return e.error.empty(); }) ? kPass : kFailed;
  }

 private:
  // As short as it may be typed.
  static std::string folder() {
    const std::filesystem::path whole = scenes_folder();
    const std::string near = whole.lexically_proximate(std::filesystem::current_path()).string();
    return near.starts_with("..") ? whole.string() : near;
  }

  // Built, not run.
  static Example open(const std::string& file, const Options& options) {
    Example e;
    e.file = file;
    try {
      lua::HostOptions host = silent_host_options(options);
      host.make_field = sketch_field;
      Session session(std::move(host), nullptr, file);
      e.title = session.title();
      if (session.world()) e.systems = own_systems(*session.world());
    } catch (const Failure& failure) {
      e.error = failure.what();
    }
    return e;
  }

  bool contains(const Example& e) const {
    return fmt::format("{} {} {}", e.file, e.title, fmt::join(e.systems, " ")).find(word_) != std::string::npos;
  }

  static void print(const std::vector<Example>& examples, const Options& options) {
    report::Table table({"scene", "systems", "title"});
    report::Json rows = report::Json::array();
    for (const Example& e : examples) {
      if (!e.error.empty()) continue;
      table.add({e.file, fmt::format("{}", fmt::join(e.systems, " ")), e.title});
      rows.push_back({{"scene", e.file}, {"title", e.title}, {"systems", e.systems}});
    }
    if (options.json)
      print_json(rows);
    else
      std::fputs(table.text("").c_str(), stdout);
  }

  std::string word_;
};

}  // namespace

Row cli_scenes() { return command_row<Scenes>("scenes", "lists the example scenes that come with feder"); }

}  // namespace feder::cli
