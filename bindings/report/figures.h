// Small drawings besides the plot: rows of curves over one time axis, sheets of small plots.
#pragma once
#include <string>
#include <vector>

#include "report/plot.h"

namespace feder::report {

// Rows that share their x axis, one under the other: an invariant each.
struct RowChart {
  std::string name, title, subtitle;
  std::string x_label;
  struct Row {
    std::string label;  // with its unit
    bool log = false;
    std::vector<PlotSeries> series;  // curves without marks; points that are not finite interrupt them
  };
  std::vector<Row> rows;
};
std::string row_chart_svg(const RowChart& chart, bool inline_page = false);

// Small plots with shared axes (the first one's labels). Each has its own title; the subtitle stands in its corner.
std::string plot_sheet_svg(const std::string& name, const std::string& title, const std::string& subtitle,
                           const std::vector<Plot>& plots, int columns, bool inline_page = false);

}  // namespace feder::report
