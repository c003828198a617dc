#include "report/heat_map.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

#include "report/plot.h"
#include "report/xml.h"

namespace feder::report {
namespace {

constexpr double kRowHeight = 18;

// Worst first: the order of the legend.
constexpr VerdictStyle kVerdicts[] = {
    {"nan", "#1f2328", 2, "not a number"},
    {"diverged", "#c0392b", 0, "left every bound"},
    {"growing", "#e67e22", 1, "energy grows"},
    {"stuck", "#8e6bbf", 4, "does not move"},
    {"damped", "#d4b106", 3, "energy lost by the method"},
    {"inaccurate", "#e3a6c6", 5, "bounded, but wrong"},
    {"slow", "#8b949e", 1, "solver missed its tolerance"},
    {"refused", "#eceff2", 2, "input rejected"},
};
constexpr VerdictStyle kStable{"stable", "#2b8cbe", -1, "stable, shade by error"};
constexpr VerdictStyle kOther{"other", "#ffffff", 0, "other"};

struct Shade {
  double below;
  const char* color;
  const char* words;
};
// Light to dark blue-green, distinguishable in grey too.
constexpr Shade kShades[] = {{1e-6, "#08589e", "below 1e-6"},
                             {1e-4, "#2b8cbe", "below 1e-4"},
                             {1e-2, "#7bccc4", "below 1e-2"},
                             {1e-1, "#ccebc5", "below 1e-1"},
                             {1e300, "#f0f9e8", "above 1e-1"}};

constexpr const char* kNoError = "#ffffff";  // stable, with nothing to compare to

std::vector<double> sorted_values(const std::vector<HeatCell>& cells, double HeatCell::*member) {
  std::set<double> values;
  for (const HeatCell& c : cells) values.insert(c.*member);
  return {values.begin(), values.end()};
}

// Where a cell begins and ends: half way to its neighbours (in the measure of the axis).
std::vector<double> edges(const std::vector<double>& values, bool log) {
  std::vector<double> t;
  for (const double v : values) t.push_back(log ? std::log10(v) : v);
  std::vector<double> out;
  const std::size_t n = t.size();
  for (std::size_t k = 0; k <= n; ++k) {
    double e = 0;
    if (n == 1)
      e = t[0] + (k ? 0.5 : -0.5);
    else if (k == 0)
      e = t[0] - (t[1] - t[0]) / 2;
    else if (k == n)
      e = t[n - 1] + (t[n - 1] - t[n - 2]) / 2;
    else
      e = (t[k - 1] + t[k]) / 2;
    out.push_back(log ? std::pow(10.0, e) : e);
  }
  return out;
}

// On a linear axis few values stand for many (0, 0.1, 0.5, 5): their cells get equal sizes, and each its label. Lines
// over them run from value to value.
void make_ordinal(Axis& axis, std::vector<HeatCell>& cells, double HeatCell::*member, std::vector<XY>* lines[2],
                  double XY::*on) {
  const std::vector<double> values = sorted_values(cells, member);
  const auto index_of = [&](double v) {
    const auto above = std::ranges::lower_bound(values, v);
    const auto k = static_cast<double>(above - values.begin());
    if (above == values.end()) return k - 1;
    if (*above == v || above == values.begin()) return k;
    return k - 1 + (v - above[-1]) / (*above - above[-1]);
  };
  for (std::size_t k = 0; k < values.size(); ++k)
    axis.fixed.push_back({static_cast<double>(k), number_text(values[k], 4)});
  for (HeatCell& c : cells) c.*member = index_of(c.*member);
  for (int k = 0; k < 2; ++k)
    for (XY& p : *lines[k]) p.*on = index_of(p.*on);
}

HeatMap with_ends(HeatMap m) {
  std::vector<XY>* lines[2] = {&m.theory, &m.boundary};
  if (!m.x.log) make_ordinal(m.x, m.cells, &HeatCell::x, lines, &XY::x);
  if (!m.y.log) make_ordinal(m.y, m.cells, &HeatCell::y, lines, &XY::y);
  const std::vector<double> x = edges(sorted_values(m.cells, &HeatCell::x), m.x.log);
  const std::vector<double> y = edges(sorted_values(m.cells, &HeatCell::y), m.y.log);
  if (x.size() > 1) m.x.lo = x.front(), m.x.hi = x.back();
  if (y.size() > 1) m.y.lo = y.front(), m.y.hi = y.back();
  return m;
}

std::string fill_of(Svg& svg, const HeatCell& c) {
  if (c.verdict == "stable") return error_shade(c.error);
  const VerdictStyle& style = verdict_style(c.verdict);
  const bool dark = std::string(style.color) == "#1f2328";
  return style.hatch < 0 ? style.color
                         : svg.hatch(static_cast<Hatch>(style.hatch), dark ? "#8b949e" : "#00000066", style.color);
}

void draw_cells(Svg& svg, const Box& f, const HeatMap& m) {
  const std::vector<double> xs = sorted_values(m.cells, &HeatCell::x), ys = sorted_values(m.cells, &HeatCell::y);
  const std::vector<double> xe = edges(xs, m.x.log), ye = edges(ys, m.y.log);
  for (const HeatCell& c : m.cells) {
    const auto i = static_cast<std::size_t>(std::ranges::lower_bound(xs, c.x) - xs.begin());
    const auto k = static_cast<std::size_t>(std::ranges::lower_bound(ys, c.y) - ys.begin());
    const XY low = position(f, m.x, m.y, {xe[i], ye[k]}), high = position(f, m.x, m.y, {xe[i + 1], ye[k + 1]});
    svg.rect({low.x, high.y, high.x - low.x, low.y - high.y}, fill_of(svg, c), "#ffffff", c.title, "cell");
  }
}

void draw_curve(Svg& svg, const Box& f, const HeatMap& m, const std::vector<XY>& curve, const Stroke& stroke) {
  std::vector<XY> points;
  for (const XY& p : curve) points.push_back(position(f, m.x, m.y, p));
  if (stroke.dash.empty()) svg.polyline(points, {"#ffffff", stroke.width + 2.5, "", 0.8});
  svg.polyline(points, stroke);
}

const Stroke kTheory{"#1f2328", 1.6, "5 5"};
const Stroke kBoundary{"#ff5ad6", 4};

void draw_map(Svg& svg, const Box& f, const HeatMap& m, double label_size, bool x_words, bool y_words) {
  draw_axes(svg, f, m.x, m.y, label_size, x_words, y_words);
  draw_cells(svg, f, m);
  svg.begin_clip(f);
  // theory over what was found: where they agree, both show
  draw_curve(svg, f, m, m.boundary, kBoundary);
  draw_curve(svg, f, m, m.theory, kTheory);
  svg.end();
  svg.rect(f, "none", kFrame);
}

void draw_legend(Svg& svg, XY at, double width, std::span<const HeatMap> maps) {
  std::set<std::string> seen;
  std::string theory, boundary;
  bool unknown = false;
  for (const HeatMap& m : maps) {
    for (const HeatCell& c : m.cells)
      seen.insert(c.verdict), unknown = unknown || (c.verdict == "stable" && std::isnan(c.error));
    if (m.theory.size() > 1) theory = m.theory_label;
    if (m.boundary.size() > 1) boundary = m.boundary_label;
  }
  double y = at.y;
  const auto entry = [&](const std::string& fill, const std::string& words, const std::string& more) {
    svg.rect({at.x, y - 11, 26, 14}, fill, "#aab2bb");
    svg.text({at.x + 34, y}, words, {12});
    if (!more.empty()) svg.text({at.x + 34, y + 14}, words_cut(more, 10.5, width - 34), {10.5, "start", kQuiet});
    y += more.empty() ? kRowHeight : kRowHeight + 14;
  };
  const auto failure = [&](const VerdictStyle& v) { entry(fill_of(svg, {0, 0, v.name, 0, ""}), v.name, v.meaning); };
  for (const VerdictStyle& v : kVerdicts)
    if (seen.erase(v.name)) failure(v);
  if (seen.erase("stable")) {
    svg.text({at.x, y + 2}, "stable, by end error", {12});
    y += kRowHeight;
    for (const Shade& s : kShades) entry(s.color, s.words, "");
    if (unknown) entry(kNoError, "not judged", "");
  }
  for (const std::string& name : seen) entry(fill_of(svg, {0, 0, name, 0, ""}), name, "");
  const auto line = [&](const std::string& words, const Stroke& stroke) {
    if (words.empty()) return;
    y += 4;
    svg.line({at.x, y - 4}, {at.x + 26, y - 4}, stroke);
    svg.text({at.x + 34, y}, words_cut(words, 12, width - 34), {12});
    y += kRowHeight;
  };
  line(theory, kTheory);
  line(boundary, kBoundary);
}

}  // namespace

const VerdictStyle& verdict_style(const std::string& verdict) {
  for (const VerdictStyle& v : kVerdicts)
    if (verdict == v.name) return v;
  return verdict == "stable" ? kStable : kOther;
}

const char* error_shade(double error) {
  if (std::isnan(error)) return kNoError;
  for (const Shade& s : kShades)
    if (error < s.below) return s.color;
  return kShades[4].color;
}

std::string heat_map_svg(const HeatMap& given, bool inline_page) {
  const HeatMap m = with_ends(given);
  const double width = 900, height = 560, legend = 200;
  Svg svg(m.name, width, height, m.title);
  const Box f{80, m.subtitle.empty() ? 44.0 : 64.0, width - 80 - legend - 40, height - 64 - 60};
  svg.text({f.left, 26}, words_cut(m.title, 16, width - f.left - 10), {16, "start", kInk, true});
  svg.text({f.left, 47}, words_cut(m.subtitle, 12, width - f.left - 10), {12, "start", kQuiet});
  draw_map(svg, f, m, 11.5, true, true);
  svg.text({f.left + f.width / 2, f.bottom() + 42}, m.x.label, {13, "middle"});
  svg.text({22, f.top + f.height / 2}, m.y.label, {13, "middle", kInk, false, -90});
  draw_legend(svg, {f.right() + 22, f.top + 10}, legend, {&m, 1});
  return svg.text(inline_page);
}

std::string heat_sheet_svg(const std::string& name, const std::string& title, const std::vector<HeatMap>& maps,
                           int columns, bool inline_page) {
  const double width = 1200, legend = 190, left = 66, top = 56;
  const int count = static_cast<int>(maps.size());
  columns = std::clamp(count, 2, columns);
  const int rows = (count + columns - 1) / columns;
  const double cell_w = (width - left - legend - 30) / columns, cell_h = std::max(150.0, cell_w * 0.78);
  const double height = std::max(top + rows * cell_h + 60, 460.0);
  Svg svg(name, width, height, title);
  svg.text({left, 28}, words_cut(title, 16, width - left - 10), {16, "start", kInk, true});
  std::vector<HeatMap> fitted;
  for (const HeatMap& m : maps) fitted.push_back(with_ends(m));
  for (int k = 0; k < count; ++k) {
    const HeatMap& m = fitted[static_cast<std::size_t>(k)];
    const int row = k / columns, column = k % columns;
    const Box f{left + column * cell_w, top + row * cell_h + 18, cell_w - 14, cell_h - 44};
    svg.text({f.left, f.top - 5}, words_cut(m.title, 12, f.width), {12, "start", kInk, true});
    draw_map(svg, f, m, 10, k + columns >= count, column == 0);
  }
  if (count) {
    svg.text({left + columns * cell_w / 2, top + rows * cell_h + 44}, fitted[0].x.label, {13, "middle"});
    svg.text({18, top + rows * cell_h / 2}, fitted[0].y.label, {13, "middle", kInk, false, -90});
  }
  draw_legend(svg, {width - legend, top + 28}, legend - 10, fitted);
  return svg.text(inline_page);
}

}  // namespace feder::report
