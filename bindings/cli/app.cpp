#include "cli/app.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

#include "cli/command.h"
#include "cli/stop.h"
#include "feder/params.h"
#include "report/build_info.h"

namespace feder::cli {
namespace {

std::string help_text() {
  std::string text = "feder: a physics sandbox scripted from Lua\n\nusage: feder COMMAND [SCENE] [options]\n\n";
  for (const Row& row : commands()) text += fmt::format("  {:<10}{}\n", row.name, row.summary);
  return text + "\nfeder COMMAND --help lists the options of a command.\nExit status: " + kStatusText + ".\n";
}

const Row* find_command(const std::string& name) {
  for (const Row& row : commands())
    if (name == row.name) return &row;
  return nullptr;
}

std::string unknown_command(const std::string& word) {
  std::vector<std::string> known;
  for (const Row& row : commands()) known.emplace_back(row.name);
  std::string message = fmt::format("feder: unknown command '{}'; known: {}", word, fmt::join(known, ", "));
  if (word.ends_with(".lua") || word.ends_with(".yaml") || word.ends_with(".yml"))
    message += fmt::format("; to run a scene: feder run {}", word);
  else if (word == "view" || word == "render" || word == "export")
    message += "; this build has no viewer: it was left out, or GLFW, ImGui and OpenGL were not found";
  else if (word == "study" || word == "stability")
    message += "; this build has no studies";
  else
    message += did_you_mean("; ", word, known);
  return message;
}

std::string version_text() {
  const std::string commit = report::build_commit();
  return fmt::format("feder {} ({})\n  commit    {}\n  compiler  {} {}\n  simd      {}\n", FEDER_VERSION, kRealName,
                     commit.empty() ? "unknown" : commit, report::build_compiler(), report::build_flags(),
                     report::simd_path());
}

int run_command(const Row& row, int argc, char* argv[], const Build& build) {
  Arguments arguments(row.name, row.summary);
  Options options;
  options.build = build;
  const auto command = row.make();
  command->declare(arguments);
  declare(arguments, options);
  if (!command->runs_scenes()) hide_scene_options(arguments, command->makes_worlds());
  try {
    if (!arguments.parse(argc, argv)) return fmt::print("{}", arguments.help()), kPass;
  } catch (const std::invalid_argument& e) {
    throw Failure(kUsage, "feder {}: {}", row.name, e.what());
  }
  const TimeLimit time(timeout_seconds(options, 0), 0);
  return command->run(options);
}

// Exceptions as one line and a status.
int run_guarded(int argc, char* argv[], const Build& build) {
  const std::string word = argc > 1 ? argv[1] : "";
  try {
    if (word == "--help" || word == "-h" || word == "help") return fmt::print("{}", help_text()), kPass;
    if (word == "--version") return fmt::print("{}", version_text()), kPass;
    if (word.empty()) return fmt::print(stderr, "{}", help_text()), kUsage;
    const Row* row = find_command(word);
    if (!row) throw Failure(kUsage, unknown_command(word));
    return run_command(*row, argc - 1, argv + 1, build);
  } catch (...) {
    return print_exception();
  }
}

}  // namespace

std::string did_you_mean(const char* lead, const std::string& word, const std::vector<std::string>& known) {
  const std::string near = nearest_name(word, known);
  return near.empty() ? "" : fmt::format("{}did you mean '{}'?", lead, near);
}

void print_json(const report::Json& value) { std::fputs(report::to_text(value).c_str(), stdout); }

void print_error(const std::string& line) {
  std::fflush(stdout);
  fmt::print(stderr, "{}\n", line);
}

int print_exception() {
  const auto is_internal = [](const char* what) {
    print_error(fmt::format("feder: internal error, please report it: {}", what));
    return kInternal;
  };
  try {
    throw;
  } catch (const Failure& e) {
    print_error(e.what());
    return e.status();
  } catch (const std::bad_alloc&) {
    print_error("feder: out of memory");
    return kFailed;
  } catch (const std::runtime_error& e) {
    print_error(std::string("feder: ") + e.what());
    return kFailed;
  } catch (const std::exception& e) {
    return is_internal(e.what());
  } catch (...) {
    return is_internal("an unknown exception");
  }
}

int run_program(int argc, char* argv[], const Build& build) {
  const int status = run_guarded(argc, argv, build);
  // what a full disk did not take
  errno = 0;
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout);
  if (!lost || status != kPass) return status;
  const std::string why = errno ? std::string(": ") + std::strerror(errno) : "";
  fmt::print(stderr, "feder: standard output: cannot be written{}\n", why);
  return kFailed;
}

}  // namespace feder::cli
