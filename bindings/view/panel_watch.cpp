// The panel at the right: the selected object, where the time goes, and curves.
#include <algorithm>
#include <cstdio>

#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
namespace {

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
    char value[32];
    std::snprintf(value, sizeof value, "%.3f", r.ms);
    const float value_width = ImGui::CalcTextSize(value).x;
    // of a script's path the file counts
    const std::string text = lua    ? r.label.substr(r.label.find_last_of('/') + 1)
                             : loop ? r.label
                                    : r.detail + ": " + r.label;
    ImGui::PushClipRect(at, {at.x + width - value_width - 10, at.y + height + 2}, true);
    list->AddText({at.x + 4 + 10 * static_cast<float>(r.depth), at.y}, ink::kText, text.c_str());
    ImGui::PopClipRect();
    list->AddText({at.x + width - value_width - 2, at.y}, ink::kText, value);
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
  ImGui::SetNextWindowPos({sizes.width - sizes.right, sizes.top});
  ImGui::SetNextWindowSize({sizes.right, sizes.height - sizes.top - sizes.bottom});
  ImGui::Begin("watch panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus);
  if (layout.live.has_scene()) {
    if (ImGui::CollapsingHeader("Inspector", ImGuiTreeNodeFlags_DefaultOpen)) draw_inspector(layout);
    if (ImGui::CollapsingHeader("Curves", ImGuiTreeNodeFlags_DefaultOpen)) draw_curves(layout);
    if (ImGui::CollapsingHeader("Time per step (ms)", ImGuiTreeNodeFlags_DefaultOpen)) draw_times(layout);
  }
  ImGui::End();
}

}  // namespace feder::view
