// Draws a Frame with OpenGL 3.3 core into a framebuffer. Owns no window and no context: it is given a current one,
// the same way by the viewer and by the headless renderer. Leaves GL as a library should: the target framebuffer
// bound, no program, vertex array or texture bound, depth test, culling, blending and scissor off.
#pragma once
#include <functional>
#include <memory>
#include <stdexcept>

#include "view/camera.h"
#include "view/frame.h"

namespace feder::view {

class GlError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Finds a GL function by name: eglGetProcAddress, glfwGetProcAddress, OSMesaGetProcAddress, or a test's own.
using GlLoader = std::function<void*(const char* name)>;

struct Target {
  unsigned framebuffer = 0;   // 0: the window
  int width = 0, height = 0;  // pixels
};

struct DrawOptions {
  int samples = 4;         // per pixel; 0 or 1: none. Lowered to what the driver has.
  int shadow_size = 2048;  // texels; 0: no shadows
  float line_scale = 1;    // for screens with small pixels
  bool labels = true;
};

struct DrawStats {
  int draw_calls = 0;
};

class Renderer {
 public:
  // Needs a current context of OpenGL 3.3 core or later; GlError says what is missing.
  explicit Renderer(const GlLoader& load);
  ~Renderer();  // with the same context current
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  // Clears the target and draws. GL errors are GlError.
  void draw(const Frame& frame, const Camera& camera, const DrawOptions& options, const Target& target);
  const DrawStats& stats() const;  // of the last draw

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder::view
