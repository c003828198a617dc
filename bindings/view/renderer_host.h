// Pictures of running scenes without a window: a headless context, a renderer and a collector that are kept from
// picture to picture.
#pragma once
#include <string>

#include "feder/lua.h"
#include "view/collector.h"
#include "view/headless.h"

namespace feder::view {

// Where to look from. What is not given is what the scene says, and else fitted to what is seen.
struct CameraWish {
  bool has_angles = false;  // yaw and pitch, rad
  float yaw = 0, pitch = 0;
  float distance = 0;       // m; 0: fitted
  bool has_places = false;  // eye and target instead
  Float3 eye, target;
};
// "yaw,pitch" or "yaw,pitch,distance" (degrees, m) or "x,y,z,tx,ty,tz" (m). SceneError.
CameraWish read_camera(const std::string& text);
// "640x360". SceneError.
void read_size(const std::string& text, int& width, int& height);

// What a scene says of its camera: before it is fitted to the subject, and after.
void apply_angles(const lua::SceneCamera& scene, bool planar, Camera& camera);
void apply_target(const lua::SceneCamera& scene, Camera& camera);

class RendererHost {
 public:
  RendererHost(int width, int height);

  // Collects what the script's world looks like now; valid until the next call.
  const Frame& collect(lua::Script& script, const Toggles& toggles);
  // A camera for a subject: the scene's own wishes, then the caller's.
  Camera aim(const lua::Script& script, const CameraWish& wish, const Bounds& subject, bool planar) const;
  Image draw(const Camera& camera, const DrawOptions& options);  // of the frame that was collected last

  const std::string& how() const { return headless_.how(); }

 private:
  Headless headless_;
  Renderer renderer_;
  Collector collector_;
  Frame frame_;
};

}  // namespace feder::view
