// The selected object: what it is, how it moves, and fields that can be edited. Every edit is a Command.
#include "view/fields.h"
#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
using Row = SystemPanel;
#include "window_declare.inc"

std::span<const SystemPanel> system_panels() {
  static const std::initializer_list<SystemPanel> table = {
#include "window_rows.inc"
  };
  return {table.begin(), table.size()};
}

void label(const char* name, float at) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(at);
  ImGui::SetNextItemWidth(-1);
}

void fact(const char* name, const std::string& value) {
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(92);
  ImGui::TextUnformatted(value.c_str());
}

// Three numbers; true when they were changed.
bool edit_vector(const char* name, Vec3& v, float speed) {
  float f[3] = {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  label(name);
  ImGui::PushID(name);
  const bool changed = ImGui::DragFloat3("##v", f, speed, 0, 0, "%.2f");
  ImGui::PopID();
  if (changed)
    for (int k = 0; k < 3; ++k) v[k] = static_cast<Real>(f[k]);
  return changed;
}

bool edit_number(const char* name, Real now, float low, float high, Real& out) {
  float f = static_cast<float>(now);
  label(name);
  ImGui::PushID(name);
  const bool changed = ImGui::DragFloat("##n", &f, 0.01f, low, high, "%.3g", ImGuiSliderFlags_AlwaysClamp);
  ImGui::PopID();
  out = static_cast<Real>(f);
  return changed;
}

void draw_inspector(PanelLayout& layout) {
  if (!layout.has_selection()) {
    ImGui::TextWrapped("Click a thing to look at it; drag it to pull it.");
    return;
  }
  const Objects& objects = layout.live.world().objects();
  const ObjectId id = layout.selected->object;
  colored_text(ink::kAccent, objects.describe(id).c_str());
  for (const SystemPanel& panel : system_panels())
    if (objects.kind(id) == *panel.kind) panel.inspect(layout, id);
  ImGui::Checkbox("camera follows", &layout.follow);
  ImGui::SameLine();
  const bool pinned = is_pinned(layout.live.world(), *layout.selected);
  if (ImGui::Button(pinned ? "free" : "pin"))
    layout.live.act(pin_command(layout.live.world(), *layout.selected), pinned ? "free" : "pin");
}

}  // namespace feder::view
