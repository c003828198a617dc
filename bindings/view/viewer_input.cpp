#include "view/viewer_input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace feder::view {
namespace {

void pan(Camera& camera, float dx, float dy, float height) {
  const auto [right, up, back] = camera.axes();
  const float size = 2 * camera.distance * std::tan(camera.fov / 2) / height;
  camera.target = camera.target + size * (dy * up - dx * right);
}

}  // namespace

void ViewerInput::take(PanelLayout& layout, const Window& window) {
  target_ = window.target(), scale_ = window.pixels_per_unit();
  if (window.pressed(GLFW_KEY_ESCAPE)) escape(layout);
  if (!ImGui::GetIO().WantTextInput) keys(layout, window);
  mouse(layout);
}

void ViewerInput::escape(PanelLayout& layout) {
  if (layout.show_help || layout.show_picker)
    layout.show_help = layout.show_picker = false;
  else if (layout.live.catching_up())
    layout.live.stop_catching_up();
  else if (!ImGui::GetIO().WantTextInput && layout.live.has_scene())
    layout.select({});
}

void ViewerInput::keys(PanelLayout& layout, const Window& window) {
  const auto hit = [&](int key, bool repeat = false) { return window.pressed(key, repeat); };
  LiveScene& live = layout.live;
  if (hit(GLFW_KEY_F1)) layout.show_help = !layout.show_help;
  if (hit(GLFW_KEY_F2)) layout.show_left = !layout.show_left;
  if (hit(GLFW_KEY_F3)) layout.show_right = !layout.show_right;
  if (hit(GLFW_KEY_F12)) layout.save_picture = true;
  if (hit(GLFW_KEY_TAB)) layout.show_ui = !layout.show_ui;
  if (hit(GLFW_KEY_GRAVE_ACCENT))
    layout.show_console = !layout.show_console, layout.console.focus = layout.show_console;
  if (hit(GLFW_KEY_SLASH)) layout.show_picker = true;
  if (!live.has_scene()) return;
  if (hit(GLFW_KEY_SPACE)) live.set_paused(!live.paused());
  if (hit(GLFW_KEY_RIGHT, true)) live.step_forward();
  if (hit(GLFW_KEY_LEFT, true)) live.step_back();
  if (hit(GLFW_KEY_END)) live.to_present();
  if (hit(GLFW_KEY_R)) live.restart();
  if (hit(GLFW_KEY_F5)) live.reload();
  if (hit(GLFW_KEY_EQUAL) || hit(GLFW_KEY_KP_ADD)) live.set_speed(live.speed() * 2);
  if (hit(GLFW_KEY_MINUS) || hit(GLFW_KEY_KP_SUBTRACT)) live.set_speed(live.speed() / 2);
  if (hit(GLFW_KEY_F)) layout.fit = true;
  if (hit(GLFW_KEY_V)) next_volumes(layout);
  if (hit(GLFW_KEY_C)) next_cells(layout);
  if (hit(GLFW_KEY_T)) layout.follow = layout.has_selection() && !layout.follow;
  if (hit(GLFW_KEY_P)) {
    if (live.held())
      live.let_go(true), drag_ = Drag::none;
    else if (layout.has_selection())
      live.act(pin_command(live.world(), *layout.selected), "pin");
  }
  if (hit(GLFW_KEY_B)) shoot(layout);
}

void ViewerInput::shoot(PanelLayout& layout) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  const Real radius = static_cast<Real>(std::clamp(layout.camera.distance * 0.02f, 0.02f, 2.0f));
  const Ray from = ray(layout, at.x, at.y);
  layout.live.run_text(
      shot_text(layout.live.world(), from, radius, static_cast<Real>(layout.shot_speed), ++layout.shots),
      [&layout](const std::string& said, bool good) {
        if (!good) layout.console.add(ConsoleLine::error, said);
      });
}

Ray ViewerInput::ray(const PanelLayout& layout, float x, float y) const {
  const auto [origin, direction] = layout.camera.ray(x * scale_, y * scale_, target_.width, target_.height);
  return {to_vec3(origin), to_vec3(direction)};
}

Vec3 ViewerInput::on_plane(const PanelLayout& layout, float x, float y) const {
  const Ray r = ray(layout, x, y);
  const Real slope = dot(r.direction, plane_normal_);
  if (std::abs(slope) < Real(1e-4)) return plane_point_;
  return r.origin + r.direction * (dot(plane_point_ - r.origin, plane_normal_) / slope);
}

void ViewerInput::mouse(PanelLayout& layout) {
  const ImGuiIO& io = ImGui::GetIO();
  if (!io.WantCaptureMouse && io.MouseWheel != 0)
    layout.camera.distance *= std::pow(0.88f, io.MouseWheel), layout.auto_frame = false;
  layout.camera.distance = std::clamp(layout.camera.distance, 0.01f, 1e5f);
  if (drag_ == Drag::none) {
    // the way of this picture was made before the press
    if (io.WantCaptureMouse) return;
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left))
      press(layout);
    else if (ImGui::IsMouseClicked(ImGuiMouseButton_Right) || ImGui::IsMouseClicked(ImGuiMouseButton_Middle))
      drag_ = Drag::shift;
    return;
  }
  layout.auto_frame = false;
  const bool down = drag_ == Drag::shift ? io.MouseDown[1] || io.MouseDown[2] : io.MouseDown[0];
  if (down)
    drag(layout, io.MouseDelta.x, io.MouseDelta.y);
  else
    release(layout);
}

void ViewerInput::press(PanelLayout& layout) {
  const ImGuiIO& io = ImGui::GetIO();
  travelled_ = 0;
  drag_ = Drag::turn;
  pressed_.reset();
  if (!layout.live.has_scene() || io.KeyShift) return;
  const Real slack = static_cast<Real>(12 * scale_ * layout.camera.fov / static_cast<float>(target_.height));
  const auto pick = view::pick(layout.live.world(), ray(layout, io.MousePos.x, io.MousePos.y), slack);
  pressed_ = pick;
  if (!pick || !pick->movable) return;
  plane_point_ = pick->position;
  plane_normal_ = layout.live.world().desc().dimension == 2 ? Vec3(0, 0, 1) : to_vec3(layout.camera.axes().back);
  drag_ = Drag::waiting;
}

void ViewerInput::drag(PanelLayout& layout, float dx, float dy) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  travelled_ += std::abs(dx) + std::abs(dy);
  switch (drag_) {
    case Drag::turn:
      layout.camera.yaw -= dx * 0.008f;
      layout.camera.pitch = std::clamp(layout.camera.pitch + dy * 0.008f, -1.55f, 1.55f);
      break;
    case Drag::shift: pan(layout.camera, dx, dy, static_cast<float>(target_.height) / scale_); break;
    case Drag::waiting:
      // in the past a grip takes hold once the scene has been lived again
      if (travelled_ < 4 || layout.live.catching_up()) break;
      if (!layout.live.world().objects().alive(pressed_->object)) {
        drag_ = Drag::turn;
        break;
      }
      layout.live.hold(grip(layout.live.world(), *pressed_));
      if (layout.live.held()) drag_ = Drag::pull;
      break;
    case Drag::pull:
      layout.live.move_hold(on_plane(layout, at.x, at.y));
      if (!layout.live.held()) drag_ = Drag::none;
      break;
    default: break;
  }
}

void ViewerInput::release(PanelLayout& layout) {
  if (drag_ == Drag::pull) layout.live.let_go(false);
  // a press without a way is a click
  const bool clicked = travelled_ < 4 && (drag_ == Drag::waiting || drag_ == Drag::turn);
  if (layout.live.has_scene() && (clicked || drag_ == Drag::pull)) {
    if (pressed_ && !layout.live.world().objects().alive(pressed_->object)) pressed_.reset();
    layout.select(pressed_);
  }
  drag_ = Drag::none;
}

}  // namespace feder::view
