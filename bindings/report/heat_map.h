// A heat map: cells over two axes, each with a verdict. Failures have a colour and a hatching, good cells a shade by
// their error's decade; a theoretical limit and a measured boundary lie over it.
#pragma once
#include <string>
#include <vector>

#include "report/axis.h"
#include "report/svg.h"

namespace feder::report {

struct HeatCell {
  double x = 0, y = 0;
  std::string verdict;  // "stable", "diverged", ...
  double error = 0;     // of a stable cell
  std::string title;
};

struct HeatMap {
  std::string name, title, subtitle;
  Axis x, y;  // labels and kind; their ends come from the cells
  std::vector<HeatCell> cells;
  std::vector<XY> theory, boundary;  // in units of the axes
  std::string theory_label, boundary_label;
};

// A verdict's looks and meaning. Unknown ones are drawn like "other".
struct VerdictStyle {
  const char* name;
  const char* color;
  int hatch;  // of Hatch; -1: plain
  const char* meaning;
};
const VerdictStyle& verdict_style(const std::string& verdict);

// Shade of a stable cell by the decade of its error.
const char* error_shade(double error);

std::string heat_map_svg(const HeatMap& map, bool inline_page = false);
// Several maps with shared axes and one legend, `columns` beside each other.
std::string heat_sheet_svg(const std::string& name, const std::string& title, const std::vector<HeatMap>& maps,
                           int columns, bool inline_page = false);

}  // namespace feder::report
