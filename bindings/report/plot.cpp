#include "report/plot.h"

#include <algorithm>
#include <cmath>

namespace feder::report {
namespace {

// px of the whole drawing; it grows when the legend or the gutter needs it
constexpr double kWidth = 1100, kHeight = 620;
constexpr double kRow = 16;      // px of a line in the gutter and the legend
constexpr double kTicks = 11.5;  // size of the tick labels

struct Layout {
  Box frame, gutter, legend;
  double height = 0;
};

bool has(const Plot& p, MarkKind kind) {
  return std::ranges::any_of(
      p.series, [&](const PlotSeries& s) { return std::ranges::count(s.points, kind, &PlotPoint::kind) > 0; });
}

bool has_failure(const PlotSeries& s) {
  return std::ranges::any_of(s.points, [](const PlotPoint& q) { return is_failure(q.kind); });
}

struct Explained {
  MarkKind kind;
  const char* words;
};
constexpr Explained kExplained[] = {
    {MarkKind::filled, "on the Pareto front"},
    {MarkKind::hollow, "not on the front"},
    {MarkKind::uncertain, "below the reference"},
    {MarkKind::diverged, "diverged"},
    {MarkKind::nan, "not a number"},
    {MarkKind::refused, "refused"},
    {MarkKind::other, "no measurement"},
};

Layout lay_out(const Plot& p) {
  Layout l;
  double names = 0, left_names = 0;
  int failing = 0;
  for (const PlotSeries& s : p.series) {
    names = std::max(names, words_width(s.name, 12));
    if (!has_failure(s)) continue;
    ++failing;
    left_names = std::max(left_names, words_width(s.name, 11));
  }
  const auto kinds =
      static_cast<std::size_t>(std::ranges::count_if(kExplained, [&](const Explained& e) { return has(p, e.kind); }));
  const double left = std::clamp(left_names + 16, 74.0, 190.0);
  const double legend = std::clamp(names + 52, 185.0, 260.0);
  const double top = p.subtitle.empty() ? 44 : 62;
  const double gutter = failing ? failing * kRow + 26 : 0;
  const double legend_height = static_cast<double>(p.series.size() + kinds + 3) * kRow + 30;
  l.height = std::max(kHeight + gutter, top + legend_height + 56);
  l.gutter = {left, top, kWidth - left - legend - 24, gutter};
  l.frame = {left, top + gutter, l.gutter.width, l.height - top - gutter - 56};
  l.legend = {l.frame.right() + 18, top, legend, l.height - top - 56};
  return l;
}

XY position(const Box& f, const Plot& p, double x, double y) {
  return {f.left + f.width * std::clamp(p.x.at(x), 0.0, 1.0), f.bottom() - f.height * p.y.at(y)};
}

// The gutter: one line per method that has failed points, each at its cost.
void draw_gutter(Svg& svg, const Layout& l, const Plot& p) {
  if (l.gutter.height <= 0) return;
  const Box box{l.gutter.left, l.gutter.top + 16, l.gutter.width, l.gutter.height - 22};
  svg.text({box.left, box.top - 5},
           "no error to plot: each mark is a run that failed, at what it cost until then (at the left end also less)",
           {11, "start", kQuiet});
  svg.rect(box, "#f6f8fa", kGrid);
  double y = box.top + kRow / 2;
  for (const PlotSeries& s : p.series) {
    if (!has_failure(s)) continue;
    const CurveStyle style = curve_style(s.number);
    svg.text({box.left - 8, y + 4}, words_cut(s.name, 11, box.left - 12), {11, "end", style.color});
    double edge = box.left + 8;  // those cheaper than the axis stand side by side at its left end
    for (const PlotPoint& q : s.points) {
      if (!is_failure(q.kind)) continue;
      double x = position(l.frame, p, q.x, 1).x;
      if (x <= l.frame.left) x = edge, edge += 12;
      draw_mark(svg, {x, y}, q.kind, style, 9, q.title);
    }
    y += kRow;
  }
}

void draw_legend(Svg& svg, const Box& box, const Plot& p) {
  double y = box.top + 10;
  for (const PlotSeries& s : p.series) {
    draw_sample(svg, {box.left, y - 4}, 34, curve_style(s.number));
    svg.text({box.left + 42, y}, words_cut(s.name, 12, box.width - 42), {12});
    y += kRow;
  }
  y += 10;
  CurveStyle neutral{kQuiet, "", 0};
  for (const Explained& e : kExplained) {
    if (!has(p, e.kind)) continue;
    draw_mark(svg, {box.left + 17, y - 4}, e.kind, neutral, 8.5, "");
    svg.text({box.left + 42, y}, e.words, {11.5, "start", kQuiet});
    y += kRow;
  }
  if (std::ranges::any_of(p.fronts, [](const auto& front) { return front.size() > 1; })) {
    svg.line({box.left, y - 4}, {box.left + 34, y - 4}, {"#b6c2cf", 7, "", 0.5});
    svg.text({box.left + 42, y}, "Pareto front", {11.5, "start", kQuiet});
    y += kRow;
  }
  if (p.uncertain_below > 0) {
    svg.rect({box.left, y - 11, 34, 12}, svg.hatch(Hatch::rising, "#c3c9d0"), "#c3c9d0");
    svg.text({box.left + 42, y}, words_cut(p.uncertain_label, 11.5, box.width - 42), {11.5, "start", kQuiet});
  }
}

void draw_fronts(Svg& svg, const Box& f, const Plot& p) {
  for (const std::vector<XY>& front : p.fronts) {
    if (front.size() < 2) continue;
    std::vector<XY> stair;
    for (const XY& q : front) {
      const XY at = position(f, p, q.x, q.y);
      if (!stair.empty()) stair.push_back({at.x, stair.back().y});
      stair.push_back(at);
    }
    svg.polyline(stair, {"#b6c2cf", 9, "", 0.5});
  }
}

void draw_slopes(Svg& svg, const Box& f, const Plot& p) {
  for (const SlopeMark& s : p.slopes) {
    const double wide = std::pow(10.0, 0.5);
    const XY a = position(f, p, s.at.x, s.at.y);
    const XY b = position(f, p, s.at.x * wide, s.at.y);
    const XY c = position(f, p, s.at.x * wide, s.at.y * std::pow(wide, s.slope));
    const XY corners[] = {a, b, c};
    svg.polygon(corners, "none", {kQuiet, 1});
    svg.text({b.x + 4, (b.y + c.y) / 2 + 4}, s.label, {10.5, "start", kQuiet});
  }
}

}  // namespace

void draw_titles(Svg& svg, double left, double width, const std::string& title, const std::string& subtitle) {
  svg.text({left, 26}, words_cut(title, 16, width - left - 10), {16, "start", kInk, true});
  if (!subtitle.empty()) svg.text({left, 46}, words_cut(subtitle, 12, width - left - 10), {12, "start", kQuiet});
}

XY position(const Box& f, const Axis& x, const Axis& y, XY p) {
  return {f.left + f.width * x.at(p.x), f.bottom() - f.height * y.at(p.y)};
}

void draw_axes(Svg& svg, const Box& f, const Axis& x, const Axis& y, double size, bool x_words, bool y_words) {
  const std::vector<Tick> xs = x.ticks(std::max(2, static_cast<int>(f.width / 62)));
  const std::vector<Tick> ys = y.ticks(std::max(2, static_cast<int>(f.height / 26)));
  const auto x_at = [&](const Tick& t) { return f.left + f.width * x.at(t.value); };
  const auto y_at = [&](const Tick& t) { return f.bottom() - f.height * y.at(t.value); };
  // faint lines first, so that the labelled ones lie on top
  for (const bool labelled : {false, true}) {
    const Stroke pen{labelled ? kGrid : kFaintGrid, 1};
    for (const Tick& t : xs)
      if (t.label.empty() != labelled) svg.line({x_at(t), f.top}, {x_at(t), f.bottom()}, pen);
    for (const Tick& t : ys)
      if (t.label.empty() != labelled) svg.line({f.left, y_at(t)}, {f.right(), y_at(t)}, pen);
  }
  svg.rect(f, "none", kFrame);
  for (const Tick& t : xs)
    if (x_words && !t.label.empty()) svg.text({x_at(t), f.bottom() + size + 5}, t.label, {size, "middle"});
  for (const Tick& t : ys)
    if (y_words && !t.label.empty()) svg.text({f.left - 7, y_at(t) + size * 0.35}, t.label, {size, "end"});
}

void draw_curves(Svg& svg, const Box& f, const Plot& p, double mark_size) {
  if (p.uncertain_below > 0) {
    const double y = std::clamp(f.bottom() - f.height * p.y.at(p.uncertain_below), f.top, f.bottom());
    svg.rect({f.left, y, f.width, f.bottom() - y}, svg.hatch(Hatch::rising, "#d5dae0"));
    svg.line({f.left, y}, {f.right(), y}, {"#aab2bb", 1, "4 3"});
  }
  svg.begin_clip(f);
  draw_fronts(svg, f, p);
  for (const PlotLine& l : p.lines) {
    const XY ends[] = {position(f, p, l.from.x, l.from.y), position(f, p, l.to.x, l.to.y)};
    svg.polyline(ends, l.stroke);
  }
  for (const PlotSeries& s : p.series) {
    const CurveStyle style = curve_style(s.number);
    std::vector<XY> run;
    const auto flush = [&] {
      svg.polyline(run, {style.color, 1.6, style.dash}, s.name);
      run.clear();
    };
    for (const PlotPoint& q : s.points) {
      if (is_failure(q.kind)) {
        flush();
        continue;
      }
      run.push_back(position(f, p, q.x, q.y));
      if (q.x_far > q.x) svg.line(run.back(), position(f, p, q.x_far, q.y), {style.color, 1, "", 0.3});
    }
    flush();
  }
  svg.end();
  for (const PlotSeries& s : p.series)
    for (const PlotPoint& q : s.points) {
      if (is_failure(q.kind)) continue;
      XY at = position(f, p, q.x, q.y);
      at.y = std::clamp(at.y, f.top, f.bottom());
      draw_mark(svg, at, q.kind, curve_style(s.number), mark_size, q.title);
    }
  draw_slopes(svg, f, p);
}

std::string plot_svg(const Plot& p, bool inline_page) {
  const Layout l = lay_out(p);
  Svg svg(p.name, kWidth, l.height, p.title);
  draw_titles(svg, l.frame.left, kWidth, p.title, p.subtitle);
  draw_gutter(svg, l, p);
  draw_axes(svg, l.frame, p.x, p.y, kTicks);
  draw_curves(svg, l.frame, p, 8);
  svg.text({l.frame.left + l.frame.width / 2, l.frame.bottom() + 42}, p.x.label, {13, "middle"});
  svg.text({20, l.frame.top + l.frame.height / 2}, p.y.label, {13, "middle", kInk, false, -90});
  draw_legend(svg, l.legend, p);
  return svg.text(inline_page);
}

}  // namespace feder::report
