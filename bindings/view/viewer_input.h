// Mouse and keys of the viewer, wherever no panel wants them.
#pragma once
#include "view/panel_layout.h"
#include "view/window.h"

namespace feder::view {

class ViewerInput {
 public:
  // Once per picture, after ImGui has taken its input.
  void take(PanelLayout& layout, const Window& window);

 private:
  enum class Drag { none, waiting, turn, shift, pull };

  void keys(PanelLayout& layout, const Window& window);
  void escape(PanelLayout& layout);
  void shoot(PanelLayout& layout);
  void mouse(PanelLayout& layout);
  void press(PanelLayout& layout);
  void drag(PanelLayout& layout, float dx, float dy);
  void release(PanelLayout& layout);
  Ray ray(const PanelLayout& layout, float x, float y) const;
  Vec3 on_plane(const PanelLayout& layout, float x, float y) const;

  Target target_;
  float scale_ = 1;
  Drag drag_ = Drag::none;
  std::optional<Pick> pressed_;  // movable thing under the mouse when it went down
  Vec3 plane_point_ = Vec3::Zero(), plane_normal_ = Vec3(0, 0, 1);
  float travelled_ = 0;  // mouse units since the press
};

}  // namespace feder::view
