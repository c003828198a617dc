// Lua in the running scene, and what the scene prints.
#include <algorithm>
#include <cstdio>

#include "view/panel_layout.h"
#include "view/theme.h"
#include "view/window.h"

namespace feder::view {
namespace {

ImU32 line_color(ConsoleLine::Kind kind) {
  switch (kind) {
    case ConsoleLine::input: return ink::kAccent;
    case ConsoleLine::error: return ink::kBad;
    case ConsoleLine::print: return ink::kDim;
    default: return ink::kText;
  }
}

// Tab: what all candidates have in common, and their list where there are several.
void complete_input(Console& c, ImGuiInputTextCallbackData* data) {
  if (!c.complete) return;
  const std::string line(data->Buf, static_cast<std::size_t>(data->CursorPos));
  const lua::Completion found = c.complete(line);
  if (found.words.empty()) return;
  data->DeleteChars(static_cast<int>(found.from), data->CursorPos - static_cast<int>(found.from));
  data->InsertChars(static_cast<int>(found.from), found.common().c_str());
  if (found.words.size() == 1) return;
  std::string list;
  for (const std::string& word : found.words) list += (list.empty() ? "" : "  ") + word;
  c.add(ConsoleLine::print, list);
}

int on_key(ImGuiInputTextCallbackData* data) {
  Console& c = *static_cast<Console*>(data->UserData);
  if (data->EventFlag == ImGuiInputTextFlags_CallbackCompletion) return complete_input(c, data), 0;
  const int count = static_cast<int>(c.past.size());
  if (count == 0) return 0;
  if (data->EventKey == ImGuiKey_UpArrow) c.past_at = c.past_at < 0 ? count - 1 : std::max(0, c.past_at - 1);
  if (data->EventKey == ImGuiKey_DownArrow) c.past_at = c.past_at < 0 ? -1 : c.past_at + 1;
  if (c.past_at >= count) c.past_at = -1;
  data->DeleteChars(0, data->BufTextLen);
  if (c.past_at >= 0) data->InsertChars(0, c.past[static_cast<std::size_t>(c.past_at)].c_str());
  return 0;
}

void run_line(PanelLayout& layout, const std::string& text) {
  Console& c = layout.console;
  c.add(ConsoleLine::input, "> " + text);
  if (c.past.empty() || c.past.back() != text) c.past.push_back(text);
  c.past_at = -1;
  layout.live.run_text(
      text, [&c](const std::string& said, bool good) { c.add(good ? ConsoleLine::output : ConsoleLine::error, said); });
}

void draw_lines(Console& c, float height) {
  ImGui::BeginChild("lines", {0, height});
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(c.lines.size()));
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const ConsoleLine& line = c.lines[static_cast<std::size_t>(i)];
      ImGui::PushStyleColor(ImGuiCol_Text, line_color(line.kind));
      ImGui::TextUnformatted(line.text.c_str());
      ImGui::PopStyleColor();
    }
  if (c.scroll) ImGui::SetScrollHereY(1);
  c.scroll = false;
  ImGui::EndChild();
}

}  // namespace

void draw_console(PanelLayout& layout, const PanelSizes& sizes) {
  if (sizes.console == 0) return;
  Console& c = layout.console;
  begin_panel("console", {sizes.left, sizes.height - sizes.bottom - sizes.console},
              {sizes.width - sizes.left - sizes.right, sizes.console}, ImGuiWindowFlags_NoDecoration);
  if (code_font()) ImGui::PushFont(code_font());
  if (c.lines.empty())
    c.add(ConsoleLine::print,
          "Lua in the scene: world, scene and feder are there. Try  world:find(\"crate1\"):position()");
  draw_lines(c, sizes.console - ImGui::GetFrameHeight() - 28);
  char text[1000];
  std::snprintf(text, sizeof text, "%s", c.input.c_str());
  ImGui::SetNextItemWidth(-1);
  if (c.focus) ImGui::SetKeyboardFocusHere();
  c.focus = false;
  const bool entered =
      ImGui::InputTextWithHint("##input", "Lua", text, sizeof text,
                               ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_CallbackHistory |
                                   ImGuiInputTextFlags_CallbackCompletion,
                               &on_key, &c);
  c.input = text;
  if (entered) {
    if (!c.input.empty()) run_line(layout, c.input);
    c.input.clear();
    c.focus = true;
  }
  if (code_font()) ImGui::PopFont();
  ImGui::End();
}

}  // namespace feder::view
