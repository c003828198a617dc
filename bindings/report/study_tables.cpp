// The decision table of a study: for each error the cheapest method, as text and as Markdown.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "report/study_text.h"
#include "report/table.h"
#include "report/xml.h"

namespace feder::report {
namespace {

std::string method_text(const CostToAccuracy& c, const DecisionFormat& f) {
  return c.method.empty() ? f.none : c.method;
}

std::string step_text(const CostToAccuracy& c, const DecisionFormat& f) {
  if (c.method.empty()) return f.none;
  if (std::isfinite(c.tol) && c.tol > 0) return fmt::format("tol{}{}", f.equals, number_text(c.tol, 2));
  return fmt::format("h{}{}{}", f.equals, number_text(c.h_s, 2), f.step_unit);
}

std::string count_text(double value, const DecisionFormat& f) {
  if (!std::isfinite(value)) return f.none;
  return value < 1e6 ? fmt::format("{:.0f}", value) : number_text(value);
}

std::string time_text(double seconds, const DecisionFormat& f) {
  if (!std::isfinite(seconds)) return f.none;
  if (seconds >= 1) return number_text(seconds) + " s";
  return seconds >= 1e-3 ? number_text(seconds * 1e3) + " ms" : number_text(seconds * 1e6) + f.microseconds;
}

// Did the solver of this method miss its tolerance anywhere near?
bool has_slow_points(const StudyResult& r, const std::string& method) {
  return std::ranges::any_of(r.points,
                             [&](const StudyPoint& p) { return p.method == method && p.status == PointStatus::slow; });
}

std::string best_text(const StudyResult& r) {
  const StudyPoint* best = nullptr;
  for (const StudyPoint& p : r.points)
    if (p.completed && std::isfinite(p.err_end) && (!best || p.err_end < best->err_end)) best = &p;
  if (!best) return "no run reached the end";
  return fmt::format("not reached; best {} by {}", number_text(best->err_end, 2), best->method);
}

}  // namespace

std::string target_text(double target) {
  return target > 5e-4 ? number_text(target, 2) : fmt::format("1e{}", std::lround(std::log10(target)));
}

std::vector<Decision> decisions(const StudyResult& r) {
  std::map<double, Decision, std::greater<>> by_target;
  std::map<double, int> reached;
  for (const CostToAccuracy& c : r.cost_to_accuracy) {
    Decision& d = by_target[c.target];
    d.target = c.target;
    d.reached = true;
    ++reached[c.target];
    if (c.cheapest_time) d.by_time = c;
    if (c.cheapest_work) d.by_work = c;
  }
  std::vector<Decision> out;
  for (double target = 0.1; target > 0.9e-10; target /= 10) {
    const double exact = std::stod(fmt::format("{:.0e}", target));
    const auto found =
        std::ranges::find_if(by_target, [&](const auto& d) { return std::fabs(d.first / exact - 1) < 1e-6; });
    if (found == by_target.end()) {
      const bool uncertain = exact < r.problem.reference.floor();
      out.push_back({exact, false, {}, {}, uncertain ? "below the certainty of the reference" : best_text(r)});
      if (out.size() > 1 || exact < 1e-2) break;
      continue;
    }
    Decision d = found->second;
    const std::string& method = d.by_work.method.empty() ? d.by_time.method : d.by_work.method;
    d.verdict = fmt::format("reached by {} of {}", reached[found->first], r.methods.size());
    if (has_slow_points(r, method)) d.verdict += "; its solver missed its tolerance on some rungs";
    out.push_back(d);
  }
  return out;
}

Table decision_table(const StudyResult& r, const DecisionFormat& f) {
  const bool times = has_times(r);
  std::vector<std::string> columns = {">error below", "least work", "step", f.force_evals, ">work"};
  if (times) columns.insert(columns.end(), {f.least_time, "step", ">time"});
  columns.emplace_back("verdict");
  Table table(columns);
  for (const Decision& d : decisions(r)) {
    std::vector<std::string> row = {target_text(d.target), method_text(d.by_work, f), step_text(d.by_work, f),
                                    count_text(d.by_work.force_evals, f), count_text(d.by_work.work, f)};
    if (times)
      row.insert(row.end(), {method_text(d.by_time, f), step_text(d.by_time, f), time_text(d.by_time.time_s, f)});
    row.push_back(d.verdict);
    table.add(row, d.reached ? "" : "bad");
  }
  return table;
}

std::string study_table(const StudyResult& r) { return decision_table(r, kTerminal).text("  "); }

std::string study_summary(const StudyResult& r, bool table_only) {
  if (table_only) return study_table(r);
  const ReferenceInfo& ref = r.problem.reference;
  std::string out = fmt::format("{}: {}\n", problem_label(r.problem), r.problem.summary);
  out += fmt::format("  reference: {}; t = {} s; {} methods, {} runs\n\n", reference_text(ref),
                     number_text(r.problem.t_end, 6), r.methods.size(), r.points.size());
  out += study_table(r);
  const auto list = [&](const char* word, const std::vector<std::string>& lines) {
    if (!lines.empty()) out += "\n";
    for (const std::string& line : lines) out += fmt::format("  {} {}\n", word, line);
  };
  list("failed ", failed_methods(r));
  list("order  ", off_orders(r));
  return out;
}

std::vector<std::string> off_orders(const StudyResult& r) {
  std::vector<std::string> out;
  for (const OrderFit& f : r.fits) {
    if (!f.off()) continue;
    std::string line = fmt::format("{}: fitted {:.2f}, expected {}, over h = {} to {} s", f.method, f.slope,
                                   number_text(f.expected, 2), number_text(f.lo, 2), number_text(f.hi, 2));
    out.push_back(line + listed_settings(f.settings));
  }
  return out;
}

std::vector<std::string> failed_methods(const StudyResult& r) {
  std::vector<std::string> out;
  for (const MethodInfo& m : r.methods) {
    int all = 0;
    std::map<std::string, int> by_status;
    const StudyPoint* first = nullptr;
    for (const StudyPoint& p : r.points) {
      if (p.method != m.name) continue;
      ++all;
      if (succeeded(p)) continue;
      ++by_status[name_of(p.status)];
      if (!first) first = &p;
    }
    if (!first) continue;
    std::string line;
    for (const auto& [status, count] : by_status)
      line += fmt::format("{}{} {}", line.empty() ? "" : ", ", status, count);
    line = fmt::format("{}: {} of {} rungs; first at {}", m.name, line, all, rung_text(*first));
    if (!first->reason.empty()) line += ": " + first->reason;
    out.push_back(line);
  }
  return out;
}

std::string study_markdown(const StudyResult& r, const std::string& picture) {
  std::string out;
  if (!picture.empty()) out += fmt::format("![error against work: {}]({})\n\n", r.problem.name, picture);
  const bool times = has_times(r);
  out += "| you want an error below | use | at | force evaluations | work |";
  out += times ? " by the clock | at | time |\n" : "\n";
  out += "|---|---|---|---|---|";
  out += times ? "---|---|---|\n" : "\n";
  for (const Decision& d : decisions(r)) {
    if (!d.reached) {
      out += fmt::format("| {} | {} | | | |{}\n", target_text(d.target), d.verdict, times ? " | | |" : "");
      continue;
    }
    const CostToAccuracy &work = d.by_work, &time = d.by_time;
    out += fmt::format("| {} | `{}` | {} | {} | {} |", target_text(d.target), work.method, step_text(work, kTerminal),
                       count_text(work.force_evals, kTerminal), count_text(work.work, kTerminal));
    if (times)
      out +=
          fmt::format(" `{}` | {} | {} |", time.method, step_text(time, kTerminal), time_text(time.time_s, kTerminal));
    out += "\n";
  }
  return out;
}

}  // namespace feder::report
