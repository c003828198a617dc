// The problems of `feder study`: found by name, listed with parameters and reference.
#include <algorithm>
#include <filesystem>

#include "cli/command.h"
#include "cli/study_parts.h"
#include "report/table.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;

fs::path study_folder() { return scenes_folder() / "study"; }

std::string unknown_problem(const std::string& name) {
  const std::vector<std::string> known = problem_names();
  return fmt::format("feder study: unknown problem '{}'{} known: {}; or the file of a scene", name,
                     did_you_mean("; ", name, known), fmt::join(known, ", "));
}

bool in_table(const std::string& name) {
  const auto rows = study_problems();
  return std::ranges::any_of(rows, [&](const auto& row) { return name == row.name; });
}

// All that this build can run: scenes whose systems it lacks do not open.
std::vector<std::unique_ptr<StudyProblem>> all_problems(const Options& options) {
  std::vector<std::unique_ptr<StudyProblem>> out;
  Options own = options;
  own.set.clear();
  for (const std::string& name : problem_names()) try {
      out.push_back(open_problem(name, own));
    } catch (const Failure& e) {
      if (in_table(name) || e.status() != kLoadError) throw;
    }
  return out;
}

std::string range_text(const ProblemParam& p) {
  if (!p.choices.empty()) return fmt::format("{}", fmt::join(p.choices, "|"));
  return std::isfinite(p.lo) && std::isfinite(p.hi) ? fmt::format("{:g} .. {:g}", p.lo, p.hi) : "";
}

}  // namespace

std::vector<std::string> split_list(const std::string& text, char separator) {
  std::vector<std::string> out;
  std::size_t at = 0;
  while (at <= text.size() && !text.empty()) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

bool is_scene_file(const std::string& name) {
  return name.ends_with(".lua") || name.ends_with(".yaml") || name.ends_with(".yml");
}

std::vector<std::string> problem_names() {
  std::vector<std::string> names, scenes;
  for (const auto& row : study_problems()) names.emplace_back(row.name);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(study_folder(), ignored))
    if (is_scene_file(entry.path().string())) scenes.push_back(entry.path().stem().string());
  std::ranges::sort(scenes);
  names.insert(names.end(), scenes.begin(), scenes.end());
  return names;
}

std::string problem_file(const std::string& name) {
  if (is_scene_file(name)) return name;
  if (name.empty() || in_table(name) || name.find('/') != std::string::npos) return "";
  for (const char* ending : {".lua", ".yaml"}) {
    const fs::path file = study_folder() / (name + ending);
    std::error_code ignored;
    if (fs::exists(file, ignored)) return file.lexically_proximate(fs::current_path()).string();
  }
  return "";
}

std::unique_ptr<StudyProblem> open_problem(const std::string& name, const Options& options) {
  if (const std::string file = problem_file(name); !file.empty()) return open_scene(file, options);
  if (!in_table(name)) throw Failure(kUsage, unknown_problem(name));
  try {
    Params params;
    for (const std::string& assignment : options.set) set_option(params, assignment);
    return make_study_problem(name, params);
  } catch (const SceneError& e) {
    throw Failure(kUsage, "feder study {}: --set: {}", name, e.what());
  }
}

std::string problem_list_text(const Options& options) {
  const auto problems = all_problems(options);
  report::Table table({"problem", "family", "reference", ">digits", "what it is"});
  report::Table params({"problem", "parameter", ">default", "range", "meaning"});
  for (const auto& problem : problems) {
    const ProblemInfo& info = problem->info();
    table.add(
        {info.name, info.family, name_of(info.reference.kind), std::to_string(info.reference.digits), info.summary});
    for (const ProblemParam& p : info.params) params.add({info.name, p.name, p.fallback, range_text(p), p.help});
  }
  return table.text() + "\nparameters (--set NAME=VALUE):\n" + params.text("  ") +
         "\nsuites (--suite NAME): " + suite_names() + "\n";
}

report::Json problem_list_json(const Options& options) {
  report::Json out = report::Json::array();
  for (const auto& problem : all_problems(options)) {
    const ProblemInfo& info = problem->info();
    report::Json params = report::Json::array(), methods = report::Json::array();
    for (const ProblemParam& p : info.params)
      params.push_back({{"name", p.name}, {"default", p.fallback}, {"range", range_text(p)}, {"help", p.help}});
    for (const MethodInfo& m : problem->methods()) methods.push_back(m.name);
    out.push_back({{"name", info.name},
                   {"summary", info.summary},
                   {"family", info.family},
                   {"reference",
                    {{"kind", name_of(info.reference.kind)},
                     {"digits", info.reference.digits},
                     {"source", info.reference.source}}},
                   {"params", params},
                   {"methods", methods}});
  }
  return out;
}

}  // namespace feder::cli
