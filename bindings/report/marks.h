// How a curve differs from its neighbours: colour, marker and dash together, never colour alone.
#pragma once
#include <string>

#include "report/svg.h"

namespace feder::report {

// Curves are numbered. Of the first 32 any two differ in at least two of colour, marker and dash.
struct CurveStyle {
  std::string color, dash;
  int marker = 0;
};
CurveStyle curve_style(int number);
inline constexpr int kColors = 8;

enum class MarkKind {
  hollow,     // an ordinary point
  filled,     // on the Pareto front
  uncertain,  // below the certainty of the reference: grey, hollow
  // what could not be measured, drawn in the gutter
  diverged,  // x
  nan,       // empty set
  refused,   // slashed circle
  other,     // any other verdict that is no measurement: triangle with a bar
};
bool is_failure(MarkKind kind);

// A marker of about `size` px around `at`; class "point" or "point failed", none without a title (legends).
void draw_mark(Svg& svg, XY at, MarkKind kind, const CurveStyle& style, double size, const std::string& title);

// A short piece of the curve with its marker, for legends.
void draw_sample(Svg& svg, XY left, double width, const CurveStyle& style);

}  // namespace feder::report
