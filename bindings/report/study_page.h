// index.html of a study, and the folder with all its files.
#pragma once
#include <string>

#include "report/output_file.h"
#include "report/study_figures.h"

namespace feder::report {

std::string study_page(const StudyResult& r, const StudyContext& context, const std::vector<Figure>& figures);

// index.html of a suite: a row per problem, with links to the folders beside it.
std::string suite_page(const std::string& suite, const std::vector<StudyResult>& results, const StudyContext& context);

// Writes report.json, points.csv, the figures and index.html. std::runtime_error "file: cannot be written".
void write_study(const std::string& folder, const StudyResult& r, const StudyContext& context);

// The figures and the texts by the names of their files; the folder is made.
void write_folder(const std::string& folder, const std::vector<Figure>& figures,
                  const std::vector<std::pair<std::string, std::string>>& texts);

}  // namespace feder::report
