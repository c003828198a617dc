#include "cli/test_artifacts.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "cli/command.h"
#include "cli/isolate.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;
using report::TestResult;

// "scenes/rigid/tower.lua[height=3]" as the name of a file
std::string plain_name(const TestResult& r) {
  std::string name = r.name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '=') c = '_';
  return name;
}

bool has_command(const std::string& name) {
  for (const Row& row : commands())
    if (name == row.name) return true;
  return false;
}

// Files that a command makes of a scene when it runs as the test did: to its last moment, with its values.
struct Artifact {
  const char* suffix;
  const char* command;
  std::vector<std::string> (*words)(const std::string& time, const std::string& file);
};
constexpr Artifact kArtifacts[] = {
    {".png", "render",
     [](const std::string& time, const std::string& file) -> std::vector<std::string> {
       return {"--at", time, "--out", file, "--size", "800x450"};
     }},
    {".rec", "run",
     [](const std::string& time, const std::string& file) -> std::vector<std::string> {
       return {"--seconds", time, "--record", file};
     }},
};

void write_text(const fs::path& file, const TestResult& r) {
  std::ofstream out(file, std::ios::binary);
  out << r.name << ": " << name_of(r.status) << "\n";
  for (const report::TestFailure& f : r.failures) {
    out << report::failure_text(f) << "\n";
    for (const std::string& line : report::failure_details(f)) out << "  " << line << "\n";
  }
  out << "again: " << r.again << "\n";
  out << r.diff << (r.output.empty() ? "" : "--- printed\n") << r.output;
  if (!r.events.empty()) out << "--- last events\n" << r.events;
  if (!out.flush()) throw Failure(kFailed, file.string() + ": cannot be written");
}

}  // namespace

std::string save_artifacts(const std::string& folder, const TestResult& result, const Options& options) {
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path base = fs::path(folder) / plain_name(result);
  std::string files = base.string() + ".txt";
  write_text(files, result);
  if (!result.scene || result.time < 0) return files;
  // options of the command, the case, and what a random test drew
  std::vector<std::string> shared = {result.file, "--quiet"};
  add_scene_options(shared, options);
  for (const std::string& s : result.set) add_options(shared, {{"--set", s}});
  add_options(shared, {{"--seed", options.seed.empty() ? result.seed : options.seed},
                       {"--limit", options.limit},
                       {"--memory", options.memory},
                       {"--timeout", options.timeout.empty() ? "60" : options.timeout}});
  for (const std::string& s : result.drawn) add_options(shared, {{"--set", s}});
  for (const Artifact& a : kArtifacts) {
    if (!has_command(a.command)) continue;
    const std::string file = base.string() + a.suffix;
    std::vector<std::string> words = {a.command};
    words.insert(words.end(), shared.begin(), shared.end());
    const std::vector<std::string> own = a.words(fmt::format("{:.17g}", result.time), file);
    words.insert(words.end(), own.begin(), own.end());
    // a run that fails as the test did has its file all the same
    std::error_code none;
    fs::remove(file, none);
    run_own_program(words);
    if (fs::exists(file, none)) files += ", " + file;
  }
  return files;
}

}  // namespace feder::cli
