#include "report/figures.h"

#include <algorithm>
#include <cmath>

namespace feder::report {
namespace {

// Method names of all rows, once each.
std::vector<const PlotSeries*> distinct(const RowChart& chart) {
  std::vector<const PlotSeries*> out;
  for (const auto& row : chart.rows)
    for (const PlotSeries& s : row.series)
      if (std::ranges::find(out, s.name, &PlotSeries::name) == out.end()) out.push_back(&s);
  return out;
}

void draw_row(Svg& svg, const Box& f, const RowChart::Row& row, const Axis& x, bool last) {
  std::vector<double> ys;
  for (const PlotSeries& s : row.series)
    for (const PlotPoint& p : s.points) ys.push_back(p.y);
  const Axis y = fit_axis(row.label, row.log, ys, row.log ? TickStyle::power : TickStyle::plain);
  draw_axes(svg, f, x, y, 11, last, true);
  svg.text({f.left, f.top - 7}, row.label, {12.5, "start", kInk});
  svg.begin_clip({f.left, f.top - 1, f.width, f.height + 2});
  for (const PlotSeries& s : row.series) {
    const CurveStyle style = curve_style(s.number);
    const auto drawn = [&](const PlotPoint& p) { return std::isfinite(p.y) && !(row.log && p.y <= 0); };
    std::vector<XY> run;
    const auto flush = [&] {
      svg.polyline(run, {style.color, 1.5, style.dash}, s.name);
      run.clear();
    };
    for (const PlotPoint& p : s.points)
      if (drawn(p))
        run.push_back(position(f, x, y, {p.x, p.y}));
      else
        flush();
    flush();
    // a few markers, at other times for each curve
    for (std::size_t k = static_cast<std::size_t>(7 * s.number) % 40; k < s.points.size(); k += 48)
      if (const PlotPoint& p = s.points[k]; drawn(p))
        draw_mark(svg, position(f, x, y, {p.x, p.y}), MarkKind::filled, style, 6, "");
  }
  svg.end();
}

void draw_x_words(Svg& svg, const Box& f, const Axis& x) {
  for (const Tick& t : x.ticks(std::max(2, static_cast<int>(f.width / 50))))
    if (!t.label.empty()) svg.text({f.left + f.width * x.at(t.value), f.bottom() + 14}, t.label, {10, "middle"});
}

}  // namespace

std::string row_chart_svg(const RowChart& chart, bool inline_page) {
  const double width = 1100, left = 90, legend = 250, row_height = 190, top = chart.subtitle.empty() ? 60 : 80;
  const std::vector<const PlotSeries*> names = distinct(chart);
  const double height = std::max(top + static_cast<double>(chart.rows.size()) * row_height + 40,
                                 top + 20 + 16.0 * static_cast<double>(names.size()));
  Svg svg(chart.name, width, height, chart.title);
  draw_titles(svg, left, width, chart.title, chart.subtitle);
  std::vector<double> xs;
  for (const auto& row : chart.rows)
    for (const PlotSeries& s : row.series)
      for (const PlotPoint& p : s.points) xs.push_back(p.x);
  Axis x = fit_axis(chart.x_label, false, xs);
  for (std::size_t k = 0; k < chart.rows.size(); ++k) {
    const Box f{left, top + static_cast<double>(k) * row_height, width - left - legend - 20, row_height - 34};
    draw_row(svg, f, chart.rows[k], x, k + 1 == chart.rows.size());
    if (k + 1 == chart.rows.size()) svg.text({f.left + f.width / 2, f.bottom() + 36}, chart.x_label, {13, "middle"});
  }
  double y = top + 8;
  for (const PlotSeries* s : names) {
    const CurveStyle style = curve_style(s->number);
    draw_sample(svg, {width - legend, y - 4}, 30, style);
    svg.text({width - legend + 36, y}, words_cut(s->name, 11.5, legend - 40), {11.5});
    y += 16;
  }
  return svg.text(inline_page);
}

std::string plot_sheet_svg(const std::string& name, const std::string& title, const std::string& subtitle,
                           const std::vector<Plot>& plots, int columns, bool inline_page) {
  const double width = 1100, left = 70, top = subtitle.empty() ? 50 : 66;
  const int count = static_cast<int>(plots.size()), rows = (count + columns - 1) / columns;
  const double cell_w = (width - left - 10) / columns, cell_h = 215;
  const double height = top + rows * cell_h + 22;
  Svg svg(name, width, height, title);
  draw_titles(svg, left, width, title, subtitle);
  const bool mixed = std::ranges::any_of(plots, [&](const Plot& p) { return p.x.label != plots[0].x.label; });
  for (int k = 0; k < count; ++k) {
    const Plot& p = plots[static_cast<std::size_t>(k)];
    const int row = k / columns, column = k % columns;
    const Box f{left + column * cell_w, top + row * cell_h + 20, cell_w - 16, cell_h - 46};
    svg.text({f.left, f.top - 6}, words_cut(p.title, 12, f.width),
             {12, "start", curve_style(p.series.empty() ? 6 : p.series[0].number).color, true});
    draw_axes(svg, f, p.x, p.y, 10, !mixed && k + columns >= count, column == 0);
    draw_curves(svg, f, p, 6.5);
    if (!p.subtitle.empty()) svg.text({f.right(), f.top - 6}, p.subtitle, {10.5, "end", kQuiet});
    // panels with axes of their own say so
    if (!mixed) continue;
    draw_x_words(svg, f, p.x);
    svg.text({f.right() - 5, f.bottom() - 6}, p.x.label, {10.5, "end", kQuiet, false, 0, true});
  }
  if (count) {
    if (!mixed) svg.text({left + std::min(columns, count) * cell_w / 2, height - 10}, plots[0].x.label, {13, "middle"});
    svg.text({18, top + rows * cell_h / 2}, plots[0].y.label, {13, "middle", kInk, false, -90});
  }
  return svg.text(inline_page);
}

}  // namespace feder::report
