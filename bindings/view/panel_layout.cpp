#include "view/panel_layout.h"

#include <algorithm>

namespace feder::view {

void Console::add(ConsoleLine::Kind kind, const std::string& text) {
  std::size_t start = 0;
  while (start <= text.size()) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    if (end < text.size() || end > start) lines.push_back({kind, text.substr(start, end - start)});
    start = end + 1;
  }
  if (lines.size() > 500) lines.erase(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(lines.size() - 500));
  scroll = true;
}

void PanelLayout::select(const std::optional<Pick>& pick) {
  selected = pick;
  selected_in = live.generation();
  selected_name = pick ? live.world().objects().name(pick->object) : "";
  if (!pick) follow = false;
}

bool PanelLayout::has_selection() {
  if (!selected || !live.has_scene()) return false;
  World& w = live.world();
  if (selected_in != live.generation()) {
    const ObjectId same = selected_name.empty() ? ObjectId{} : w.objects().find(selected_name);
    if (!same) {
      // it may come again while the scene catches up
      if (live.catching_up() && !selected_name.empty()) return false;
      select({});
      return false;
    }
    selected->object = same;
    selected_in = live.generation();
  }
  if (!w.objects().alive(selected->object)) {
    // gone in the past that is shown, or for good
    if (!live.in_past()) select({});
    return false;
  }
  const ObjectView* view = view_of(w, selected->object);
  if (selected->point != kNone && !(view && view->has_point(w, selected->object, selected->point)))
    selected->point = kNone;
  return true;
}

static void next_level(bool& on, int& level, bool there_is_more) {
  const bool deeper = on && there_is_more && level < kMaxVolumeLevel;
  level = deeper ? level + 1 : 0;
  on = deeper || !on;
}

void next_volumes(PanelLayout& layout) {
  next_level(layout.toggles.volumes, layout.toggles.volume_level, layout.deeper_volumes);
}
void next_cells(PanelLayout& layout) {
  next_level(layout.toggles.cells, layout.toggles.cell_level, layout.deeper_cells);
}

PanelSizes panel_sizes(const PanelLayout& layout, float width, float height) {
  PanelSizes sizes;
  sizes.width = width, sizes.height = height;
  if (!layout.show_ui) sizes.top = sizes.bottom = 0;
  if (layout.show_ui && layout.show_left) sizes.left = std::min(270.0f, width * 0.3f);
  if (layout.show_ui && layout.show_right) sizes.right = std::min(300.0f, width * 0.3f);
  if (layout.show_ui && layout.show_console) sizes.console = std::min(190.0f, height * 0.3f);
  return sizes;
}

}  // namespace feder::view
