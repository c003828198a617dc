// The bar below: run, step, speed, and the timeline with its marks.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "view/panel_layout.h"
#include "view/theme.h"

namespace feder::view {
namespace {

enum class Icon { play, pause, forward, back, start, present };

bool icon_button(Icon icon, const char* help, bool wide = false) {
  ImGui::PushID(static_cast<int>(icon));
  const ImVec2 size(wide ? 46.0f : 34.0f, 28.0f);
  const bool clicked = ImGui::Button("##icon", size);
  ImGui::PopID();
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", help);
  ImDrawList* d = ImGui::GetWindowDrawList();
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  const ImVec2 m((low.x + high.x) / 2, (low.y + high.y) / 2);
  const auto triangle = [&](float x, float side) {  // pointing to +x or -x
    d->AddTriangleFilled({x, m.y - 6}, {x, m.y + 6}, {x + side * 9, m.y}, ink::kText);
  };
  const auto stroke = [&](float x) { d->AddRectFilled({x - 1.5f, m.y - 6}, {x + 1.5f, m.y + 6}, ink::kText); };
  switch (icon) {
    case Icon::play: triangle(m.x - 4, 1); break;
    case Icon::pause: stroke(m.x - 4), stroke(m.x + 4); break;
    case Icon::forward: stroke(m.x - 6), triangle(m.x - 2, 1); break;
    case Icon::back: stroke(m.x + 6), triangle(m.x + 2, -1); break;
    case Icon::start: stroke(m.x - 8), triangle(m.x + 2, -1), triangle(m.x + 10, -1); break;
    case Icon::present: stroke(m.x + 8), triangle(m.x - 2, 1), triangle(m.x - 10, 1); break;
  }
  ImGui::SameLine(0, 4);
  return clicked;
}

ImU32 mark_color(const std::string& kind) {
  if (kind == "error") return ink::kBad;
  if (kind == "warning" || kind.ends_with("break") || kind == "tear" || kind == "fracture") return ink::kWarn;
  if (kind == "hand") return ink::kAccent;
  if (kind == "sleep") return IM_COL32(120, 130, 200, 255);
  if (kind == "sensor_enter") return ink::kGood;
  return IM_COL32(120, 128, 140, 255);
}

void draw_buttons(PanelLayout& layout) {
  LiveScene& live = layout.live;
  if (icon_button(Icon::start, "start over (R)")) live.restart();
  if (icon_button(Icon::back, "one step back (left arrow)")) live.step_back();
  const bool running = !live.paused();
  if (icon_button(running ? Icon::pause : Icon::play, running ? "pause (space)" : "run (space)", true))
    live.set_paused(running);
  if (icon_button(Icon::forward, "one step (right arrow)")) live.step_forward();
  ImGui::BeginDisabled(!live.in_past());
  if (icon_button(Icon::present, "to the present (end)")) live.to_present();
  ImGui::EndDisabled();
  ImGui::SameLine(0, 12);
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 1);
  float speed = static_cast<float>(live.speed());
  ImGui::SetNextItemWidth(130);
  if (ImGui::SliderFloat("##speed", &speed, 0.05f, 8.0f, "speed %.2fx", ImGuiSliderFlags_Logarithmic))
    live.set_speed(speed);
  if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) live.set_speed(1);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("simulated seconds per second (+ and -; right click: 1x)");
}

const Mark* mark_near(const PanelLayout& layout, double from, double to, float low, float width) {
  const Mark* best = nullptr;
  float nearest = 5;
  for (const Mark& m : layout.live.history().marks()) {
    const float x = low + width * static_cast<float>((m.time - from) / (to - from));
    const float away = std::abs(ImGui::GetIO().MousePos.x - x);
    if (away < nearest) nearest = away, best = &m;
  }
  return best;
}

void draw_timeline(PanelLayout& layout) {
  LiveScene& live = layout.live;
  const History& h = live.history();
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const float width = std::max(60.0f, ImGui::GetContentRegionAvail().x), height = 28;
  ImGui::InvisibleButton("timeline", {width, height});
  ImDrawList* d = ImGui::GetWindowDrawList();
  const ImVec2 high(low.x + width, low.y + height);
  d->AddRectFilled(low, high, ink::kWell, 4);
  if (h.empty()) return;
  // a world of its own second at least, so that the first steps do not jump
  const double from = h.first().time;
  const double present = static_cast<double>(live.world_step()) * live.world().desc().dt;
  const double to = std::max(present, from + 1);
  const auto at = [&](double time) { return low.x + width * static_cast<float>((time - from) / (to - from)); };
  const double shown = live.world().time();
  d->AddRectFilled(low, {at(shown), high.y}, IM_COL32(60, 92, 128, 150), 4);
  for (const Mark& m : h.marks())
    d->AddRectFilled({at(m.time) - 1, low.y + (m.kind == "hit" || m.kind == "sleep" ? 20.0f : 16.0f)},
                     {at(m.time) + 1, high.y - 3}, mark_color(m.kind));
  if (live.catching_up())
    d->AddRectFilled({low.x, high.y - 4}, {low.x + width * static_cast<float>(live.catch_up_share()), high.y},
                     ink::kAccent, 2);
  d->AddRectFilled({at(shown) - 1.5f, low.y}, {at(shown) + 1.5f, high.y}, live.in_past() ? ink::kWarn : ink::kText);
  d->AddText({low.x + 6, low.y + 2}, ink::kDim, fmt::format("{:.2f} s", live.clock_of(from)).c_str());
  if (ImGui::IsItemActive()) {
    const double share = std::clamp((ImGui::GetIO().MousePos.x - low.x) / width, 0.0f, 1.0f);
    live.set_paused(true);
    live.scrub(static_cast<std::uint64_t>(std::llround((from + share * (to - from)) / live.world().desc().dt)));
  } else if (ImGui::IsItemHovered()) {
    const double time = from + (ImGui::GetIO().MousePos.x - low.x) / width * (to - from);
    if (const Mark* m = mark_near(layout, from, to, low.x, width))
      ImGui::SetTooltip("%.3f s, step %llu: %s %s%s", live.clock_of(m->time), static_cast<unsigned long long>(m->step),
                        m->kind.c_str(), m->label.c_str(),
                        m->count > 1 ? (" and " + std::to_string(m->count - 1) + " more").c_str() : "");
    else
      ImGui::SetTooltip("%.3f s (drag to look at the past)", live.clock_of(time));
  }
}

}  // namespace

void draw_transport(PanelLayout& layout, const PanelSizes& sizes) {
  begin_panel("transport", {0, sizes.height - sizes.bottom}, {sizes.width, sizes.bottom}, kBar);
  if (layout.live.has_scene()) {
    LiveScene& live = layout.live;
    ImGui::SetCursorPosY((sizes.bottom - 28) / 2);
    draw_buttons(layout);
    ImGui::SameLine(0, 14);
    ImGui::BeginGroup();
    const float y = (sizes.bottom - 36) / 2;
    ImGui::SetCursorPosY(y);
    ImGui::TextUnformatted(fmt::format("{:.3f} s", live.shown_time()).c_str());
    ImGui::SetCursorPosY(y + 18);
    const char* state = live.rewriting()     ? "living again"
                        : live.catching_up() ? "catching up"
                        : live.in_past()     ? "past"
                        : live.paused()      ? "paused"
                                             : "running";
    colored_text(live.in_past() || live.catching_up() ? ink::kWarn : ink::kDim,
                 fmt::format("{}, step {}", state, live.shown_step()).c_str());
    ImGui::EndGroup();
    ImGui::SameLine(620);
    ImGui::SetCursorPosY((sizes.bottom - 28) / 2);
    draw_timeline(layout);
  } else {
    ImGui::TextDisabled("no scene");
  }
  ImGui::End();
}

void draw_top_bar(PanelLayout& layout, const PanelSizes& sizes) {
  begin_panel("top", {0, 0}, {sizes.width, sizes.top}, kBar);
  LiveScene& live = layout.live;
  ImGui::SetCursorPosY(6);
  const std::string name = live.has_scene() ? live.title() : live.file().filename().string();
  if (ImGui::Button((name + "  ##scene").c_str())) layout.show_picker = true;
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s\nclick for other scenes (/)", live.file().string().c_str());
  ImGui::SameLine(0, 14);
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("on save");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(150);
  int mode = static_cast<int>(live.reload_mode());
  if (ImGui::Combo("##mode", &mode, "catch up\0start over\0keep objects\0"))
    live.set_reload_mode(static_cast<ReloadMode>(mode));
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip(
        "catch up: made anew and run to the same time\nstart over: made anew\n"
        "keep objects: those with the same name stay where they are");
  const std::string text = fmt::format("{:.2f} ms/step   {}{:.0f} fps   draw {:.1f} ms", live.step_seconds() * 1000,
                                       live.slowness() < 0.9 ? "slower than real time   " : "",
                                       1000 / std::max(layout.frame_ms, 1e-3), layout.cpu_ms);
  const float text_width = ImGui::CalcTextSize(text.c_str()).x;
  const char* const buttons[] = {"console", "panels", "help"};
  float right = text_width + 24;
  for (const char* b : buttons) right += ImGui::CalcTextSize(b).x + 24;
  ImGui::SameLine(std::max(ImGui::GetCursorPosX() + 420, sizes.width - right - 12));
  colored_text(live.slowness() < 0.9 ? ink::kWarn : ink::kDim, text.c_str());
  ImGui::SameLine(sizes.width - (right - text_width - 24) - 8);
  if (ImGui::Button("console")) layout.show_console = !layout.show_console, layout.console.focus = true;
  ImGui::SameLine();
  if (ImGui::Button("panels")) layout.show_left = layout.show_right = !(layout.show_left || layout.show_right);
  ImGui::SameLine();
  if (ImGui::Button("help")) layout.show_help = !layout.show_help;
  ImGui::End();
}

}  // namespace feder::view
