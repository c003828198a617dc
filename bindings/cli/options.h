// What every command takes: --json, --quiet, --seed, --set, --world, --dt, --threads, --limit, --memory, --timeout,
// --no-cache.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "feder/lua.h"

namespace feder::cli {

// What a program is made of: all of this build. A program with systems of its own lists them too (tests/toy).
struct Build {
  std::span<const lua::Part* const> parts = lua::parts();
  Catalog systems = catalog();
};

struct Options {
  Build build;
  bool json = false, quiet = false, no_cache = false;
  std::string seed, dt;  // as given; empty when not given
  std::string limit, memory, timeout;
  int threads = 0;                      // 0: what the scene says
  std::vector<std::string> set, world;  // NAME=VALUE
};

void declare(Arguments& arguments, Options& options);
// Leaves what only scripts and worlds use out of the help.
void hide_scene_options(Arguments& arguments, bool but_threads);

// The options as the script host takes them; silent: what scripts print goes nowhere. Failure (usage) for what cannot
// be read.
lua::HostOptions host_options(const Options& options);
lua::HostOptions silent_host_options(const Options& options);

// --timeout in s; `otherwise` when it is not given.
double timeout_seconds(const Options& options, double otherwise);

// "3", "0.5", "1/240": a finite number >= 0. Failure (usage) naming the option.
double read_number(const std::string& text, const std::string& option);

// Words of a command line: options with their values, those that were not given (empty) left out; those that change a
// scene; and the words as one text.
using OptionWords = std::vector<std::pair<const char*, std::string>>;
void add_options(std::vector<std::string>& words, const OptionWords& options);
void add_scene_options(std::vector<std::string>& words, const Options& options);
std::string command_text(const std::vector<std::string>& words);

// Where `require` looks for the scripts that come with feder.
std::vector<std::filesystem::path> library_roots();
// The scenes that come with feder.
std::filesystem::path scenes_folder();

}  // namespace feder::cli
