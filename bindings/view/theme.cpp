#include "view/theme.h"

namespace feder::view {
namespace {
ImVec4 color(ImU32 c, float alpha = 1) {
  ImVec4 v = ImGui::ColorConvertU32ToFloat4(c);
  v.w *= alpha;
  return v;
}
}  // namespace

void apply_theme() {
  ImGui::StyleColorsDark();
  ImGuiStyle& s = ImGui::GetStyle();
  s.WindowRounding = 0, s.FrameRounding = 4, s.GrabRounding = 4, s.PopupRounding = 6, s.ScrollbarRounding = 6;
  s.TabRounding = 4, s.ChildRounding = 4;
  s.WindowPadding = ImVec2(12, 10), s.FramePadding = ImVec2(8, 4), s.ItemSpacing = ImVec2(8, 6);
  s.WindowBorderSize = 0, s.PopupBorderSize = 1, s.ScrollbarSize = 10, s.GrabMinSize = 10;
  ImVec4* c = s.Colors;
  c[ImGuiCol_Text] = color(ink::kText), c[ImGuiCol_TextDisabled] = color(ink::kDim);
  c[ImGuiCol_WindowBg] = color(ink::kPanel), c[ImGuiCol_PopupBg] = ImVec4(0.13f, 0.145f, 0.17f, 0.98f);
  c[ImGuiCol_ChildBg] = ImVec4(0, 0, 0, 0), c[ImGuiCol_Border] = color(ink::kLine);
  c[ImGuiCol_FrameBg] = ImVec4(0.165f, 0.18f, 0.21f, 1);
  c[ImGuiCol_FrameBgHovered] = ImVec4(0.2f, 0.225f, 0.265f, 1);
  c[ImGuiCol_FrameBgActive] = ImVec4(0.22f, 0.26f, 0.32f, 1);
  c[ImGuiCol_Button] = ImVec4(0.19f, 0.21f, 0.25f, 1);
  c[ImGuiCol_ButtonHovered] = ImVec4(0.25f, 0.29f, 0.35f, 1);
  c[ImGuiCol_ButtonActive] = color(ink::kAccent, 0.7f);
  c[ImGuiCol_Header] = ImVec4(0.19f, 0.21f, 0.25f, 1);
  c[ImGuiCol_HeaderHovered] = ImVec4(0.24f, 0.27f, 0.33f, 1);
  c[ImGuiCol_HeaderActive] = ImVec4(0.26f, 0.31f, 0.39f, 1);
  c[ImGuiCol_SliderGrab] = color(ink::kAccent, 0.85f), c[ImGuiCol_SliderGrabActive] = color(ink::kAccent);
  c[ImGuiCol_CheckMark] = color(ink::kAccent);
  c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = ImVec4(0.16f, 0.18f, 0.215f, 1);
  c[ImGuiCol_Separator] = color(ink::kLine);
  c[ImGuiCol_ScrollbarBg] = ImVec4(0, 0, 0, 0);
  c[ImGuiCol_TextSelectedBg] = color(ink::kAccent, 0.4f);
}

void colored_text(ImU32 c, const char* text) { ImGui::TextColored(color(c), "%s", text); }

void begin_panel(const char* name, ImVec2 at, ImVec2 size, ImGuiWindowFlags more) {
  ImGui::SetNextWindowPos(at);
  ImGui::SetNextWindowSize(size);
  ImGui::Begin(name, nullptr, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings | more);
}

void begin_dialog(const char* name, bool& open, ImVec2 at, ImVec2 pivot, ImGuiWindowFlags more) {
  ImGui::SetNextWindowPos(at, ImGuiCond_Always, pivot);
  ImGui::SetNextWindowFocus();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6);
  ImGui::Begin(name, &open,
               ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoSavedSettings | more);
}

void end_dialog() {
  ImGui::End();
  ImGui::PopStyleVar();
}

}  // namespace feder::view
