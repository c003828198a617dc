#include "report/study_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "report/figures.h"
#include "report/xml.h"

namespace feder::report {
namespace {

// What a point cost.
struct CostAxis {
  const char *title, *label;
  double StudyPoint::*cost;
  double StudyPoint::*whisker;  // end of the whisker; null: none
  bool StudyPoint::*on_front;
  std::vector<std::size_t> StudyResult::*front;
  TickStyle ticks;
};
constexpr CostAxis kRunTime{"run time",           "run time (least of the repeats)", &StudyPoint::t_min_s,
                            &StudyPoint::t_p90_s, &StudyPoint::on_front_time,        &StudyResult::front_time,
                            TickStyle::seconds};
constexpr CostAxis kWork{"work",          "work, in force evaluations", &StudyPoint::work,
                         nullptr,         &StudyPoint::on_front_work,   &StudyResult::front_work,
                         TickStyle::power};

bool measured(const StudyPoint& p, const ErrorNorm& norm) { return succeeded(p) && std::isfinite(p.*norm.value); }

bool any_measured(const StudyResult& r, const ErrorNorm& norm) {
  return std::ranges::any_of(r.points, [&](const StudyPoint& p) { return measured(p, norm); });
}

MarkKind kind_of(const StudyResult& r, const StudyPoint& p, const ErrorNorm& norm, bool on_front) {
  switch (p.status) {
    case PointStatus::diverged: return MarkKind::diverged;
    case PointStatus::nan: return MarkKind::nan;
    case PointStatus::refused: return MarkKind::refused;
    default: break;
  }
  if (!measured(p, norm)) return MarkKind::other;
  if (p.below_floor && norm.ranks(r.problem) && !norm.more_is_better) return MarkKind::uncertain;
  return on_front ? MarkKind::filled : MarkKind::hollow;
}

int number_of(const StudyResult& r, const std::string& method) {
  for (std::size_t k = 0; k < r.methods.size(); ++k)
    if (r.methods[k].name == method) return static_cast<int>(k);
  return static_cast<int>(r.methods.size());
}

// A line for people, then the row of points.csv.
std::string point_title(const StudyResult& r, const StudyPoint& p, const ErrorNorm& norm) {
  std::string text = fmt::format("{}, {}: {}", p.method, rung_text(p), name_of(p.status));
  if (std::isfinite(p.*norm.value)) text += fmt::format(", {} {}", norm.column, number_text(p.*norm.value, 4));
  text += fmt::format(", {} force evaluations", p.count.force_evals);
  if (std::isfinite(p.t_min_s)) text += fmt::format(", {} s", number_text(p.t_min_s, 4));
  if (!p.reason.empty()) text += "\n" + p.reason;
  return text + "\n" + csv_measured(r.problem.name, p);
}

std::string reference_words(const StudyResult& r) {
  return fmt::format("reference: {}; t = {} s", reference_text(r.problem.reference), number_text(r.problem.t_end, 6));
}

// The runs of a method that a curve joins: they differ in one thing only, the step or what is refined in its stead. All
// else that a study varies makes curves of their own, and so does each refinement axis of a ladder that has several.
struct RefinementCurve {
  std::string name, method;
  int number = 0;  // of the curve style
  std::vector<const StudyPoint*> points;
  std::string axis;  // StudyPoint::refinement_axis
};

std::string axis_name(const std::string& axis) {
  if (axis == "steps") return "shorter steps";
  if (axis == "iters") return "more iterations";
  return axis == "tol" ? "smaller tolerance" : "more " + axis;
}

std::string beside_rung(const StudyPoint& p, bool steps_vary, bool substeps_vary) {
  std::string out;
  if (steps_vary && substeps_vary && p.substeps >= 0) out += fmt::format(", {} substeps", p.substeps);
  if ((steps_vary || substeps_vary) && p.iters >= 0) out += fmt::format(", {} iterations", p.iters);
  return out + listed_settings(p.settings);
}

std::vector<RefinementCurve> refinement_curves(const StudyResult& r, const std::string& method) {
  // what varies besides the axis is named with the curve
  const StudyPoint* first = nullptr;
  bool steps_vary = false, substeps_vary = false;
  for (const StudyPoint& p : r.points) {
    if (p.method != method) continue;
    if (!first) first = &p;
    const bool same_tolerance = p.tol == first->tol || (std::isnan(p.tol) && std::isnan(first->tol));
    steps_vary = steps_vary || p.h_s != first->h_s || !same_tolerance;
    substeps_vary = substeps_vary || p.substeps != first->substeps;
  }
  std::vector<RefinementCurve> curves;
  for (const StudyPoint& p : r.points) {
    if (p.method != method) continue;
    const std::string name = p.refinement_axis.empty() ? method + beside_rung(p, steps_vary, substeps_vary)
                                                       : method + ", " + axis_name(p.refinement_axis);
    auto at = std::ranges::find_if(curves, [&](const RefinementCurve& c) { return c.name == name; });
    if (at == curves.end()) at = curves.insert(curves.end(), {name, method, 0, {}, p.refinement_axis});
    at->points.push_back(&p);
  }
  if (curves.size() == 1) curves[0].name = method;
  return curves;
}

// Those of all methods, numbered. Curves of several refinement axes get numbers beside those of the other methods,
// which may have fewer.
std::vector<RefinementCurve> refinement_curves(const StudyResult& r) {
  std::vector<RefinementCurve> all;
  for (const MethodInfo& m : r.methods) {
    std::vector<RefinementCurve> curves = refinement_curves(r, m.name);
    const auto before = static_cast<int>(all.size()), count = static_cast<int>(curves.size());
    int number = curves.empty() || !curves[0].axis.empty() ? before : number_of(r, m.name) * count;
    for (RefinementCurve& curve : curves) curve.number = number++;
    all.insert(all.end(), curves.begin(), curves.end());
  }
  return all;
}

// An error as it counts for the ends of an axis: those of 0 and of a blow-up get no say.
double cut_error(double error) {
  const double e = std::max(error, error > 0 ? 1e-17 : 0.0);
  return std::isfinite(e) ? std::min(e, 100.0) : e;
}

// Axis ends from the points that can be shown.
void fit_axes(Plot& plot, const CostAxis& axis, const ErrorNorm& norm) {
  std::vector<double> xs, ys;
  double cheapest = INFINITY;
  for (const PlotSeries& s : plot.series)
    for (const PlotPoint& p : s.points)
      if (!is_failure(p.kind) && p.x > 0) cheapest = std::min(cheapest, p.x);
  for (const PlotSeries& s : plot.series)
    for (const PlotPoint& p : s.points) {
      // runs that failed at once cost next to nothing: they must not push the others aside
      xs.push_back(is_failure(p.kind) && std::isfinite(cheapest) ? std::max(p.x, cheapest / 10) : p.x);
      if (p.x_far > p.x) xs.push_back(p.x_far);
      if (!is_failure(p.kind)) ys.push_back(cut_error(p.y));
    }
  if (plot.uncertain_below > 0) ys.push_back(plot.uncertain_below);
  plot.x = fit_axis(axis.label, true, xs, axis.ticks);
  if (norm.more_is_better) ys.push_back(0);
  plot.y = fit_axis(norm.label, !norm.more_is_better, ys, norm.more_is_better ? TickStyle::plain : TickStyle::power);
}

Plot cost_plot(const StudyResult& r, const ErrorNorm& norm, const CostAxis& axis, const std::string& file) {
  const bool ranked = norm.ranks(r.problem);
  Plot plot;
  plot.name = file.substr(0, file.find('.'));
  plot.title = fmt::format("{}: error against {}", problem_label(r.problem), axis.title);
  plot.subtitle = (norm.more_is_better ? "upper left is better; " : "lower left is better; ") + reference_words(r);
  for (const RefinementCurve& curve : refinement_curves(r)) {
    PlotSeries series{curve.name, curve.number, {}};
    for (const StudyPoint* p : curve.points) {
      const double whisker = axis.whisker && std::isfinite(p->*axis.whisker) ? p->*axis.whisker : 0;
      series.points.push_back({p->*axis.cost, p->*norm.value, whisker,
                               kind_of(r, *p, norm, ranked && p->*axis.on_front), point_title(r, *p, norm)});
    }
    plot.series.push_back(series);
  }
  // the Pareto front of each setting, and the band below what the reference resolves
  if (ranked) {
    std::map<Settings, std::vector<XY>> fronts;
    for (const std::size_t k : r.*axis.front)
      fronts[r.points[k].settings].push_back({r.points[k].*axis.cost, r.points[k].*norm.value});
    for (auto& [settings, front] : fronts) plot.fronts.push_back(std::move(front));
    const double floor = r.problem.reference.floor();
    const bool near = !norm.more_is_better && std::ranges::any_of(r.points, [&](const StudyPoint& p) {
      return measured(p, norm) && p.*norm.value < 30 * floor;
    });
    if (near) plot.uncertain_below = floor, plot.uncertain_label = "reference or rounding";
  }
  fit_axes(plot, axis, norm);
  return plot;
}

const StudyPoint* point_of(const StudyResult& r, const StudySeries& s) {
  for (const StudyPoint& p : r.points)
    if (p.index == s.point) return &p;
  return nullptr;
}

const OrderFit* fit_of(const StudyResult& r, const StudyPoint& p) {
  for (const OrderFit& f : r.fits)
    if (f.method == p.method && f.settings == p.settings && f.refinement_axis == p.refinement_axis) return &f;
  return nullptr;
}

double rung_value(const StudyPoint& p, const std::string& axis) {
  if (axis == "tol") return p.tol;
  if (axis == "iters") return p.iters;
  if (axis == "substeps") return p.substeps;
  return p.h_s;
}

std::string rung_label(const std::string& axis) {
  if (axis == "tol") return "tolerance";
  if (axis == "iters") return "iterations";
  return axis == "h" ? "step h, s" : axis;
}

// The fitted line through the middle of its points, and below it a triangle half a decade wide with the expected slope.
void draw_fit(Plot& plot, const OrderFit& fit, const PlotSeries& series) {
  double sum_x = 0, sum_y = 0;
  int used = 0;
  for (const PlotPoint& p : series.points) {
    const bool inside = p.x >= fit.lo * 0.999 && p.x <= fit.hi * 1.001;
    if (inside && p.y > 0 && p.kind != MarkKind::uncertain) sum_x += std::log10(p.x), sum_y += std::log10(p.y), ++used;
  }
  if (used < 2 || !std::isfinite(fit.slope)) return;
  const double cx = sum_x / used, cy = sum_y / used;
  const auto line_y = [&](double x) { return std::pow(10.0, cy + fit.slope * (std::log10(x) - cx)); };
  plot.lines.push_back({{fit.lo, line_y(fit.lo)}, {fit.hi, line_y(fit.hi)}, {kInk, 1.2, "3 2"}});
  plot.subtitle += (plot.subtitle.empty() ? "fitted " : ", ") + fmt::format("{:.2f}", fit.slope);
  if (!std::isfinite(fit.expected) || fit.expected <= 0 || !plot.slopes.empty()) return;
  const double x0 = std::pow(10.0, cx - 0.25);
  plot.slopes.push_back({{x0, line_y(x0) * std::pow(10.0, -1.2)}, fit.expected, number_text(fit.expected, 2)});
}

// One small plot per method, or refinement axis of its ladder: its points over the rung, with the order.
Plot order_panel(const StudyResult& r, const MethodInfo& m, const std::string& refined, const ErrorNorm& norm,
                 const std::vector<RefinementCurve>& curves) {
  std::string axis = refined.empty() ? (m.adaptive ? "tol" : "h") : refined == "steps" ? "h" : refined;
  for (const OrderFit& f : r.fits)
    if (f.method == m.name && f.refinement_axis == refined) axis = f.axis;
  Plot plot;
  plot.title = m.name;
  bool any = false;
  for (const RefinementCurve& curve : curves) {
    if (curve.method != m.name || curve.axis != refined) continue;
    PlotSeries series{curve.name, curve.number, {}};
    for (const StudyPoint* p : curve.points) {
      if (!measured(*p, norm)) continue;
      const MarkKind kind = p->below_floor ? MarkKind::uncertain : MarkKind::hollow;
      series.points.push_back({rung_value(*p, axis), p->*norm.value, 0, kind, point_title(r, *p, norm)});
      any = true;
    }
    if (const OrderFit* fit = fit_of(r, *curve.points.front())) draw_fit(plot, *fit, series);
    plot.series.push_back(series);
  }
  if (!plot.slopes.empty()) plot.subtitle += ", expected " + plot.slopes[0].label;
  if (plot.subtitle.empty()) plot.subtitle = any ? "no range that shows an order" : "no run reached the end";
  plot.x.label = rung_label(axis);
  return plot;
}

std::string order_svg(const StudyResult& r, const ErrorNorm& norm, bool inline_page) {
  const auto add_new = [](std::vector<std::string>& all, const std::string& one) {
    if (std::ranges::find(all, one) == all.end()) all.push_back(one);
  };
  const std::vector<RefinementCurve> curves = refinement_curves(r);
  std::vector<Plot> panels;
  for (const MethodInfo& m : r.methods) {
    std::vector<std::string> axes;
    for (const RefinementCurve& curve : curves)
      if (curve.method == m.name) add_new(axes, curve.axis);
    for (const std::string& axis : axes) panels.push_back(order_panel(r, m, axis, norm, curves));
  }
  // panels of one axis side by side
  std::vector<std::string> labels;
  for (const Plot& p : panels) add_new(labels, p.x.label);
  const auto rank = [&](const Plot& p) { return std::ranges::find(labels, p.x.label); };
  std::ranges::stable_sort(panels, [&](const Plot& a, const Plot& b) { return rank(a) < rank(b); });
  // one y axis for all, an x axis for those of a label
  std::vector<double> ys;
  for (const Plot& p : panels)
    for (const PlotSeries& s : p.series)
      for (const PlotPoint& q : s.points) ys.push_back(cut_error(q.y));
  const Axis y = fit_axis(norm.label, true, ys, TickStyle::power);
  for (Plot& p : panels) {
    std::vector<double> xs;
    for (const Plot& o : panels)
      if (o.x.label == p.x.label)
        for (const PlotSeries& s : o.series)
          for (const PlotPoint& q : s.points) xs.push_back(q.x);
    const bool counted = p.x.label != rung_label("h") && p.x.label != rung_label("tol");
    p.x = fit_axis(p.x.label, true, xs, counted ? TickStyle::plain : TickStyle::power);
    p.y = y;
  }
  return plot_sheet_svg("order", problem_label(r.problem) + ": order of each method",
                        "dashed: fit through the points that shrink regularly; the triangle shows the expected slope",
                        panels, 4, inline_page);
}

RowChart invariants(const StudyResult& r) {
  RowChart chart;
  chart.name = "invariants";
  chart.title = problem_label(r.problem) + ": what should be conserved";
  chart.x_label = "time, s";
  struct Kind {
    const char* label;
    std::vector<double> StudySeries::*values;
  };
  static const Kind kinds[] = {{"largest energy error so far / energy scale", &StudySeries::energy},
                               {"largest momentum error so far / its scale", &StudySeries::momentum},
                               {"largest angular momentum error so far / its scale", &StudySeries::angmom}};
  const std::vector<const StudySeries*> chosen = drawn_series(r);
  for (const Kind& kind : kinds) {
    RowChart::Row row{kind.label, true, {}};
    bool any = false;
    for (const StudySeries* s : chosen) {
      const StudyPoint& point = *point_of(r, *s);
      PlotSeries curve{fmt::format("{}, {}", point.method, rung_text(point)), number_of(r, point.method), {}};
      const std::vector<double>& values = s->*kind.values;
      double largest = 0;
      for (std::size_t k = 0; k < values.size() && k < s->t.size(); ++k) {
        // an envelope: curves that swing through zero would hide each other; a blow-up leaves through the top
        const double v = std::fabs(values[k]);
        if (std::isfinite(v)) largest = std::max(largest, v);
        any = any || largest > 0;
        curve.points.push_back({s->t[k], std::isfinite(v) && largest > 0 ? std::clamp(largest, 1e-17, 1e3) : NAN, 0,
                                MarkKind::hollow, ""});
      }
      row.series.push_back(curve);
    }
    if (any) chart.rows.push_back(row);
  }
  if (!chosen.empty()) chart.subtitle = "one run of each method, those of about the same work";
  return chart;
}

}  // namespace

const ErrorNorm& plotted_norm(const StudyResult& r, const StudyContext& context) {
  std::vector<std::string> names = context.errors;
  // what points are ranked by comes first
  if (names.empty()) names.emplace_back(r.problem.chaotic ? "horizon" : r.problem.own_measure ? "end" : "traj");
  for (const char* more : {"end", "traj", "orient", "event", "energy", "constraint"}) names.emplace_back(more);
  for (const std::string& name : names) {
    const ErrorNorm* norm = find_norm(name);
    if (norm && any_measured(r, *norm)) return *norm;
  }
  return *find_norm("end");
}

std::vector<const StudySeries*> drawn_series(const StudyResult& r) {
  std::vector<double> works;
  for (const StudyPoint& p : r.points)
    if (p.completed && p.work > 0) works.push_back(p.work);
  if (works.empty()) return {};
  std::ranges::sort(works);
  const double middle = works[works.size() / 2];
  std::vector<const StudySeries*> out;
  for (const MethodInfo& m : r.methods) {
    const StudySeries* best = nullptr;
    double distance = INFINITY;
    for (const StudySeries& s : r.series) {
      const StudyPoint* p = point_of(r, s);
      if (!p || p->method != m.name || !(p->work > 0)) continue;
      const double d = std::fabs(std::log(p->work / middle));
      if (d < distance) distance = d, best = &s;
    }
    if (best) out.push_back(best);
  }
  return out;
}

std::vector<Figure> study_figures(const StudyResult& r, const StudyContext& context) {
  std::vector<Figure> out;
  const ErrorNorm& norm = plotted_norm(r, context);
  const auto wants = [&](const char* axis) { return std::ranges::find(context.axes, axis) != context.axes.end(); };
  const auto add_plot = [&](const ErrorNorm& n, const CostAxis& axis, const std::string& file,
                            const std::string& caption) {
    const Plot plot = cost_plot(r, n, axis, file);
    out.push_back({file, caption, plot_svg(plot), plot_svg(plot, true)});
  };
  if (wants("time") && has_times(r))
    add_plot(norm, kRunTime, "error_vs_time.svg",
             "Error against run time. The whisker ends at the 90th percentile of the repeats.");
  if (wants("force"))
    add_plot(
        norm, kWork, "error_vs_work.svg",
        fmt::format(
            "Error against work, which does not depend on the machine: force evaluations, plus {} per Jacobian, {} per "
            "step of conjugate gradients, {} per direct solve.",
            number_text(r.weights.jacobian), number_text(r.weights.cg_iteration), number_text(r.weights.direct_solve)));
  for (std::size_t k = 1; k < context.errors.size(); ++k) {
    const ErrorNorm* more = find_norm(context.errors[k]);
    if (!more || more == &norm || !any_measured(r, *more)) continue;
    add_plot(*more, kWork, fmt::format("error_vs_work_{}.svg", more->name),
             fmt::format("{} against work.", more->label));
  }
  const bool several = std::ranges::any_of(r.points, [](const StudyPoint& p) { return !p.refinement_axis.empty(); });
  out.push_back({"order.svg",
                 several ? "Error against what is refined, one frame for each method and way to refine."
                         : "Error against the step, one frame per method.",
                 order_svg(r, norm, false), order_svg(r, norm, true)});
  const RowChart rows = invariants(r);
  if (!rows.rows.empty())
    out.push_back({"invariants.svg", "Energy, momentum and angular momentum along one run of each method.",
                   row_chart_svg(rows), row_chart_svg(rows, true)});
  return out;
}

}  // namespace feder::report
