// The problems of `feder study`: found by name, listed with parameters and reference.
#include <fmt/format.h>

#include <filesystem>

#include "cli/command.h"
#include "cli/study_parts.h"
#include "report/table.h"

namespace feder::cli {
namespace {

std::string unknown_problem(const std::string& name) {
  std::vector<std::string> known;
  std::string list;
  for (const auto& row : study_problems()) {
    known.emplace_back(row.name);
    list += (list.empty() ? "" : ", ") + known.back();
  }
  std::string message = fmt::format("feder study: unknown problem '{}'", name);
  const std::string near = nearest_name(name, known);
  if (!near.empty()) message += fmt::format("; did you mean '{}'?", near);
  return message + " known: " + list + "; or the file of a scene";
}

std::string range_text(const ProblemParam& p) {
  if (!p.choices.empty()) {
    std::string list;
    for (const std::string& c : p.choices) list += (list.empty() ? "" : "|") + c;
    return list;
  }
  return std::isfinite(p.lo) && std::isfinite(p.hi) ? fmt::format("{:g} .. {:g}", p.lo, p.hi) : "";
}

}  // namespace

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> out;
  std::size_t at = 0;
  while (at <= text.size() && !text.empty()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    out.push_back(text.substr(at, comma - at));
    at = comma + 1;
  }
  return out;
}

bool is_scene_file(const std::string& name) {
  return name.ends_with(".lua") || name.ends_with(".yaml") || name.ends_with(".yml");
}

std::unique_ptr<StudyProblem> open_problem(const std::string& name, const std::vector<std::string>& set) {
  bool known = false;
  for (const auto& row : study_problems()) known = known || name == row.name;
  if (!known) throw Failure(kUsage, unknown_problem(name));
  try {
    Params params;
    for (const std::string& assignment : set) set_option(params, assignment);
    return make_study_problem(name, params);
  } catch (const SceneError& e) {
    throw Failure(kUsage, fmt::format("feder study {}: --set: {}", name, e.what()));
  }
}

std::string problem_list_text() {
  std::string out;
  report::Table table({"problem", "family", "reference", ">digits", "what it is"});
  for (const auto& row : study_problems()) {
    const auto problem = make_study_problem(row.name, {});
    const ProblemInfo& info = problem->info();
    table.add(
        {row.name, info.family, name_of(info.reference.kind), std::to_string(info.reference.digits), info.summary});
  }
  out += table.text() + "\nparameters (--set NAME=VALUE):\n";
  report::Table params({"problem", "parameter", ">default", "range", "meaning"});
  for (const auto& row : study_problems()) {
    const auto problem = make_study_problem(row.name, {});
    for (const ProblemParam& p : problem->info().params)
      params.add({row.name, p.name, p.fallback, range_text(p), p.help});
  }
  return out + params.text("  ") + "\nsuites (--suite NAME): " + suite_names() + "\n";
}

report::Json problem_list_json() {
  report::Json out = report::Json::array();
  for (const auto& row : study_problems()) {
    const auto problem = make_study_problem(row.name, {});
    const ProblemInfo& info = problem->info();
    report::Json params = report::Json::array(), methods = report::Json::array();
    for (const ProblemParam& p : info.params)
      params.push_back({{"name", p.name}, {"default", p.fallback}, {"range", range_text(p)}, {"help", p.help}});
    for (const MethodInfo& m : problem->methods()) methods.push_back(m.name);
    out.push_back({{"name", row.name},
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
