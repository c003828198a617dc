#include "report/stability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "report/heat_map.h"
#include "report/page.h"
#include "report/study_page.h"
#include "report/table.h"
#include "report/xml.h"

namespace feder::report {
namespace {

Json number_json(double v) {
  if (std::isnan(v)) return nullptr;
  if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
  return v;
}

std::string csv_number(double v) { return std::isnan(v) ? "" : fmt::format("{}", v); }

std::string csv_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return text.find_first_of(",\"\n") == std::string::npos ? text : out + "\"";
}

std::string axis_label(const StabilityAxis& a) { return a.unit.empty() ? a.label : a.label + ", " + a.unit; }

// With a capital letter.
std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string lead(const StabilityResult& r) {
  if (r.maps.empty()) return fmt::format("Scalar type {}; each input is given to a world of its own.", r.real);
  std::string text;
  for (const StabilityProblemInfo& info : stability_problem_infos())
    if (info.name == r.maps[0].problem) text = sentence(info.summary) + ". ";
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
  if (a.logarithmic && a.values.size() <= 10 && std::all_of(a.values.begin(), a.values.end(), counted))
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

struct Deviation {
  double worst = NAN;
  int limits = 0;
};
Deviation deviation(const StabilityMap& m) {
  Deviation d;
  for (const StabilityLimit& l : m.limits) {
    if (!std::isfinite(l.predicted) || !std::isfinite(l.observed) || l.predicted == 0) continue;
    ++d.limits;
    if (!(d.worst >= l.relative())) d.worst = l.relative();
  }
  return d;
}

std::string limit_words(double v) { return std::isnan(v) ? "–" : std::isinf(v) ? "none" : number_text(v, 7); }

void boundary_part(Page& page, const StabilityResult& r) {
  bool any = false;
  for (const StabilityMap& m : r.maps) any = any || !m.limits.empty();
  if (!any) return;
  page.heading("Boundaries");
  page.paragraph(
      "The largest stable value on the x axis, found by bisection, beside what theory says; h·ω is the same in units "
      "of the "
      "fastest angular frequency.");
  for (const StabilityMap& m : r.maps)
    if (!m.limit_how.empty()) {
      page.paragraph("How: " + m.limit_how);
      break;
    }
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> marks;
  for (const StabilityMap& m : r.maps)
    for (const StabilityLimit& l : m.limits) {
      const bool both = std::isfinite(l.predicted) && std::isfinite(l.observed) && l.predicted != 0;
      rows.push_back({m.method, number_text(l.y, 4), limit_words(l.predicted), limit_words(l.observed),
                      both ? number_text(l.relative(), 2) : "–", limit_words(l.z_predicted),
                      limit_words(l.z_observed)});
      marks.push_back(both && l.relative() > 0.01 ? "bad" : "");
    }
  const std::string y = r.maps.empty() ? "y" : r.maps[0].y.label;
  page.table({"method", ">" + y, ">predicted", ">observed", ">relative deviation", ">h·ω predicted", ">h·ω observed"},
             rows, marks);
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
  std::vector<std::pair<std::string, int>> counts;
  for (const StabilityCell& c : m.cells) {
    const std::string name = name_of(c.verdict);
    const auto found = std::find_if(counts.begin(), counts.end(), [&](const auto& n) { return n.first == name; });
    if (found == counts.end())
      counts.push_back({name, 1});
    else
      ++found->second;
  }
  std::stable_sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string out;
  for (const auto& [name, n] : counts)
    out += fmt::format("{}{} % {}", out.empty() ? "" : ", ",
                       number_text(100.0 * n / static_cast<double>(m.cells.size()), 3), name);
  return out;
}

Json stability_json(const StabilityResult& r, const StabilityContext& context) {
  Json rows = Json::array(), limits = Json::array(), shares = Json::array();
  for (const StabilityMap& m : r.maps) {
    for (const StabilityCell& c : m.cells) {
      const StabilityLimit* l = limit_at(m, c.y);
      rows.push_back({{"problem", m.problem},
                      {"method", m.method},
                      {"axes", {{m.x.name, number_json(c.x)}, {m.y.name, number_json(c.y)}}},
                      {"verdict", name_of(c.verdict)},
                      {"t_fail", number_json(c.t_fail)},
                      {"entity", c.entity},
                      {"error", number_json(c.error)},
                      {"energy_ratio", number_json(c.energy_ratio)},
                      {"constraint", number_json(c.constraint)},
                      {"iters_mean", number_json(c.iters_mean)},
                      {"iters_max", number_json(c.iters_max)},
                      {"missed", number_json(c.missed)},
                      {"predicted_limit", l ? number_json(l->predicted) : Json()},
                      {"observed_limit", l ? number_json(l->observed) : Json()}});
    }
    for (const StabilityLimit& l : m.limits)
      limits.push_back({{"problem", m.problem},
                        {"method", m.method},
                        {m.y.name, number_json(l.y)},
                        {"predicted_limit", number_json(l.predicted)},
                        {"observed_limit", number_json(l.observed)},
                        {"z_predicted", number_json(l.z_predicted)},
                        {"z_observed", number_json(l.z_observed)},
                        {"relative", number_json(l.relative())}});
    shares.push_back({{"problem", m.problem},
                      {"method", m.method},
                      {"order", m.order},
                      {"implicit", m.implicit},
                      {"stable_share", number_json(m.stable_share)}});
  }
  return {{"schema", "stability/1"},
          {"run", machine_json(context.machine)},
          {"command", context.command},
          {"real", r.real},
          {"methods", shares},
          {"limits", limits},
          {"rows", rows}};
}

std::string cells_csv(const StabilityResult& r) {
  std::string out =
      "problem,method,x_name,x,y_name,y,verdict,t_fail_s,entity,error,energy_ratio,constraint,iters_mean,iters_max,"
      "predicted_limit,observed_limit\n";
  for (const StabilityMap& m : r.maps)
    for (const StabilityCell& c : m.cells) {
      const StabilityLimit* l = limit_at(m, c.y);
      out += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", m.problem, m.method, m.x.name,
                         csv_number(c.x), m.y.name, csv_number(c.y), name_of(c.verdict), csv_number(c.t_fail),
                         csv_text(c.entity), csv_number(c.error), csv_number(c.energy_ratio), csv_number(c.constraint),
                         csv_number(c.iters_mean), csv_number(c.iters_max), l ? csv_number(l->predicted) : "",
                         l ? csv_number(l->observed) : "");
    }
  return out;
}

std::string limits_csv(const StabilityResult& r) {
  std::string out = "problem,method,y_name,y,predicted,observed,relative,z_predicted,z_observed\n";
  for (const StabilityMap& m : r.maps)
    for (const StabilityLimit& l : m.limits)
      out += fmt::format("{},{},{},{},{},{},{},{},{}\n", m.problem, m.method, m.y.name, csv_number(l.y),
                         csv_number(l.predicted), csv_number(l.observed), csv_number(l.relative()),
                         csv_number(l.z_predicted), csv_number(l.z_observed));
  return out;
}

std::string stability_table(const StabilityResult& r) {
  Table table({"method", ">stable", ">h w limit", ">theory", ">worst deviation", "verdicts"});
  for (const StabilityMap& m : r.maps) {
    const Deviation d = deviation(m);
    const StabilityLimit* first = m.limits.empty() ? nullptr : &m.limits.front();
    const auto words = [](double v) {
      return std::isnan(v) ? std::string("-") : std::isinf(v) ? "none" : number_text(v, 6);
    };
    table.add({m.method, m.cells.empty() ? "-" : fmt::format("{} %", number_text(100 * m.stable_share, 3)),
               first ? words(first->z_observed) : "-", first ? words(first->z_predicted) : "-",
               d.limits ? number_text(d.worst, 2) : "-", verdict_shares(m)});
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

std::string stability_page(const StabilityResult& r, const StabilityContext& context,
                           const std::vector<Figure>& figures, const std::vector<ExtremeRow>& extreme) {
  Page page("Stability: " + (r.maps.empty() ? std::string("extreme inputs") : r.maps[0].problem));
  page.lead(lead(r));
  // the overview first
  for (const Figure& f : figures)
    if (f.file == "sheet.svg") page.figure(f.inline_svg, f.caption);
  if (!extreme.empty()) {
    page.heading("Extreme inputs");
    std::vector<std::vector<std::string>> rows;
    std::vector<std::string> marks;
    for (const ExtremeRow& e : extreme) {
      rows.push_back({e.input, e.expected, e.got, e.detail});
      marks.push_back(e.pass ? "good" : "bad");
    }
    page.table({"input", "expected", "got", "detail"}, rows, marks);
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

void write_stability(const std::string& folder, const StabilityResult& r, const StabilityContext& context,
                     const std::vector<ExtremeRow>& extreme) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot be made: " + error.message());
  const std::vector<Figure> figures = stability_figures(r);
  Json json = stability_json(r, context);
  if (!extreme.empty()) {
    json["extreme"] = Json::array();
    for (const ExtremeRow& e : extreme)
      json["extreme"].push_back(
          {{"input", e.input}, {"expected", e.expected}, {"got", e.got}, {"detail", e.detail}, {"pass", e.pass}});
  }
  write_text(folder + "/stability.json", to_text(json));
  write_text(folder + "/cells.csv", cells_csv(r));
  write_text(folder + "/limits.csv", limits_csv(r));
  for (const Figure& f : figures) write_text(folder + "/" + f.file, f.svg);
  write_text(folder + "/index.html", stability_page(r, context, figures, extreme));
}

}  // namespace feder::report
