#include "report/marks.h"

#include <cmath>

#include "report/xml.h"

namespace feder::report {
namespace {

// Okabe and Ito 2008, "Color universal design", with the yellow darkened so that it shows on white and on paper.
constexpr const char* kHues[kColors] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                        "#8a6d00", "#56b4e9", "#1f2328", "#e69f00"};
constexpr const char* kDashes[] = {"", "7 3", "2 3", "9 3 2 3"};
constexpr int kMarkers = 8;

std::string at_text(double x, double y) { return px(x) + " " + px(y); }

// A closed polygon of `corners` on a circle, the first one at `angle` (turns, 0 = up).
std::string ngon(XY c, double r, int corners, double angle, double inner = 0) {
  std::string d;
  const int count = inner > 0 ? 2 * corners : corners;
  for (int k = 0; k < count; ++k) {
    const double radius = inner > 0 && k % 2 ? inner : r;
    const double a = (angle + static_cast<double>(k) / count) * 2 * M_PI;
    d += (k ? "L" : "M") + at_text(c.x + radius * std::sin(a), c.y - radius * std::cos(a));
  }
  return d + "Z";
}

std::string circle(XY c, double r) {
  const std::string arc = "A" + at_text(r, r) + " 0 1 0 ";
  return "M" + at_text(c.x - r, c.y) + arc + at_text(c.x + r, c.y) + arc + at_text(c.x - r, c.y) + "Z";
}

std::string plus(XY c, double r, double half) {
  std::string d = "M" + at_text(c.x - half, c.y - r);
  const double xs[] = {half, half, r, r, half, half, -half, -half, -r, -r, -half};
  const double ys[] = {-r, -half, -half, half, half, r, r, half, half, -half, -half};
  for (int k = 0; k < 11; ++k) d += "L" + at_text(c.x + xs[k], c.y + ys[k]);
  return d + "Z";
}

std::string shape(int marker, XY c, double r) {
  switch (marker) {
    case 0: return circle(c, r * 0.95);
    case 1: return ngon(c, r * 1.2, 4, 0.125);       // square
    case 2: return ngon(c, r * 1.3, 3, 0);           // triangle up
    case 3: return ngon(c, r * 1.25, 4, 0);          // diamond
    case 4: return ngon(c, r * 1.3, 3, 0.5);         // triangle down
    case 5: return ngon(c, r * 1.4, 5, 0, r * 0.6);  // star
    case 6: return ngon(c, r * 1.15, 6, 0);          // hexagon
    default: return plus(c, r * 1.2, r * 0.42);
  }
}

std::string cross(XY c, double r) {
  return "M" + at_text(c.x - r, c.y - r) + "L" + at_text(c.x + r, c.y + r) + "M" + at_text(c.x - r, c.y + r) + "L" +
         at_text(c.x + r, c.y - r);
}

std::string slash(XY c, double r) { return "M" + at_text(c.x - r, c.y + r) + "L" + at_text(c.x + r, c.y - r); }

}  // namespace

CurveStyle curve_style(int number) {
  return {kHues[number % kColors], kDashes[(number / kColors) % 4], (number + 3 * (number / kColors)) % kMarkers};
}

bool is_failure(MarkKind kind) { return kind >= MarkKind::diverged; }

void draw_mark(Svg& svg, XY c, MarkKind kind, const CurveStyle& style, double size, const std::string& title) {
  const double r = size / 2;
  const Stroke pen{style.color, 1.5};
  const char* const name = title.empty() ? "" : is_failure(kind) ? "point failed" : "point";
  switch (kind) {
    case MarkKind::hollow: svg.path(shape(style.marker, c, r), "#ffffff", pen, title, name); break;
    case MarkKind::filled: svg.path(shape(style.marker, c, r), style.color, pen, title, name); break;
    case MarkKind::uncertain: svg.path(shape(style.marker, c, r), "#ffffff", {"#9aa3ad", 1.2}, title, name); break;
    case MarkKind::diverged: svg.path(cross(c, r * 0.8), "none", {style.color, 1.8}, title, name); break;
    case MarkKind::nan:
      svg.path(circle(c, r * 0.75) + slash(c, r * 1.2), "none", {style.color, 1.4}, title, name);
      break;
    case MarkKind::refused:
      svg.path(circle(c, r) + "M" + at_text(c.x - r * 0.7, c.y - r * 0.7) + "L" + at_text(c.x + r * 0.7, c.y + r * 0.7),
               "none", {style.color, 1.8}, title, name);
      break;
    case MarkKind::other:
      svg.path(ngon({c.x, c.y + r * 0.2}, r * 1.2, 3, 0) + "M" + at_text(c.x, c.y - r * 0.4) + "V" + px(c.y + r * 0.4),
               "none", {style.color, 1.3}, title, name);
      break;
  }
}

void draw_sample(Svg& svg, XY left, double width, const CurveStyle& style) {
  svg.line(left, {left.x + width, left.y}, {style.color, 1.6, style.dash});
  svg.path(shape(style.marker, {left.x + width / 2, left.y}, 3.5), style.color, {style.color, 1.5});
}

}  // namespace feder::report
