// Parts of `feder study`: opening problems, the list of problems, and the suites.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "cli/options.h"
#include "feder/study.h"
#include "report/json.h"
#include "report/machine.h"

namespace feder::cli {

// "a,b" as words; "" as none.
std::vector<std::string> split_list(const std::string& text, char separator = ',');

bool is_scene_file(const std::string& name);

// Problems by name: those of the table, then scenes/study/*.
std::vector<std::string> problem_names();
// The file of a scene, given as such or by the name of a problem; empty for problems of the table and unknown names.
std::string problem_file(const std::string& name);
// With --set options. Failure (usage) names the nearest one.
std::unique_ptr<StudyProblem> open_problem(const std::string& name, const Options& options);

// A .lua or .yaml scene as a problem. Failure says what is wrong with it.
std::unique_ptr<StudyProblem> open_scene(const std::string& file, const Options& options);

// The boxes of a scene's colliders over its first steps as the problem "broad_phase". Failure says what is wrong.
std::unique_ptr<StudyProblem> open_boxes(const std::string& file, const Options& options);

// The whole of which the files are shards, and the machine of the first. Failure (1) names a shard of another study, a
// report that was altered, or the shards that are missing; usage: what cannot be read or came twice.
StudyResult merge_reports(const std::vector<std::string>& files, report::MachineInfo& machine);

// Of the problems that this build can run.
std::string problem_list_text(const Options& options);
report::Json problem_list_json(const Options& options);

// One study of a suite.
struct SuiteRow {
  const char* suite;
  const char* problem;
  std::vector<std::string> set;
  std::vector<std::string> methods;  // empty: all
  std::vector<std::string> ladders;
  std::vector<std::string> may_diverge;  // methods; "*": any
};
// Rows of the suite, without problems this build lacks. Failure (usage) lists the suites.
std::vector<SuiteRow> suite_rows(const std::string& suite);
std::string suite_names();

}  // namespace feder::cli
