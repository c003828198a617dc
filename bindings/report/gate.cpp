#include "report/gate.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "report/study_text.h"
#include "report/xml.h"

namespace feder::report {
namespace {

std::string cell(const CsvRow& row, const std::string& name) {
  const auto found = row.find(name);
  return found == row.end() ? "" : found->second;
}

double number(const std::string& text) {
  double value = NAN;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// A point's identity in the plan: its name in both tables.
std::string key(const CsvRow& row) {
  std::string out = cell(row, "problem") + " " + cell(row, "method");
  for (const char* rung : {"h_s", "tol", "iters", "substeps"})
    // a rounding of the step size on another machine is no other point
    if (!cell(row, rung).empty()) out += fmt::format(" {}={}", rung, number_text(number(cell(row, rung)), 6));
  if (!cell(row, "settings").empty()) out += " " + cell(row, "settings");
  return out;
}

Json shown(const std::string& text) {
  const double value = number(text);
  if (!std::isfinite(value)) return text;
  const bool whole = text.find_first_of(".e") == std::string::npos;
  return whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
}

}  // namespace

std::vector<CsvRow> read_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1, std::vector<std::string>(1));
  bool inside = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    std::string& last = lines.back().back();
    if (inside) {
      if (c != '"')
        last += c;
      else if (k + 1 < text.size() && text[k + 1] == '"')
        last += '"', ++k;
      else
        inside = false;
    } else if (c == '"') {
      inside = true;
    } else if (c == ',') {
      lines.back().emplace_back();
    } else if (c == '\n') {
      lines.emplace_back(1);
    } else if (c != '\r') {
      last += c;
    }
  }
  if (inside) throw std::runtime_error(fmt::format("line {}: a quote is not closed", lines.size()));
  std::vector<CsvRow> rows;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    if (lines[k].size() == 1 && lines[k][0].empty()) continue;
    if (lines[k].size() != lines[0].size())
      throw std::runtime_error(
          fmt::format("line {}: expected {} columns, got {}", k + 1, lines[0].size(), lines[k].size()));
    CsvRow row;
    for (std::size_t i = 0; i < lines[k].size(); ++i) row[lines[0][i]] = lines[k][i];
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<CsvRow> read_baseline(const std::string& file) {
  try {
    if (file.ends_with(".json")) return read_csv(points_csv(study_from_json(read_json(file))));
    std::vector<CsvRow> rows = read_csv(read_bytes(file));
    if (rows.empty() || !rows[0].contains("method") || !rows[0].contains("status"))
      throw std::runtime_error("expected a points.csv or a report.json of a study");
    return rows;
  } catch (const std::runtime_error& e) {
    const std::string what = e.what();
    throw std::runtime_error(what.starts_with(file) ? what : file + ": " + what);
  }
}

Json check_gate(const std::string& file, const std::vector<CsvRow>& baseline, const std::vector<CsvRow>& rows,
                const std::vector<double>& floors, const GateTiers& tiers) {
  Json violations = Json::array();
  std::map<std::string, std::size_t> now;
  for (std::size_t k = 0; k < rows.size(); ++k) now[key(rows[k])] = k;
  const auto violate = [&](const CsvRow& was, const std::string& field, const std::string& is,
                           const std::string& limit) {
    violations.push_back({{"point", key(was)},
                          {"field", field},
                          {"was", shown(cell(was, field))},
                          {"now", shown(is)},
                          {"limit", limit}});
  };
  int compared = 0;
  for (const CsvRow& was : baseline) {
    const auto found = now.find(key(was));
    if (found == now.end()) {
      violate(was, "status", "missing", "every point of the baseline is there");
      continue;
    }
    ++compared;
    const CsvRow& is = rows[found->second];
    const auto exact = [&](const char* field) {
      if (cell(was, field) != cell(is, field)) violate(was, field, cell(is, field), "exact");
    };
    const auto near = [&](const char* field, double limit, double floor, bool less_is_fine) {
      const double a = number(cell(was, field)), b = number(cell(is, field));
      if (std::isnan(a) && std::isnan(b)) return;
      if (a <= floor && b <= floor) return;
      if (std::fabs(b - a) <= limit * std::fabs(a) || (less_is_fine && b < a)) return;
      violate(was, field, cell(is, field), fmt::format("relative {}", number_text(limit)));
    };
    if (tiers.cost)
      for (const char* field : {"status", "steps", "rejected", "force_evals", "jac_evals", "linear_solves"})
        exact(field);
    if (tiers.error && cell(was, "status") == "ok")
      for (const char* field : {"err_end", "err_traj_rms"})
        near(field, tiers.error_limit, floors[found->second], false);
    if (tiers.size) near("peak_bytes", 0.02, 0, true);
  }
  return {{"baseline", file}, {"compared", compared}, {"violations", violations}};
}

}  // namespace feder::report
