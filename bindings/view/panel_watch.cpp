// The panel at the right: the selected object, where the time goes, and curves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
namespace {

std::string short_number(double x) {
  const double a = std::abs(x);
  return a >= 1e5 || (a > 0 && a < 1e-3) ? fmt::format("{:.2e}", x) : fmt::format("{:.4g}", x);
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

// The plot widget: one curve in a well, its range at the left, the value under the mouse; `cursor`: the time shown.
void draw_curve(const std::string& name, const std::string& unit, const std::vector<CurvePoint>& points, double cursor,
                unsigned color) {
  const float width = ImGui::GetContentRegionAvail().x;
  const std::string value = points.empty() ? "-" : short_number(points.back().value) + " " + unit;
  const float room = width - ImGui::CalcTextSize(value.c_str()).x - 8;
  const ImVec2 start = ImGui::GetCursorScreenPos();
  ImGui::PushClipRect(start, {start.x + room, start.y + ImGui::GetTextLineHeight()}, true);
  colored_text(ink::kDim, name.c_str());
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

constexpr double kMinShare = 0.003;  // a pass with less of a step is not listed

void draw_times(PanelLayout& layout) {
  // the plan as it runs, loops before their passes, then Lua
  const std::vector<TimeRow>& rows = layout.sampler.rows();
  double longest = 1e-6, sum = 0;
  for (const TimeRow& r : rows) {
    if (!r.detail.empty()) longest = std::max(longest, r.ms);
    if (r.depth == 0) sum += r.ms;
  }
  if (rows.empty()) ImGui::TextDisabled("nothing has run yet");
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float width = ImGui::GetContentRegionAvail().x;
  for (const TimeRow& r : rows) {
    const bool lua = r.detail == "Lua", loop = r.detail.empty();
    if (r.ms < std::max(0.0005, kMinShare * sum) && !lua) continue;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float height = ImGui::GetTextLineHeight();
    if (!loop)
      list->AddRectFilled({at.x, at.y}, {at.x + width * static_cast<float>(r.ms / longest), at.y + height},
                          lua ? IM_COL32(120, 96, 52, 140) : IM_COL32(60, 92, 128, 130), 2);
    const std::string value = fmt::format("{:.3f}", r.ms);
    const float value_width = ImGui::CalcTextSize(value.c_str()).x;
    // of a script's path the file counts
    const std::string text = lua    ? r.label.substr(r.label.find_last_of('/') + 1)
                             : loop ? r.label
                                    : r.detail + ": " + r.label;
    ImGui::PushClipRect(at, {at.x + width - value_width - 10, at.y + height + 2}, true);
    list->AddText({at.x + 4 + 10 * static_cast<float>(r.depth), at.y}, ink::kText, text.c_str());
    ImGui::PopClipRect();
    list->AddText({at.x + width - value_width - 2, at.y}, ink::kText, value.c_str());
    ImGui::Dummy({width, height - 2});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s\n%.4f ms per step, %.1f calls", r.label.c_str(), r.ms, r.calls);
  }
  ImGui::TextDisabled("%.3f ms per step in all", sum);
}

const unsigned kCurveColors[] = {IM_COL32(236, 190, 96, 255), IM_COL32(226, 140, 90, 255), IM_COL32(240, 112, 104, 255),
                                 IM_COL32(104, 168, 232, 255)};
const unsigned kScriptColors[] = {IM_COL32(126, 200, 140, 255), IM_COL32(186, 148, 232, 255),
                                  IM_COL32(120, 208, 208, 255), IM_COL32(232, 148, 190, 255)};

void draw_curves(PanelLayout& layout) {
  const double cursor = layout.live.shown_time();
  std::size_t n = 0;
  for (const Curve& c : layout.sampler.curves())
    draw_curve(c.name(), c.unit(), c.points(), cursor, kCurveColors[n++ % 4]);
  n = 0;
  std::vector<CurvePoint> points;
  for (const lua::PlotSeries& p : layout.live.script().plots()) {
    points.clear();
    for (const auto& q : p.points) points.push_back({layout.live.clock_of(q.time), q.value});
    draw_curve(p.name, "", points, cursor, kScriptColors[n++ % 4]);
  }
}

}  // namespace

void draw_watch_panel(PanelLayout& layout, const PanelSizes& sizes) {
  if (sizes.right == 0) return;
  begin_panel("watch panel", {sizes.width - sizes.right, sizes.top},
              {sizes.right, sizes.height - sizes.top - sizes.bottom}, kSidePanel);
  if (layout.live.has_scene()) {
    if (ImGui::CollapsingHeader("Inspector", ImGuiTreeNodeFlags_DefaultOpen)) draw_inspector(layout);
    if (ImGui::CollapsingHeader("Curves", ImGuiTreeNodeFlags_DefaultOpen)) draw_curves(layout);
    if (ImGui::CollapsingHeader("Time per step (ms)", ImGuiTreeNodeFlags_DefaultOpen)) draw_times(layout);
  }
  ImGui::End();
}

}  // namespace feder::view
