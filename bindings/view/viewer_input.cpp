#include "view/viewer_input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

namespace feder::view {
namespace {

Vec3 to_vec(const float p[3]) {
  return Vec3(static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2]));
}

void pan(Camera& camera, float dx, float dy, float height) {
  float right[3], up[3], back[3];
  camera.axes(right, up, back);
  const float size = 2 * camera.distance * std::tan(camera.fov / 2) / height;
  for (int k = 0; k < 3; ++k) camera.target[k] += size * (dy * up[k] - dx * right[k]);
}

}  // namespace

void ViewerInput::take(Desk& desk, const Window& window) {
  target_ = window.target(), scale_ = window.pixels_per_unit();
  if (window.pressed(GLFW_KEY_ESCAPE)) escape(desk);
  if (!ImGui::GetIO().WantTextInput) keys(desk, window);
  mouse(desk);
}

void ViewerInput::escape(Desk& desk) {
  if (desk.show_help || desk.show_picker)
    desk.show_help = desk.show_picker = false;
  else if (desk.live.catching_up())
    desk.live.stop_catching_up();
  else if (!ImGui::GetIO().WantTextInput && desk.live.has_scene())
    desk.select({});
}

void ViewerInput::keys(Desk& desk, const Window& window) {
  const auto hit = [&](int key, bool repeat = false) { return window.pressed(key, repeat); };
  LiveScene& live = desk.live;
  if (hit(GLFW_KEY_F1)) desk.show_help = !desk.show_help;
  if (hit(GLFW_KEY_F2)) desk.show_left = !desk.show_left;
  if (hit(GLFW_KEY_F3)) desk.show_right = !desk.show_right;
  if (hit(GLFW_KEY_F12)) desk.save_picture = true;
  if (hit(GLFW_KEY_TAB)) desk.show_ui = !desk.show_ui;
  if (hit(GLFW_KEY_GRAVE_ACCENT)) desk.show_console = !desk.show_console, desk.console.focus = desk.show_console;
  if (hit(GLFW_KEY_SLASH)) desk.show_picker = true;
  if (!live.has_scene()) return;
  if (hit(GLFW_KEY_SPACE)) live.set_paused(!live.paused());
  if (hit(GLFW_KEY_RIGHT, true)) live.step_forward();
  if (hit(GLFW_KEY_LEFT, true)) live.step_back();
  if (hit(GLFW_KEY_END)) live.to_present();
  if (hit(GLFW_KEY_R)) live.restart();
  if (hit(GLFW_KEY_F5)) live.reload();
  if (hit(GLFW_KEY_EQUAL) || hit(GLFW_KEY_KP_ADD)) live.set_speed(live.speed() * 2);
  if (hit(GLFW_KEY_MINUS) || hit(GLFW_KEY_KP_SUBTRACT)) live.set_speed(live.speed() / 2);
  if (hit(GLFW_KEY_F)) desk.fit = true;
  if (hit(GLFW_KEY_T)) desk.follow = desk.has_selection() && !desk.follow;
  if (hit(GLFW_KEY_P)) {
    if (live.held())
      live.let_go(true), drag_ = Drag::none;
    else if (desk.has_selection())
      live.act(pin_command(live.world(), *desk.selected), "pin");
  }
  if (hit(GLFW_KEY_B)) shoot(desk);
}

void ViewerInput::shoot(Desk& desk) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  const Real radius = static_cast<Real>(std::clamp(desk.camera.distance * 0.02f, 0.02f, 2.0f));
  const Ray from = ray(desk, at.x, at.y);
  desk.live.run_text(shot_text(desk.live.world(), from, radius, static_cast<Real>(desk.shot_speed), ++desk.shots),
                     [&desk](const std::string& said, bool good) {
                       if (!good) desk.console.add(ConsoleLine::error, said);
                     });
}

Ray ViewerInput::ray(const Desk& desk, float x, float y) const {
  float origin[3], direction[3];
  desk.camera.ray(x * scale_, y * scale_, target_.width, target_.height, origin, direction);
  return {to_vec(origin), to_vec(direction)};
}

Vec3 ViewerInput::on_plane(const Desk& desk, float x, float y) const {
  const Ray r = ray(desk, x, y);
  const Real slope = dot(r.direction, plane_normal_);
  if (std::abs(slope) < Real(1e-4)) return plane_point_;
  return r.origin + r.direction * (dot(plane_point_ - r.origin, plane_normal_) / slope);
}

void ViewerInput::mouse(Desk& desk) {
  const ImGuiIO& io = ImGui::GetIO();
  if (!io.WantCaptureMouse && io.MouseWheel != 0)
    desk.camera.distance *= std::pow(0.88f, io.MouseWheel), desk.auto_frame = false;
  desk.camera.distance = std::clamp(desk.camera.distance, 0.01f, 1e5f);
  if (drag_ == Drag::none) {
    // the way of this picture was made before the press
    if (io.WantCaptureMouse) return;
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left))
      press(desk);
    else if (ImGui::IsMouseClicked(ImGuiMouseButton_Right) || ImGui::IsMouseClicked(ImGuiMouseButton_Middle))
      drag_ = Drag::shift;
    return;
  }
  desk.auto_frame = false;
  const bool down = drag_ == Drag::shift ? io.MouseDown[1] || io.MouseDown[2] : io.MouseDown[0];
  if (down)
    drag(desk, io.MouseDelta.x, io.MouseDelta.y);
  else
    release(desk);
}

void ViewerInput::press(Desk& desk) {
  const ImGuiIO& io = ImGui::GetIO();
  travelled_ = 0;
  drag_ = Drag::turn;
  pressed_.reset();
  if (!desk.live.has_scene() || io.KeyShift) return;
  const Real slack = static_cast<Real>(12 * scale_ * desk.camera.fov / static_cast<float>(target_.height));
  const auto pick = view::pick(desk.live.world(), ray(desk, io.MousePos.x, io.MousePos.y), slack);
  pressed_ = pick;
  if (!pick || !pick->movable) return;
  pressed_in_ = desk.live.generation();
  float right[3], up[3], back[3];
  desk.camera.axes(right, up, back);
  plane_point_ = pick->position;
  plane_normal_ = desk.live.world().desc().dimension == 2 ? Vec3(0, 0, 1) : to_vec(back);
  drag_ = Drag::waiting;
}

void ViewerInput::drag(Desk& desk, float dx, float dy) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  travelled_ += std::abs(dx) + std::abs(dy);
  switch (drag_) {
    case Drag::turn:
      desk.camera.yaw -= dx * 0.008f;
      desk.camera.pitch = std::clamp(desk.camera.pitch + dy * 0.008f, -1.55f, 1.55f);
      break;
    case Drag::shift: pan(desk.camera, dx, dy, static_cast<float>(target_.height) / scale_); break;
    case Drag::waiting:
      // in the past a grip takes hold once the scene has been lived again
      if (travelled_ < 4 || desk.live.catching_up()) break;
      if (!desk.live.world().objects().alive(pressed_->object)) {
        drag_ = Drag::turn;
        break;
      }
      desk.live.hold(grip(desk.live.world(), *pressed_));
      if (desk.live.held()) drag_ = Drag::pull;
      break;
    case Drag::pull:
      desk.live.move_hold(on_plane(desk, at.x, at.y));
      if (!desk.live.held()) drag_ = Drag::none;
      break;
    default: break;
  }
}

void ViewerInput::release(Desk& desk) {
  if (drag_ == Drag::pull) desk.live.let_go(false);
  // a press without a way is a click
  const bool clicked = travelled_ < 4 && (drag_ == Drag::waiting || drag_ == Drag::turn);
  if (desk.live.has_scene() && (clicked || drag_ == Drag::pull)) {
    if (pressed_ && !desk.live.world().objects().alive(pressed_->object)) pressed_.reset();
    desk.select(pressed_);
  }
  drag_ = Drag::none;
}

}  // namespace feder::view
