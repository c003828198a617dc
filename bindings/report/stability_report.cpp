#include "report/stability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/heat_map.h"
#include "report/page.h"
#include "report/study_page.h"
#include "report/table.h"
#include "report/xml.h"

namespace feder::report {

void fields(auto& c, auto& v, const StabilityCell*) {
  v.derived("verdict", name_of(c.verdict));
  v("t_fail", c.t_fail)("entity", c.entity)("error", c.error)("energy_ratio", c.energy_ratio);
  v("constraint", c.constraint)("iters_mean", c.iters_mean)("iters_max", c.iters_max)("missed", c.missed);
}
void fields(auto& l, auto& v, const StabilityLimit*) {
  v("predicted_limit", l.predicted)("observed_limit", l.observed)("z_predicted", l.z_predicted);
  v("z_observed", l.z_observed).derived("relative", l.relative());
}
void fields(auto& e, auto& v, const ExtremeRow*) {
  v("input", e.input)("expected", e.expected)("got", e.got)("detail", e.detail)("pass", e.pass);
}

namespace {

std::string axis_label(const StabilityAxis& a) { return a.unit.empty() ? a.label : a.label + ", " + a.unit; }

// With a capital letter.
std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string lead(const StabilityResult& r) {
  if (r.maps.empty()) return fmt::format("Scalar type {}; each input is given to a world of its own.", r.real);
  std::string text = r.interrupted ? "Interrupted: there would have been more cells. " : "";
  for (const StabilityProblemInfo& info : stability_problem_infos())
    if (info.name == r.maps[0].problem) text += sentence(info.summary) + ". ";
  return text + fmt::format("Scalar type {}; each cell is a run of its own. Point at a cell for its numbers.", r.real);
}

const StabilityLimit* limit_at(const StabilityMap& m, double y) {
  for (const StabilityLimit& l : m.limits)
    if (l.y == y) return &l;
  return nullptr;
}

std::string cell_title(const StabilityMap& m, const StabilityCell& c) {
  std::string text = fmt::format("{}: {} = {}, {} = {}: {}", m.method, m.x.name, number_text(c.x, 4), m.y.name,
                                 number_text(c.y, 4), name_of(c.verdict));
  if (std::isfinite(c.t_fail)) text += fmt::format(" at {} s", number_text(c.t_fail, 4));
  if (!c.entity.empty()) text += fmt::format(" ({})", c.entity);
  if (std::isfinite(c.error)) text += ", error " + number_text(c.error, 3);
  if (std::isfinite(c.energy_ratio)) text += ", energy " + number_text(c.energy_ratio, 3) + " of its scale";
  return text;
}

// Counts and rates are labelled where the cells are.
Axis cell_axis(const StabilityAxis& a) {
  Axis out{axis_label(a), a.logarithmic, 0, 1, a.logarithmic ? TickStyle::power : TickStyle::plain, {}};
  const auto counted = [](double v) { return v == std::round(v) && v >= 1 && v <= 999; };
  if (a.logarithmic && a.values.size() <= 10 && std::ranges::all_of(a.values, counted))
    for (const double v : a.values) out.fixed.push_back({v, number_text(v, 3)});
  return out;
}

HeatMap heat_map(const StabilityMap& m, bool small) {
  HeatMap h;
  h.name = "map_" + m.method;
  h.title = fmt::format("{}: {} % stable", m.method, number_text(100 * m.stable_share, 3));
  if (!small) {
    h.title =
        fmt::format("{} on {}: {} % of the cells stable", m.method, m.problem, number_text(100 * m.stable_share, 3));
    h.subtitle = verdict_shares(m);
  }
  h.x = cell_axis(m.x), h.y = cell_axis(m.y);
  for (const StabilityCell& c : m.cells) h.cells.push_back({c.x, c.y, name_of(c.verdict), c.error, cell_title(m, c)});
  for (const StabilityLimit& l : m.limits) {
    if (std::isfinite(l.predicted) && (!m.x.logarithmic || l.predicted > 0)) h.theory.push_back({l.predicted, l.y});
    if (std::isfinite(l.observed) && (!m.x.logarithmic || l.observed > 0)) h.boundary.push_back({l.observed, l.y});
  }
  h.theory_label = "theoretical limit";
  h.boundary_label = "bisected limit";
  return h;
}

// Both known and finite.
bool comparable(const StabilityLimit& l) {
  return std::isfinite(l.predicted) && std::isfinite(l.observed) && l.predicted != 0;
}

std::string limit_text(double v, const char* unknown, int digits) {
  return std::isnan(v) ? unknown : std::isinf(v) ? "none" : number_text(v, digits);
}

void boundary_part(Page& page, const StabilityResult& r) {
  const auto bisected = [](const StabilityMap& m) { return !m.limits.empty(); };
  if (std::ranges::none_of(r.maps, bisected)) return;
  page.heading("Boundaries");
  page.paragraph(
      "The largest stable value on the x axis, found by bisection, beside what theory says; h·ω is the same in units "
      "of the fastest angular frequency.");
  const auto explained = std::ranges::find_if(r.maps, [](const StabilityMap& m) { return !m.limit_how.empty(); });
  if (explained != r.maps.end()) page.paragraph("How: " + explained->limit_how);
  Table table({"method", ">" + r.maps[0].y.label, ">predicted", ">observed", ">relative deviation", ">h·ω predicted",
               ">h·ω observed"});
  const auto limit = [](double v) { return limit_text(v, "–", 7); };
  for (const StabilityMap& m : r.maps)
    for (const StabilityLimit& l : m.limits) {
      const bool both = comparable(l);
      table.add({m.method, number_text(l.y, 4), limit(l.predicted), limit(l.observed),
                 both ? number_text(l.relative(), 2) : "–", limit(l.z_predicted), limit(l.z_observed)},
                both && l.relative() > 0.01 ? "bad" : "");
    }
  page.table(table);
}

void verdict_part(Page& page, const StabilityResult& r) {
  const StabilityThresholds& t = r.thresholds;
  page.heading("What the verdicts mean");
  page.paragraph("The first that applies, worst first.");
  page.definitions({
      {"nan", "A state went non-finite."},
      {"diverged", fmt::format("A position beyond {} scene lengths, a speed beyond {} times the reference's, or energy "
                               "above {} times its scale.",
                               number_text(t.far), number_text(t.fast), number_text(t.energy))},
      {"growing",
       fmt::format(
           "The largest energy of the last quarter is {} times that of the second, and {} times that of the start.",
           number_text(t.growth), number_text(t.growth_start))},
      {"stuck", fmt::format("The reference moves more than {} % of the scene's length, the run less than {} % of that.",
                            number_text(100 * t.moves), number_text(100 * t.stuck))},
      {"damped",
       fmt::format("More than {} % of the energy scale lost that the model keeps.", number_text(100 * t.damped))},
      {"inaccurate",
       fmt::format("Bounded, but wrong: the error at the end above {} % of the scene's length, or a violation above {} "
                   "% (bodies: "
                   "a penetration above {} % of the smallest size).",
                   number_text(100 * t.inaccurate), number_text(100 * t.constraint), number_text(100 * t.penetration))},
      {"slow", fmt::format("Solves missed their tolerance in more than {} % of the steps.", number_text(100 * t.slow))},
      {"refused", "Rejected with a message that names the object: right for malformed input."},
      {"stable", "None of these; the shade tells the error."},
  });
}

}  // namespace

std::string verdict_shares(const StabilityMap& m) {
  std::vector<std::pair<std::string, int>> counts;  // in the order of the cells
  for (const StabilityCell& c : m.cells) {
    const std::string name = name_of(c.verdict);
    auto found = std::ranges::find_if(counts, [&](const auto& n) { return n.first == name; });
    if (found == counts.end()) found = counts.insert(counts.end(), {name, 0});
    ++found->second;
  }
  std::ranges::stable_sort(counts, [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string out;
  for (const auto& [name, n] : counts)
    out += fmt::format("{}{} % {}", out.empty() ? "" : ", ",
                       number_text(100.0 * n / static_cast<double>(m.cells.size()), 3), name);
  return out;
}

Json stability_json(const StabilityResult& r, const RunContext& context) {
  Json rows = Json::array(), limits = Json::array(), shares = Json::array();
  for (const StabilityMap& m : r.maps) {
    for (const StabilityCell& c : m.cells) {
      const StabilityLimit* l = limit_at(m, c.y);
      Json& row = rows.emplace_back(Json{{"problem", m.problem}, {"method", m.method}});
      row["axes"] = {{m.x.name, json_value(c.x)}, {m.y.name, json_value(c.y)}};
      row.update(written(c));
      row["predicted_limit"] = l ? json_value(l->predicted) : Json();
      row["observed_limit"] = l ? json_value(l->observed) : Json();
    }
    for (const StabilityLimit& l : m.limits)
      limits.emplace_back(Json{{"problem", m.problem}, {"method", m.method}, {m.y.name, json_value(l.y)}})
          .update(written(l));
    shares.push_back({{"problem", m.problem},
                      {"method", m.method},
                      {"order", m.order},
                      {"implicit", m.implicit},
                      {"stable_share", json_value(m.stable_share)}});
  }
  Json json = {{"schema", "stability/1"},
               {"run", written(context.machine)},
               {"command", context.command},
               {"real", r.real},
               {"methods", shares},
               {"limits", limits},
               {"rows", rows}};
  if (r.interrupted) json["interrupted"] = true;
  return json;
}

Json extreme_json(const std::vector<ExtremeRow>& rows) { return written(rows); }

std::string cells_csv(const StabilityResult& r) {
  std::string out =
      "problem,method,x_name,x,y_name,y,verdict,t_fail_s,entity,error,energy_ratio,constraint,iters_mean,iters_max,"
      "predicted_limit,observed_limit\n";
  for (const StabilityMap& m : r.maps)
    for (const StabilityCell& c : m.cells) {
      const StabilityLimit* l = limit_at(m, c.y);
      out += csv_line(m.problem, m.method, m.x.name, c.x, m.y.name, c.y, name_of(c.verdict), c.t_fail, c.entity,
                      c.error, c.energy_ratio, c.constraint, c.iters_mean, c.iters_max, l ? l->predicted : NAN,
                      l ? l->observed : NAN) +
             "\n";
    }
  return out;
}

std::string limits_csv(const StabilityResult& r) {
  std::string out = "problem,method,y_name,y,predicted,observed,relative,z_predicted,z_observed\n";
  for (const StabilityMap& m : r.maps)
    for (const StabilityLimit& l : m.limits)
      out += csv_line(m.problem, m.method, m.y.name, l.y, l.predicted, l.observed, l.relative(), l.z_predicted,
                      l.z_observed) +
             "\n";
  return out;
}

std::string stability_table(const StabilityResult& r) {
  Table table({"method", ">stable", ">h w limit", ">theory", ">worst deviation", "verdicts"});
  for (const StabilityMap& m : r.maps) {
    double worst = NAN;
    for (const StabilityLimit& l : m.limits)
      if (comparable(l) && !(worst >= l.relative())) worst = l.relative();
    const StabilityLimit first = m.limits.empty() ? StabilityLimit{} : m.limits.front();
    table.add({m.method, m.cells.empty() ? "-" : fmt::format("{} %", number_text(100 * m.stable_share, 3)),
               limit_text(first.z_observed, "-", 6), limit_text(first.z_predicted, "-", 6),
               std::isnan(worst) ? "-" : number_text(worst, 2), verdict_shares(m)});
  }
  return table.text("  ");
}

std::string extreme_table(const std::vector<ExtremeRow>& rows) {
  Table table({"", "input", "expected", "got", "detail"});
  for (const ExtremeRow& e : rows) table.add({e.pass ? "ok" : "FAILED", e.input, e.expected, e.got, e.detail});
  return table.text("  ");
}

std::vector<Figure> stability_figures(const StabilityResult& r) {
  std::vector<Figure> out;
  std::vector<HeatMap> small;
  for (const StabilityMap& m : r.maps) {
    if (m.cells.empty()) continue;
    const HeatMap map = heat_map(m, false);
    const std::string file = "map_" + file_name(m.problem) + "_" + file_name(m.method) + ".svg";
    out.push_back({file, m.method, heat_map_svg(map), heat_map_svg(map, true)});
    small.push_back(heat_map(m, true));
  }
  if (small.size() < 2) return out;
  const std::string title = r.maps[0].problem + ": verdicts over " + r.maps[0].x.label + " and " + r.maps[0].y.label;
  out.push_back({"sheet.svg", "All methods on the same axes.", heat_sheet_svg("sheet", title, small, 4),
                 heat_sheet_svg("sheet", title, small, 4, true)});
  return out;
}

std::string stability_page(const StabilityResult& r, const RunContext& context, const std::vector<Figure>& figures,
                           const std::vector<ExtremeRow>& extreme) {
  Page page("Stability: " + (r.maps.empty() ? std::string("extreme inputs") : r.maps[0].problem));
  page.lead(lead(r));
  // the overview first
  for (const Figure& f : figures)
    if (f.file == "sheet.svg") page.figure(f.inline_svg, f.caption);
  if (!extreme.empty()) {
    page.heading("Extreme inputs");
    Table table({"input", "expected", "got", "detail"});
    for (const ExtremeRow& e : extreme) table.add({e.input, e.expected, e.got, e.detail}, e.pass ? "good" : "bad");
    page.table(table);
  }
  boundary_part(page, r);
  if (!figures.empty()) page.heading("Each method");
  for (const Figure& f : figures)
    if (f.file != "sheet.svg") page.figure(f.inline_svg, f.caption);
  verdict_part(page, r);
  page.heading("Machine and build");
  page.paragraph(fmt::format("{}, commit {}, {} {}, {}; {}", context.machine.tool, context.machine.git,
                             context.machine.compiler, context.machine.flags, context.machine.cpu,
                             context.machine.date));
  page.code(context.command);
  return page.text();
}

void write_stability(const std::string& folder, const StabilityResult& r, const RunContext& context,
                     const std::vector<ExtremeRow>& extreme) {
  const std::vector<Figure> figures = stability_figures(r);
  Json json = stability_json(r, context);
  if (!extreme.empty()) json["extreme"] = extreme_json(extreme);
  write_folder(folder, figures,
               {{"stability.json", to_text(json)},
                {"cells.csv", cells_csv(r)},
                {"limits.csv", limits_csv(r)},
                {"index.html", stability_page(r, context, figures, extreme)}});
}

}  // namespace feder::report
