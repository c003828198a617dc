// A drawing of curves over two axes: one polyline per method, a gutter above for the points without a value on the
// y axis, a band below what the reference resolves, and the Pareto front as a pale stair. Every point that is put in
// comes out as one mark with its own title.
#pragma once
#include <string>
#include <vector>

#include "report/axis.h"
#include "report/marks.h"
#include "report/svg.h"

namespace feder::report {

struct PlotPoint {
  double x = 0, y = 0;
  double x_far = 0;  // end of the whisker; 0: none
  MarkKind kind = MarkKind::hollow;
  std::string title;  // what the pointer shows
};

struct PlotSeries {
  std::string name;
  int number = 0;  // of its curve style
  std::vector<PlotPoint> points;
};

// A straight piece in the units of the axes.
struct PlotLine {
  XY from, to;
  Stroke stroke;
};

// A triangle that shows a slope on logarithmic axes, from `at` one half decade to the right.
struct SlopeMark {
  XY at;
  double slope = 1;
  std::string label;
};

struct Plot {
  std::string name;  // of the file, for ids
  std::string title, subtitle;
  Axis x, y;
  std::vector<PlotSeries> series;
  std::vector<std::vector<XY>> fronts;  // Pareto points by growing x, of each setting
  double uncertain_below = 0;           // y; 0: no band
  std::string uncertain_label;
  std::vector<PlotLine> lines;
  std::vector<SlopeMark> slopes;
};

std::string plot_svg(const Plot& plot, bool inline_page = false);

// Title and, where there is one, subtitle above a drawing of `width` px whose frame begins at `left`.
void draw_titles(Svg& svg, double left, double width, const std::string& title, const std::string& subtitle);

// A point in the units of the axes within the frame.
XY position(const Box& frame, const Axis& x, const Axis& y, XY point);

// Only axes, curves and marks, into `area` (the frame; tick labels stand outside). For sheets of small drawings.
void draw_curves(Svg& svg, const Box& area, const Plot& plot, double mark_size);
void draw_axes(Svg& svg, const Box& area, const Axis& x, const Axis& y, double label_size, bool x_words = true,
               bool y_words = true);

}  // namespace feder::report
