// Colours, sizes and windows of the panels.
#pragma once
#include <imgui.h>

namespace feder::view {

void apply_theme();
inline constexpr ImGuiWindowFlags kBar = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoBringToFrontOnFocus;
inline constexpr ImGuiWindowFlags kSidePanel =
    ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoBringToFrontOnFocus;
void colored_text(ImU32 color, const char* text);

// A panel in its place; ImGui::End closes it.
void begin_panel(const char* name, ImVec2 at, ImVec2 size, ImGuiWindowFlags more);
// A window over everything with a cross that sets `open`; `pivot` of its size stands at `at`.
void begin_dialog(const char* name, bool& open, ImVec2 at, ImVec2 pivot, ImGuiWindowFlags more = 0);
void end_dialog();

namespace ink {
inline constexpr ImU32 kText = IM_COL32(222, 226, 232, 255);
inline constexpr ImU32 kDim = IM_COL32(146, 154, 166, 255);
inline constexpr ImU32 kAccent = IM_COL32(104, 168, 232, 255);
inline constexpr ImU32 kGood = IM_COL32(126, 200, 140, 255);
inline constexpr ImU32 kWarn = IM_COL32(236, 190, 96, 255);
inline constexpr ImU32 kBad = IM_COL32(240, 112, 104, 255);
inline constexpr ImU32 kPanel = IM_COL32(27, 30, 36, 252);
inline constexpr ImU32 kWell = IM_COL32(18, 20, 25, 255);
inline constexpr ImU32 kLine = IM_COL32(58, 64, 74, 255);
}  // namespace ink

}  // namespace feder::view
