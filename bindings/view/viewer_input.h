// Mouse and keys of the viewer, wherever no panel wants them.
#pragma once
#include "view/desk.h"
#include "view/window.h"

namespace feder::view {

class ViewerInput {
 public:
  // Once per picture, after ImGui has taken its input.
  void take(Desk& desk, const Window& window);

 private:
  enum class Drag { none, waiting, turn, shift, pull };

  void keys(Desk& desk, const Window& window);
  void escape(Desk& desk);
  void shoot(Desk& desk);
  void mouse(Desk& desk);
  void press(Desk& desk);
  void drag(Desk& desk, float dx, float dy);
  void release(Desk& desk);
  Ray ray(const Desk& desk, float x, float y) const;
  Vec3 on_plane(const Desk& desk, float x, float y) const;

  Target target_;
  float scale_ = 1;
  Drag drag_ = Drag::none;
  std::optional<Pick> pressed_;   // movable thing under the mouse when it went down
  std::uint64_t pressed_in_ = 0;  // generation
  Vec3 plane_point_ = Vec3::Zero(), plane_normal_ = Vec3(0, 0, 1);
  float travelled_ = 0;  // mouse units since the press
};

}  // namespace feder::view
