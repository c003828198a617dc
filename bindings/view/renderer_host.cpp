#include "view/renderer_host.h"

#include <charconv>
#include <cmath>

#include "feder/error.h"

namespace feder::view {
namespace {

// Numbers with commas between them; false when something else is there.
bool read_numbers(const std::string& text, std::vector<float>& out) {
  const char *at = text.data(), *end = text.data() + text.size();
  while (at < end) {
    while (at < end && *at == ' ') ++at;
    double x = 0;
    const auto [next, error] = std::from_chars(at, end, x);
    if (error != std::errc{} || !std::isfinite(x)) return false;
    out.push_back(static_cast<float>(x));
    at = next;
    if (at < end && *at++ != ',') return false;
    if (at == end && text.back() == ',') return false;
  }
  return !out.empty();
}

}  // namespace

CameraWish read_camera(const std::string& text) {
  CameraWish wish;
  std::vector<float> n;
  const float degree = 0.01745329252f;
  const bool good = read_numbers(text, n);
  if (good && (n.size() == 2 || n.size() == 3) && std::abs(n[1]) < 90 && (n.size() == 2 || n[2] > 0)) {
    wish.has_angles = true, wish.yaw = n[0] * degree, wish.pitch = n[1] * degree;
    if (n.size() == 3) wish.distance = n[2];
  } else if (good && n.size() == 6 && (n[0] != n[3] || n[1] != n[4] || n[2] != n[5])) {
    wish.has_places = true;
    wish.eye = {n[0], n[1], n[2]}, wish.target = {n[3], n[4], n[5]};
  } else {
    throw SceneError(
        "expected yaw,pitch[,distance] in degrees and metres (30,20,12; pitch below 90) or the places of eye and "
        "target (x,y,z,tx,ty,tz), got '" +
        text + "'");
  }
  return wish;
}

void read_size(const std::string& text, int& width, int& height) {
  const std::size_t x = text.find('x');
  const auto whole = [](std::string_view part, int& out) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), out);
    return error == std::errc{} && end == part.data() + part.size() && out >= 1 && out <= 16384;
  };
  if (x == std::string::npos || !whole(std::string_view(text).substr(0, x), width) ||
      !whole(std::string_view(text).substr(x + 1), height))
    throw SceneError("expected a size in pixels such as 1280x720, got '" + text + "'");
}

void apply_angles(const lua::SceneCamera& scene, bool planar, Camera& camera) {
  if (planar) camera.yaw = camera.pitch = 0, camera.fov = kPlanarFov;
  if (scene.has_yaw) camera.yaw = static_cast<float>(scene.yaw);
  if (scene.has_pitch) camera.pitch = static_cast<float>(scene.pitch);
}

void apply_target(const lua::SceneCamera& scene, Camera& camera) {
  if (scene.has_target)
    for (int k = 0; k < 3; ++k) camera.target[k] = static_cast<float>(scene.target[k]);
  if (scene.has_distance) camera.distance = static_cast<float>(scene.distance);
}

RendererHost::RendererHost(int width, int height) : headless_(width, height), renderer_(headless_.loader()) {}

const Frame& RendererHost::collect(lua::Script& script, const Toggles& toggles) {
  collector_.collect(*script.world(), script.appearance(), toggles, frame_);
  return frame_;
}

Camera RendererHost::aim(const lua::Script& script, const CameraWish& wish, const Bounds& subject, bool planar) const {
  Camera camera;
  const lua::SceneCamera& own = script.camera();
  apply_angles(own, planar, camera);
  if (wish.has_angles) camera.yaw = wish.yaw, camera.pitch = wish.pitch;
  const Target target = headless_.target();
  camera.fit(subject, static_cast<float>(target.width) / static_cast<float>(target.height));
  apply_target(own, camera);
  if (wish.distance > 0) camera.distance = wish.distance;
  if (wish.has_places) camera.look_at(wish.eye, wish.target);
  return camera;
}

Image RendererHost::draw(const Camera& camera, const DrawOptions& options) {
  renderer_.draw(frame_, camera, options, headless_.target());
  return headless_.read();
}

}  // namespace feder::view
