// The plot widget: one curve in a well, its range at the left, the value under the mouse.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
namespace {

std::string short_number(double x) {
  char text[32];
  const double a = std::abs(x);
  if (a >= 1e5 || (a > 0 && a < 1e-3))
    std::snprintf(text, sizeof text, "%.2e", x);
  else
    std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

struct Axes {
  ImVec2 low, high;  // of the well
  double from, to, bottom, top;
  ImVec2 at(double t, double v) const {
    return {low.x + static_cast<float>((t - from) / (to - from)) * (high.x - low.x),
            high.y - static_cast<float>((v - bottom) / (top - bottom)) * (high.y - low.y)};
  }
};

Axes make_axes(const std::vector<CurvePoint>& points, ImVec2 low, ImVec2 high) {
  Axes a{low, high, points.front().time, points.back().time, points[0].value, points[0].value};
  for (const CurvePoint& p : points) a.bottom = std::min(a.bottom, p.value), a.top = std::max(a.top, p.value);
  // a curve that is flat to the eye is drawn flat
  const double size = std::max(std::abs(a.bottom), std::abs(a.top));
  const double margin = std::max({(a.top - a.bottom) * 0.08, size * 1e-3, 1e-12});
  a.bottom -= margin, a.top += margin;
  a.to = std::max(a.to, a.from + 1e-6);
  return a;
}

void draw_line(ImDrawList* list, const Axes& a, const std::vector<CurvePoint>& points, unsigned color) {
  std::vector<ImVec2> line;
  line.reserve(points.size());
  for (const CurvePoint& p : points) line.push_back(a.at(p.time, p.value));
  list->AddPolyline(line.data(), static_cast<int>(line.size()), color, ImDrawFlags_None, 1.5f);
}

void show_value(ImDrawList* list, const Axes& a, const std::vector<CurvePoint>& points, const std::string& unit) {
  const double share = (ImGui::GetIO().MousePos.x - a.low.x) / (a.high.x - a.low.x);
  const double time = a.from + share * (a.to - a.from);
  const auto p = std::min_element(points.begin(), points.end(), [&](const CurvePoint& x, const CurvePoint& y) {
    return std::abs(x.time - time) < std::abs(y.time - time);
  });
  const ImVec2 dot = a.at(p->time, p->value);
  list->AddLine({dot.x, a.low.y}, {dot.x, a.high.y}, ink::kLine);
  list->AddCircleFilled(dot, 3, ink::kText);
  ImGui::SetTooltip("%.3f s: %s %s", p->time, short_number(p->value).c_str(), unit.c_str());
}

}  // namespace

void draw_curve(const std::string& name, const std::string& unit, const std::vector<CurvePoint>& points, double cursor,
                unsigned color) {
  const float width = ImGui::GetContentRegionAvail().x;
  const std::string value = points.empty() ? "-" : short_number(points.back().value) + " " + unit;
  const float room = width - ImGui::CalcTextSize(value.c_str()).x - 8;
  const ImVec2 start = ImGui::GetCursorScreenPos();
  ImGui::PushClipRect(start, {start.x + room, start.y + ImGui::GetTextLineHeight()}, true);
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ink::kDim), "%s", name.c_str());
  ImGui::PopClipRect();
  ImGui::SameLine(width - ImGui::CalcTextSize(value.c_str()).x + ImGui::GetCursorStartPos().x);
  ImGui::TextUnformatted(value.c_str());
  const ImVec2 low = ImGui::GetCursorScreenPos(), size(width, 44);
  ImGui::PushID(name.c_str());
  ImGui::InvisibleButton("curve", size);
  ImGui::PopID();
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImVec2 high(low.x + size.x, low.y + size.y);
  list->AddRectFilled(low, high, ink::kWell, 3);
  if (points.size() < 2) return;
  list->PushClipRect(low, high, true);
  const Axes axes = make_axes(points, low, high);
  if (axes.bottom < 0 && axes.top > 0) list->AddLine(axes.at(axes.from, 0), axes.at(axes.to, 0), ink::kLine);
  draw_line(list, axes, points, color);
  if (cursor < axes.to) {
    const float x = axes.at(cursor, 0).x;
    list->AddLine({x, low.y}, {x, high.y}, ink::kWarn);
  }
  if (ImGui::IsItemHovered()) show_value(list, axes, points, unit);
  list->PopClipRect();
}

}  // namespace feder::view
