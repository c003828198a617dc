#include "report/study_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "report/page.h"
#include "report/xml.h"

namespace feder::report {
namespace {

void decision_part(Page& page, const StudyResult& r) {
  page.heading("Which method to pick");
  page.paragraph("For each error the cheapest method, between two of its own points (log-log), never beyond them.");
  page.table(decision_table(r, kPaper));
}

// The orders of a method: of each refinement axis of its ladder, or the range over settings.
std::string fitted_words(const StudyResult& r, const MethodInfo& m) {
  std::string each, axis;
  double low = NAN, high = NAN;
  for (const OrderFit& f : r.fits) {
    if (f.method != m.name || !std::isfinite(f.slope)) continue;
    low = std::fmin(low, f.slope), high = std::fmax(high, f.slope), axis = f.axis;
    if (!f.refinement_axis.empty()) each += fmt::format("{}{:.2f} ({})", each.empty() ? "" : ", ", f.slope, f.axis);
  }
  if (!each.empty()) return each;
  if (high - low > 0.005) return fmt::format("{:.2f} to {:.2f} ({})", low, high, axis);
  return std::isfinite(low) ? fmt::format("{:.2f} ({})", low, axis) : "–";
}

void method_part(Page& page, const StudyResult& r) {
  page.heading("Methods");
  Table table({"method", ">order", ">fitted", "kind", ">evaluations per step", ">limit h·ω, undamped",
               ">runs that held", ">least end error", "what it is"});
  for (const MethodInfo& m : r.methods) {
    int ok = 0, all = 0;
    double least = INFINITY;
    for (const StudyPoint& p : r.points) {
      if (p.method != m.name) continue;
      ++all;
      if (!succeeded(p)) continue;
      ++ok;
      if (std::isfinite(p.err_end)) least = std::min(least, p.err_end);
    }
    const std::string limit = std::isnan(m.limit_hw)   ? "–"
                              : std::isinf(m.limit_hw) ? "always stable"
                              : m.limit_hw == 0        ? "never stable"
                                                       : number_text(m.limit_hw, 4);
    const char* const kind = m.implicit ? "implicit" : m.adaptive ? "adaptive" : "explicit";
    const bool missed = std::ranges::any_of(r.fits, [&](const OrderFit& f) { return f.method == m.name && f.off(); });
    table.add(
        {m.name, m.order ? std::to_string(m.order) : "–", fitted_words(r, m), kind, std::to_string(m.evals_per_step),
         limit, fmt::format("{} of {}", ok, all), std::isfinite(least) ? number_text(least, 2) : "–", m.summary},
        missed ? "bad" : "");
  }
  page.table(table);
  const std::vector<std::string> off = off_orders(r);
  if (!off.empty()) {
    page.paragraph(
        "Orders that miss theory by more than a quarter (marked): rounding, resonance or too coarse rungs "
        "speak there, not the method:");
    page.list(off);
  }
  const std::vector<std::string> failed = failed_methods(r);
  if (failed.empty()) return;
  page.paragraph("Runs that failed (in the gutter of the figures):");
  page.list(failed);
}

void problem_part(Page& page, const StudyResult& r, const StudyContext& context) {
  const ProblemInfo& p = r.problem;
  page.heading("The problem and its reference");
  const ReferenceInfo& ref = p.reference;
  Table facts({"", ""});
  facts.add({"reference", fmt::format("{}: {}", reference_text(ref), ref.source)});
  facts.add({"its uncertainty", number_text(ref.uncertainty, 2) +
                                    " of the end error; rounding to the scalar type makes " +
                                    number_text(ref.rounding, 2)});
  facts.add({"simulated time", number_text(p.t_end, 6) + " s"});
  facts.add({"degrees of freedom", std::to_string(p.dof)});
  facts.add(
      {"scales", fmt::format("length {}, speed {}, energy {}", number_text(p.x_scale, 4), number_text(p.v_scale, 4),
                             std::isfinite(p.energy_scale) ? number_text(p.energy_scale, 4) + " J" : "–")});
  if (ref.resolution > 0)
    facts.add({"what the spacing leaves",
               "about " + number_text(ref.resolution, 2) + " of the end error, however short the steps"});
  if (p.frequency > 0)
    facts.add(
        {"fastest frequency", number_text(p.frequency, 5) + " 1/s (explicit methods need h below limit / frequency)"});
  if (p.chaotic)
    facts.add({"chaotic", "yes: the horizon, until when the error stays below 1e-3, counts instead of the end error"});
  page.table(facts);
  Table params({"parameter", ">value", ">default", "meaning"});
  for (const ProblemParam& q : p.params)
    params.add({q.name, value_text(q.value), value_text(q.fallback), q.help}, q.value == q.fallback ? "" : "good");
  if (!params.empty()) page.table(params);
  if (!context.settings.empty()) {
    page.paragraph("Options that differ from their defaults:");
    page.list(context.settings);
  }
}

void definitions_part(Page& page, const StudyResult& r) {
  page.heading("What the numbers mean");
  page.definitions({
      {"end error", r.problem.own_measure
                        ? "The problem's own measure: " + r.problem.reference.source + "."
                        : "Root mean square over the observed points of the distance to the reference at the end, "
                          "divided by the length scale."},
      {"trajectory error",
       "The same at 257 equidistant times, between steps by cubic Hermite interpolation of position and velocity, so "
       "that it does not depend on the step count; root mean square and maximum."},
      {"energy error",
       "Largest |E + dissipated - E0| divided by the energy scale max(|E0|, peak kinetic energy of the reference). The "
       "drift is the slope of a straight line through it: symplectic methods swing and do not drift."},
      {"momentum, angular momentum", "Change since the start, divided by the sums of m|v| and m|r||v|."},
      {"constraint", "Largest violation divided by the length that is held, or penetration by size."},
      {"horizon", "First time at which the trajectory error exceeds 1e-3."},
      {"work",
       fmt::format(
           "Force evaluations, with {} for a Jacobian, {} for a step of conjugate gradients and {} for a direct solve.",
           number_text(r.weights.jacobian), number_text(r.weights.cg_iteration), number_text(r.weights.direct_solve))},
      {"evaluations of cloth and fluids",
       "Of cloth a sweep over all constraints, or a small step of all springs; of fluids density and pressure of all "
       "particles. The tolerance of a fluid is the compression it aims at."},
      {"run time",
       "A pass of its own without recording, methods interleaved; the least of the repeats is plotted, the whisker "
       "ends at the 90th percentile. Noisy: median above 1.15 times the least."},
      {"Pareto front",
       "Points with no other point both as cheap and as accurate (for run times: at 0.9 of the cost). Filled; others "
       "are hollow."},
      {"below the reference",
       "Errors below three times the uncertainty of the reference, or of what rounding does, say nothing about the "
       "method: grey, and left out of fits. What rounding does is measured for each run of a net or an equation with "
       "fixed steps: its distance from a twin that started a last place away."},
      {"gutter",
       "Runs without an error to plot, at what they had cost: a cross diverged, a slashed small circle is not a "
       "number, a barred circle was refused."},
  });
}

void machine_part(Page& page, const StudyContext& context) {
  const MachineInfo& m = context.machine;
  page.heading("Machine and build");
  Table facts({"", ""});
  facts.add({"tool", m.tool + (m.git.empty() ? "" : ", commit " + m.git)});
  facts.add({"scalar type", m.real});
  facts.add({"compiler", m.compiler + " " + m.flags});
  facts.add({"contraction, flush to zero", fmt::format("{}, {}", m.fma ? "on" : "off", m.ftz ? "on" : "off")});
  facts.add({"processor",
             fmt::format("{}, {} cores{}", m.cpu, m.cores, m.virtualization == "yes" ? ", virtual machine" : "")});
  facts.add({"system", m.os});
  facts.add({"load before and after", fmt::format("{}, {}", number_text(m.load_before), number_text(m.load_after))});
  facts.add({"timer resolution", number_text(m.timer_resolution_ns) + " ns"});
  facts.add({"date", m.date});
  page.table(facts);
  page.code(context.command);
  page.paragraph("A large study runs in parts under any job scheduler; with GNU parallel:");
  page.code(
      "parallel feder study PROBLEM --shard {}/8 --out part{} ::: 1 2 3 4 5 6 7 8\nfeder study --merge "
      "part*/report.json --out whole");
}

void gate_part(Page& page, const StudyContext& context) {
  if (context.gate.empty()) return;
  page.heading("Gate");
  const Json& violations = context.gate.at("violations");
  page.paragraph(fmt::format("Against {}: {} violations.", context.gate.value("baseline", ""), violations.size()));
  Table table({"point", "field", ">was", ">now", "limit"});
  for (const Json& v : violations)
    table.add(
        {v.value("point", ""), v.value("field", ""), v.at("was").dump(), v.at("now").dump(), v.value("limit", "")});
  if (!table.empty()) page.table(table);
}

}  // namespace

std::string study_page(const StudyResult& r, const StudyContext& context, const std::vector<Figure>& figures) {
  Page page("Error against cost: " + r.problem.name);
  std::string lead = r.problem.summary;
  for (const ProblemParam& p : r.problem.params)
    if (p.value != p.fallback) lead += fmt::format("; {} = {}", p.name, value_text(p.value));
  page.lead(lead);
  if (r.shards > 1 && r.points.size() < r.planned)
    page.paragraph(fmt::format("Part {} of {}: {} of {} points.", r.shard, r.shards, r.points.size(), r.planned));
  if (r.interrupted) page.paragraph(fmt::format("Interrupted: {} of {} points.", r.points.size(), r.planned));
  for (const Figure& f : figures) page.figure(f.inline_svg, f.caption);
  decision_part(page, r);
  method_part(page, r);
  problem_part(page, r, context);
  gate_part(page, context);
  definitions_part(page, r);
  machine_part(page, context);
  return page.text();
}

std::string suite_page(const std::string& suite, const std::vector<StudyResult>& results, const StudyContext& context) {
  Page page("Studies of the suite " + suite);
  Table table({"problem", "reference", ">runs", ">failed", "cheapest at the smallest error reached"});
  std::vector<std::pair<std::string, std::string>> links;
  for (const StudyResult& r : results) {
    const std::string label = problem_label(r.problem);
    links.push_back({label, file_name(label) + "/index.html"});
    const auto failed = r.points.size() - static_cast<std::size_t>(std::ranges::count_if(r.points, succeeded));
    std::string best = "–";
    for (const Decision& d : decisions(r))
      if (d.reached) best = d.by_work.method + " to " + target_text(d.target);
    table.add(
        {label, name_of(r.problem.reference.kind), std::to_string(r.points.size()), std::to_string(failed), best});
  }
  page.links(links);
  page.table(table);
  gate_part(page, context);
  machine_part(page, context);
  return page.text();
}

void write_folder(const std::string& folder, const std::vector<Figure>& figures,
                  const std::vector<std::pair<std::string, std::string>>& texts) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error(folder + ": cannot be made: " + error.message());
  for (const Figure& f : figures) write_text(folder + "/" + f.file, f.svg);
  for (const auto& [file, text] : texts) write_text(folder + "/" + file, text);
}

void write_study(const std::string& folder, const StudyResult& r, const StudyContext& context) {
  const std::vector<Figure> figures = study_figures(r, context);
  write_folder(folder, figures,
               {{"report.json", to_text(study_json(r, context))},
                {"points.csv", points_csv(r)},
                {"index.html", study_page(r, context, figures)}});
}

}  // namespace feder::report
