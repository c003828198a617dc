// What lies over the view: errors, the grip's spring, the scene picker and the help.
#include <algorithm>
#include <cstdio>

#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
namespace {

constexpr ImGuiWindowFlags kOverlay = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize |
                                      ImGuiWindowFlags_NoFocusOnAppearing;

// One message with a stripe of its colour. True when its cross was clicked.
bool message(const char* id, const char* title, const std::string& text, ImU32 color, float width, bool closable) {
  ImGui::PushID(id);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::Indent(10);
  colored_text(color, title);
  bool closed = false;
  if (closable) {
    ImGui::SameLine(width - 30);
    closed = ImGui::SmallButton("x");
  }
  ImGui::PushTextWrapPos(width - 8);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::Unindent(10);
  ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + 3, ImGui::GetCursorScreenPos().y - 4}, color, 1);
  ImGui::PopID();
  return closed;
}

}  // namespace

void draw_messages(PanelLayout& layout, const PanelSizes& sizes) {
  LiveScene& live = layout.live;
  static const std::vector<lua::HandlerError> none;
  const auto& errors = live.has_scene() ? live.script().handler_errors() : none;
  if (layout.show_picker) return;  // it stands in the same place
  if (live.error().empty() && live.notice().empty() && errors.empty()) return;
  const float width = std::min(720.0f, sizes.width - sizes.left - sizes.right - 40);
  ImGui::SetNextWindowPos({sizes.left + (sizes.width - sizes.left - sizes.right) / 2, sizes.top + 14}, ImGuiCond_Always,
                          {0.5f, 0});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, IM_COL32(38, 28, 30, 236));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6);
  ImGui::Begin("messages", nullptr, kOverlay);
  if (!live.error().empty())
    message("load", live.has_scene() ? "not loaded; the last good scene goes on" : "not loaded", live.error(),
            ink::kBad, width, false);
  int shown = 0;
  for (auto e = errors.rbegin(); e != errors.rend() && shown < 3; ++e, ++shown) {
    const std::string times = e->count > 1 ? "  (" + std::to_string(e->count) + " times)" : "";
    message(
        e->where.c_str(),
        live.paused() && e->message.find("instruction limit") != std::string::npos ? "stopped" : "error in the scene",
        (e->where.empty() ? "" : e->where + ": ") + e->message + times, ink::kBad, width, false);
  }
  if (errors.size() > 3) ImGui::TextDisabled("and %zu more", errors.size() - 3);
  if (!live.notice().empty() && message("notice", "note", live.notice(), ink::kWarn, width, true)) live.clear_notice();
  ImGui::End();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
}

void draw_notes(const PanelLayout& layout, const PanelSizes& sizes) {
  if (layout.notes.empty() && !layout.toggles.volumes && !layout.toggles.cells) return;
  const float width = std::max(100.0f, sizes.width - sizes.left - sizes.right - 20);
  ImGui::SetNextWindowPos({sizes.left + 10, sizes.height - sizes.bottom - sizes.console - 8}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowBgAlpha(0.7f);
  ImGui::Begin("notes", nullptr, kOverlay | ImGuiWindowFlags_NoInputs);
  ImGui::PushTextWrapPos(width - 20);
  for (const std::string& note : layout.notes) colored_text(ink::kWarn, note.c_str());
  if (layout.toggles.volumes)
    ImGui::Text("volumes: level %d%s", layout.toggles.volume_level, layout.deeper_volumes ? "" : ", the last");
  if (layout.toggles.cells)
    ImGui::Text("cells: level %d%s", layout.toggles.cell_level, layout.deeper_cells ? "" : ", the last");
  ImGui::PopTextWrapPos();
  ImGui::End();
}

void draw_grip(PanelLayout& layout, float scale, const Target& t) {
  if (!layout.live.has_scene()) return;
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  const auto screen = [&](const Vec3& x, ImVec2& out) {
    if (!layout.camera.project(to_float3(x), t.width, t.height, out.x, out.y)) return false;
    out.x /= scale, out.y /= scale;
    return true;
  };
  if (layout.live.held() && alive(layout.live.world(), *layout.live.held())) {
    ImVec2 a, b;
    if (screen(grip_position(layout.live.world(), *layout.live.held()), a) && screen(layout.live.held()->target, b)) {
      list->AddLine(a, b, ink::kAccent, 2);
      list->AddCircleFilled(a, 4, ink::kText);
      list->AddCircle(b, 6, ink::kAccent, 0, 2);
    }
  }
}

void draw_picker(PanelLayout& layout, const PanelSizes& sizes) {
  if (!layout.show_picker) return;
  const float width = std::min(520.0f, sizes.width - 40), height = std::min(520.0f, sizes.height - 120);
  ImGui::SetNextWindowSize({width, height});
  begin_dialog("scenes", layout.show_picker, {sizes.width / 2, sizes.top + 30}, {0.5f, 0});
  char text[120];
  std::snprintf(text, sizeof text, "%s", layout.search.c_str());
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-1);
  const bool enter =
      ImGui::InputTextWithHint("##search", "search", text, sizeof text, ImGuiInputTextFlags_EnterReturnsTrue);
  layout.search = text;
  ImGui::BeginChild("list");
  bool first = true;
  for (const SceneEntry& e : layout.scenes) {
    if (!matches(e, layout.search)) continue;
    const bool here = std::filesystem::absolute(layout.live.file()).lexically_normal() == e.file;
    ImGui::PushID(e.name.c_str());
    const bool clicked = ImGui::Selectable("##scene", here, 0, {0, 22});
    ImGui::PopID();
    ImGui::SameLine(8);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 2);
    ImGui::TextUnformatted(e.name.c_str());
    ImGui::SameLine(220);
    ImGui::TextDisabled("%s", e.title.c_str());
    if (clicked || (enter && first)) layout.open_file = e.file.string(), layout.show_picker = false;
    first = false;
  }
  if (first) ImGui::TextDisabled("no scene has these words");
  ImGui::EndChild();
  end_dialog();
}

void draw_help(PanelLayout& layout, const PanelSizes& sizes) {
  if (!layout.show_help) return;
  static const char* const rows[][2] = {{"space", "run, pause"},
                                        {"right, left", "one step, one step back"},
                                        {"R", "start over"},
                                        {"end", "to the present"},
                                        {"+  -", "faster, slower"},
                                        {"", ""},
                                        {"left drag", "pull a thing; elsewhere: turn the camera"},
                                        {"shift + left drag", "turn the camera"},
                                        {"right drag", "move the camera"},
                                        {"wheel", "nearer, farther"},
                                        {"F", "show everything"},
                                        {"T", "follow the selected thing"},
                                        {"V", "volumes of meshes, and boxes: next level, then none"},
                                        {"C", "nodes or cells of the broad phase: likewise"},
                                        {"", ""},
                                        {"P", "pin what is held or selected, or free it"},
                                        {"B", "shoot a ball at the mouse"},
                                        {"click", "select"},
                                        {"", ""},
                                        {"/", "other scenes"},
                                        {"`", "console"},
                                        {"F2  F3", "left and right panel"},
                                        {"tab", "hide all panels"},
                                        {"F5", "reload"},
                                        {"F12", "save a picture"},
                                        {"F1", "this help"}};
  begin_dialog("keys and mouse", layout.show_help, {sizes.width / 2, sizes.height / 2}, {0.5f, 0.5f},
               ImGuiWindowFlags_AlwaysAutoResize);
  for (const auto& row : rows) {
    if (!row[0][0]) {
      ImGui::Spacing();
      continue;
    }
    colored_text(ink::kAccent, row[0]);
    ImGui::SameLine(160);
    ImGui::TextUnformatted(row[1]);
  }
  end_dialog();
}

}  // namespace feder::view
