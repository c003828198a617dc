// The files of a stability map: stability.json, cells.csv, limits.csv, a heat map per method, a sheet of all, and a
// page.
#pragma once
#include <string>
#include <vector>

#include "feder/study.h"
#include "report/machine.h"
#include "report/study_figures.h"

namespace feder::report {

// One input of the extreme suite and how it ended.
struct ExtremeRow {
  std::string input, expected, got, detail;
  bool pass = false;
};

Json stability_json(const StabilityResult& r, const RunContext& context);
Json extreme_json(const std::vector<ExtremeRow>& rows);
std::string cells_csv(const StabilityResult& r);
std::string limits_csv(const StabilityResult& r);
// Methods against limits and shares, as text.
std::string stability_table(const StabilityResult& r);
std::string extreme_table(const std::vector<ExtremeRow>& rows);

// One per method, then the sheet.
std::vector<Figure> stability_figures(const StabilityResult& r);
std::string stability_page(const StabilityResult& r, const RunContext& context, const std::vector<Figure>& figures,
                           const std::vector<ExtremeRow>& extreme);
// std::runtime_error "file: cannot be written".
void write_stability(const std::string& folder, const StabilityResult& r, const RunContext& context,
                     const std::vector<ExtremeRow>& extreme = {});

// Shares of the verdicts: "62 % stable, 30 % diverged, 8 % damped".
std::string verdict_shares(const StabilityMap& map);

}  // namespace feder::report
