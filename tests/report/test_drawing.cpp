// The drawing library: numbers, escaping, ticks, and that each point that goes in comes out as a mark.
#include <cmath>

#include "report/figures.h"
#include "report/heat_map.h"
#include "report/plot.h"
#include "report/xml.h"
#include "report/xml_check.h"
#include "support/catch.h"

using namespace feder::report;
using feder::test::count_of;
using feder::test::xml_fault;

namespace {

std::vector<std::string> labels(const Axis& axis, int most) {
  std::vector<std::string> out;
  for (const Tick& t : axis.ticks(most))
    if (!t.label.empty()) out.push_back(t.label);
  return out;
}

using Strings = std::vector<std::string>;

}  // namespace

TEST_CASE("numbers of drawings have one format", "[report]") {
  CHECK(px(1.0 / 3) == "0.33");
  CHECK(px(2) == "2");
  CHECK(px(-0.001) == "0");
  CHECK(px(100) == "100");
  CHECK(px(NAN) == "0");
  CHECK(number_text(1.2345e-5, 3) == "1.23e-5");
  CHECK(number_text(1e10, 3) == "1e10");
  CHECK(number_text(0.25) == "0.25");
  CHECK(number_text(-INFINITY) == "-inf");
}

TEST_CASE("text is escaped", "[report]") {
  CHECK(xml_escape("a<b>&\"c'\n") == "a&lt;b&gt;&amp;&quot;c&#39;&#10;");
  CHECK(xml_escape("\x01\xff").find('\x01') == std::string::npos);
  CHECK(xml_escape("é") == "é");
}

TEST_CASE("logarithmic axes have ticks on the decades", "[report]") {
  const Axis a = fit_axis("x", true, {3e-4, 0.7, NAN, 0, -1});
  CHECK(a.lo == 1e-4);
  CHECK(a.hi == 1);
  Axis power = a;
  power.style = TickStyle::power;
  CHECK(labels(power, 10) == Strings{"10^{-4}", "10^{-3}", "10^{-2}", "10^{-1}", "10^{0}"});
  CHECK(labels(power, 3) == Strings{"10^{-4}", "10^{-2}", "10^{0}"});
  CHECK(a.at(1e-4) == 0);
  CHECK(a.at(1) == 1);
  CHECK(a.at(1e-2) == Approx(0.5));
  // minor ticks at 2 to 9 of each decade
  int minor = 0;
  for (const Tick& t : power.ticks(10)) minor += t.label.empty();
  CHECK(minor == 4 * 8);
  const Axis narrow = fit_axis("x", true, {0.02, 0.05});
  CHECK(narrow.hi >= 10 * narrow.lo);
  const Axis none = fit_axis("x", true, {});
  CHECK(none.hi > none.lo);
  Axis clock{"t", true, 1e-6, 1e-2, TickStyle::seconds, {}};
  CHECK(labels(clock, 10) == Strings{"1 µs", "10 µs", "100 µs", "1 ms", "10 ms"});
}

TEST_CASE("linear axes have ticks on round numbers", "[report]") {
  CHECK(labels(Axis{"x", false, 0, 10, TickStyle::plain, {}}, 6) == Strings{"0", "2", "4", "6", "8", "10"});
  CHECK(labels(Axis{"x", false, -0.3, 0.3, TickStyle::plain, {}}, 4) == Strings{"-0.2", "0", "0.2"});
  const Axis a = fit_axis("x", false, {0.13, 0.88});
  CHECK(a.lo <= 0.13);
  CHECK(a.hi >= 0.88);
  const Axis equal = fit_axis("x", false, {2, 2});
  CHECK(equal.lo < 2);
  CHECK(equal.hi > 2);
  for (const double top : {1.0, 3.7, 12.0, 99.0, 1234.5}) {
    const auto n = labels(Axis{"x", false, 0, top, TickStyle::plain, {}}, 8).size();
    CHECK(n >= 2);
    CHECK(n <= 8);
  }
}

TEST_CASE("every point becomes one mark, also those that failed or lie outside", "[report]") {
  Plot p;
  p.name = "probe";
  p.title = "points <&> marks";
  const MarkKind kinds[] = {MarkKind::hollow, MarkKind::filled,  MarkKind::uncertain, MarkKind::diverged,
                            MarkKind::nan,    MarkKind::refused, MarkKind::other};
  int in = 0, failed = 0;
  for (int m = 0; m < 20; ++m) {
    PlotSeries s{"m" + std::to_string(m), m, {}};
    for (int k = 0; k < 9; ++k) {
      const MarkKind kind = kinds[(m + k) % 7];
      // costs of 0 and NaN, errors of 0, infinity and far outside belong to it
      const double y = k == 7 ? 0 : k == 8 ? INFINITY : std::pow(10.0, -k);
      s.points.push_back({k == 6 ? NAN : k == 5 ? 0 : std::pow(10.0, k), y, 0, kind, "row " + std::to_string(in)});
      ++in;
      failed += is_failure(kind);
    }
    p.series.push_back(s);
  }
  p.x = fit_axis("x", true, {1, 1e8});
  p.y = fit_axis("y", true, {1e-3, 1});
  const std::string svg = plot_svg(p);
  CHECK(count_of(svg, "class=\"point") == in);
  CHECK(count_of(svg, "class=\"point failed\"") == failed);
  CHECK(count_of(svg, "<title>row ") == in);
  CHECK(xml_fault(svg) == "");
  CHECK(svg.find("nan") == std::string::npos);
  CHECK(svg == plot_svg(p));
}

TEST_CASE("curves differ in more than their colour", "[report]") {
  for (int a = 0; a < 32; ++a)
    for (int b = 0; b < a; ++b) {
      const CurveStyle s = curve_style(a), t = curve_style(b);
      const int differences = (s.color != t.color) + (s.dash != t.dash) + (s.marker != t.marker);
      CAPTURE(a, b);
      CHECK(differences >= 2);
    }
}

TEST_CASE("a heat map has a cell for each value, and lines over them", "[report]") {
  HeatMap m;
  m.name = "map";
  m.title = "h & k";
  m.x = {"h, s", true, 0, 1, TickStyle::power};
  m.y = {"k, N/m", true, 0, 1, TickStyle::power};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k)
      m.cells.push_back({std::pow(10.0, -i), std::pow(10.0, k), i + k < 3 ? "stable" : "diverged", 1e-3, "cell <1>"});
  m.theory = {{1, 1}, {0.01, 1e3}};
  m.theory_label = "theory";
  const std::string svg = heat_map_svg(m);
  CHECK(count_of(svg, "class=\"cell\"") == 12);
  CHECK(count_of(svg, "<title>cell &lt;1&gt;</title>") == 12);
  CHECK(xml_fault(svg) == "");
  const std::string sheet = heat_sheet_svg("sheet", "all", {m, m, m}, 2);
  CHECK(count_of(sheet, "class=\"cell\"") == 36);
  CHECK(xml_fault(sheet) == "");
  // each failure has a look of its own, without colour too
  CHECK(verdict_style("diverged").hatch != verdict_style("growing").hatch);
  CHECK(std::string(verdict_style("no such").name) == "other");
  CHECK(std::string(error_shade(1e-7)) != error_shade(1e-3));
}

TEST_CASE("rows of curves are well formed", "[report]") {
  RowChart chart;
  chart.name = "rows";
  chart.title = "a & b";
  chart.x_label = "t, s";
  PlotSeries s{"m<", 0, {}};
  for (int k = 0; k < 100; ++k) s.points.push_back({k * 0.1, k == 50 ? NAN : k * 1e-3, 0, MarkKind::hollow, ""});
  chart.rows = {{"energy", true, {s}}, {"momentum", false, {s}}};
  const std::string rows = row_chart_svg(chart);
  CHECK(xml_fault(rows) == "");
  CHECK(count_of(rows, "<polyline") == 4);  // each curve is interrupted once
}
