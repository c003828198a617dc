// The panel at the left: the scene's parameters, the world's options, and what is drawn.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "view/fields.h"
#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
namespace {

std::string number_text(double x) { return fmt::format("{:.9g}", x); }

bool is_whole(double x) { return std::abs(x) < 1e9 && x == std::floor(x); }

// A number that only makes sense whole: its step says so, or a wide range of whole numbers.
bool counts(const lua::ParamInfo& p) {
  const double fallback = std::atof(p.fallback.c_str());
  if (p.has_step) return is_whole(p.step) && is_whole(fallback);
  return p.has_min && p.has_max && is_whole(p.min) && is_whole(p.max) && is_whole(fallback) && p.max - p.min > 10;
}

void change(PanelLayout& layout, const lua::ParamInfo& p, std::string value) {
  if (!layout.pending) layout.pending = PendingParam{p.name, value, layout.now};
  if (layout.pending->name != p.name) {
    layout.live.set_param(layout.pending->name, layout.pending->value);
    layout.pending = PendingParam{p.name, value, layout.now};
  }
  layout.pending->value = std::move(value);
}

bool number_widget(const lua::ParamInfo& p, double& value) {
  const double first = p.has_min ? p.min : 0;
  if (counts(p)) {
    int whole = static_cast<int>(std::lround(value));
    const bool moved = p.has_min && p.has_max
                           ? ImGui::SliderInt("##value", &whole, static_cast<int>(p.min), static_cast<int>(p.max))
                           : ImGui::DragInt("##value", &whole, 0.2f);
    value = whole;
    if (p.has_step) value = first + std::round((value - first) / p.step) * p.step;
    return moved;
  }
  float real = static_cast<float>(value);
  const float size = std::max(1e-3f, std::abs(real));
  const bool moved = p.has_min && p.has_max ? ImGui::SliderFloat("##value", &real, static_cast<float>(p.min),
                                                                 static_cast<float>(p.max), "%.4g")
                                            : ImGui::DragFloat("##value", &real, size * 0.01f, 0, 0, "%.4g");
  value = std::strtod(number_text(static_cast<double>(real)).c_str(), nullptr);
  value = std::atof(fmt::format("{:.6g}", value).c_str());
  if (p.has_step) value = first + std::round((value - first) / p.step) * p.step;
  if (p.has_min) value = std::max(value, p.min);
  if (p.has_max) value = std::min(value, p.max);
  return moved;
}

void param_row(PanelLayout& layout, const lua::ParamInfo& p) {
  std::string now = p.value;
  const auto user = layout.live.user_params().find(p.name);
  if (user != layout.live.user_params().end()) now = user->second;
  if (layout.pending && layout.pending->name == p.name) now = layout.pending->value;
  ImGui::PushID(p.name.c_str());
  const bool changed = now != p.fallback;
  colored_text(changed ? ink::kAccent : ink::kDim, p.name.c_str());
  const bool name_hovered = ImGui::IsItemHovered();
  if (changed) {
    ImGui::SameLine(ImGui::GetContentRegionAvail().x - 28);
    if (ImGui::SmallButton("reset")) change(layout, p, p.fallback);
  }
  ImGui::SetNextItemWidth(-1);
  char* end = nullptr;
  double value = std::strtod(now.c_str(), &end);
  const bool numeric = end != now.c_str() && *end == 0;
  if (!p.choices.empty()) {
    if (ImGui::BeginCombo("##value", now.c_str())) {
      for (const std::string& choice : p.choices)
        if (ImGui::Selectable(choice.c_str(), choice == now)) change(layout, p, choice);
      ImGui::EndCombo();
    }
  } else if (p.fallback == "true" || p.fallback == "false") {
    bool on = now == "true";
    if (ImGui::Checkbox("##value", &on)) change(layout, p, on ? "true" : "false");
  } else if (numeric) {
    if (number_widget(p, value)) change(layout, p, number_text(value));
  } else {
    char text[200];
    std::snprintf(text, sizeof text, "%s", now.c_str());
    if (ImGui::InputText("##value", text, sizeof text, ImGuiInputTextFlags_EnterReturnsTrue)) change(layout, p, text);
  }
  if (name_hovered || ImGui::IsItemHovered())
    ImGui::SetTooltip("%s%sfeder.param(\"%s\", %s)", p.help.c_str(), p.help.empty() ? "" : "\n", p.name.c_str(),
                      p.fallback.c_str());
  ImGui::PopID();
}

void draw_world_options(PanelLayout& layout) {
  LiveScene& live = layout.live;
  const WorldDesc& d = live.world().desc();
  for (const SystemPanel& panel : system_panels())
    if (panel.options) panel.options(layout);
  label("substeps", kOptions);
  int substeps = d.substeps;
  if (ImGui::SliderInt("##substeps", &substeps, 1, 32)) live.set_world_option("substeps", std::to_string(substeps));
  label("dt", kOptions);
  if (ImGui::BeginCombo("##dt", fmt::format("1/{:.4g} s", 1 / d.dt).c_str())) {
    for (const int rate : {30, 60, 120, 240, 480, 1000})
      if (ImGui::Selectable(fmt::format("1/{} s", rate).c_str(), std::abs(d.dt * rate - 1) < 1e-6))
        live.set_world_option("dt", fmt::format("{:.17g}", 1.0 / rate));
    ImGui::EndCombo();
  }
}

void draw_toggles(PanelLayout& layout) {
  int column = 0;
  const float half = ImGui::GetContentRegionAvail().x / 2;
  for (const ToggleInfo& t : toggle_list()) {
    if (column++ % 2 == 1) ImGui::SameLine(half + 12);
    ImGui::Checkbox(t.name, &(layout.toggles.*t.field));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", t.help);
  }
  const auto slide = [&](const char* label, const char* id, int& level) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextDisabled("%s", label);
    ImGui::SameLine(half + 12);
    ImGui::SetNextItemWidth(-1);
    ImGui::SliderInt(id, &level, 0, 24, "%d", ImGuiSliderFlags_AlwaysClamp);
  };
  if (layout.toggles.volumes) slide("volumes, level", "##level", layout.toggles.volume_level);
  if (layout.toggles.cells) slide("cells, level", "##cells", layout.toggles.cell_level);
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("fluids by");
  ImGui::SameLine(half + 12);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##scalar", layout.toggles.point_scalar)) {
    for (const char* name : point_scalars())
      if (ImGui::Selectable(name, std::string_view(name) == layout.toggles.point_scalar))
        layout.toggles.point_scalar = name;
    ImGui::EndCombo();
  }
}

void apply_pending(PanelLayout& layout) {
  if (!layout.pending) return;
  const bool resting = !ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (!resting && layout.now - layout.pending->since < 0.1) return;
  const PendingParam p = *layout.pending;
  layout.pending.reset();
  const auto user = layout.live.user_params().find(p.name);
  if (user == layout.live.user_params().end() || user->second != p.value) layout.live.set_param(p.name, p.value);
}

}  // namespace

void draw_scene_panel(PanelLayout& layout, const PanelSizes& sizes) {
  if (sizes.left == 0) return;
  begin_panel("scene panel", {0, sizes.top}, {sizes.left, sizes.height - sizes.top - sizes.bottom}, kSidePanel);
  if (layout.live.has_scene()) {
    if (ImGui::CollapsingHeader("Parameters", ImGuiTreeNodeFlags_DefaultOpen)) {
      const auto params = layout.live.script().params();
      for (const lua::ParamInfo& p : params) param_row(layout, p);
      if (params.empty()) ImGui::TextWrapped("none: feder.param(\"name\", value) in the scene makes a slider");
    }
    if (ImGui::CollapsingHeader("World", ImGuiTreeNodeFlags_DefaultOpen)) draw_world_options(layout);
    if (ImGui::CollapsingHeader("Draw", ImGuiTreeNodeFlags_DefaultOpen)) draw_toggles(layout);
  }
  ImGui::End();
  apply_pending(layout);
}

}  // namespace feder::view
