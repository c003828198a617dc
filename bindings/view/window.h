// A window with OpenGL 3.3 and Dear ImGui in it. Nothing here knows scenes.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

#include "view/image.h"
#include "view/renderer.h"

struct GLFWwindow;
struct ImFont;

namespace feder::view {

// what() is one line for the user.
class WindowError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Window {
 public:
  // WindowError when there is no display or no OpenGL 3.3.
  Window(int width, int height, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool closed() const;
  void set_title(const std::string& title);
  // Takes input, opens an ImGui frame.
  void begin_frame();
  // Draws ImGui over what is there and shows it.
  void end_frame();
  // The last picture, from the back buffer: between end_frame's drawing and its swap.
  void want_picture() { want_picture_ = true; }
  const Image& picture() const { return picture_; }

  // Keys (GLFW_KEY_...) that went down since the last picture; a tap shorter than a picture counts too.
  bool pressed(int key, bool repeated = false) const;

  Target target() const;          // in pixels
  float pixels_per_unit() const;  // framebuffer pixels per mouse unit
  GlLoader loader() const;
  void keep_pace(bool on) { pace_ = on; }  // at most 60 pictures a second

 private:
  void poll();
  void read_picture();

  GLFWwindow* window_ = nullptr;
  std::vector<int> pressed_, repeated_, tapped_;  // tapped_: shown to ImGui as held for one picture
  bool want_picture_ = false, pace_ = true;
  double last_ = 0;
  Image picture_;
};

ImFont* code_font();  // of the console; set once a window is open

}  // namespace feder::view
