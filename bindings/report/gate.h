// The gate: the points of a study against a stored baseline. Counts and verdicts are exact, errors may move by a
// thousandth, memory by 2 %; seconds never gate.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "feder/study.h"
#include "report/json.h"

namespace feder::report {

// A table as points.csv has it: rows by column name.
using CsvRow = std::map<std::string, std::string>;
// RFC 4180. std::runtime_error "line N: what is wrong".
std::vector<CsvRow> read_csv(const std::string& text);

// A baseline file: points.csv, or report.json. std::runtime_error "file: what is wrong".
std::vector<CsvRow> read_baseline(const std::string& file);

struct GateTiers {
  bool cost = true, error = true, size = false;
  double error_limit = 1e-3;  // relative; errors below the floor of the reference are not compared
};

// {"baseline": file, "compared": n, "violations": [{point, field, was, now, limit}]}. A point of the baseline that is
// missing now is a violation, a new one is not. `rows` are those of points.csv, `floor` per row belongs to them.
Json check_gate(const std::string& file, const std::vector<CsvRow>& baseline, const std::vector<CsvRow>& rows,
                const std::vector<double>& floors, const GateTiers& tiers);

}  // namespace feder::report
