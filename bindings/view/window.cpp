#include "view/window.h"

// the order matters: GLFW must not bring GL headers of its own
#define GLFW_INCLUDE_NONE
#include <GL/glcorearb.h>
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <thread>

#include "view/font.h"
#include "view/theme.h"

namespace feder::view {
namespace {

std::string glfw_message;
ImFont* console_font = nullptr;

ImFont* load_font(bool mono, float pixels) {
  const std::string file = dejavu_file(mono);
  return file.empty() ? nullptr : ImGui::GetIO().Fonts->AddFontFromFileTTF(file.c_str(), pixels);
}

// ImGui takes the first for everything that does not ask for another.
void load_fonts() {
  ImFont* text = load_font(false, 15);
  console_font = load_font(true, 14);
  if (!text) text = ImGui::GetIO().Fonts->AddFontDefault();
  if (!console_font) console_font = text;
}

}  // namespace

ImFont* code_font() { return console_font; }

Window::Window(int width, int height, const std::string& title) {
  glfw_message.clear();
  glfwSetErrorCallback([](int, const char* message) { glfw_message = message; });
  if (!glfwInit())
    throw WindowError("feder view: no display to open a window on (" + glfw_message +
                      "); pictures without a display: feder render");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 24);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window_) {
    const std::string why = glfw_message;
    glfwTerminate();
    throw WindowError("feder view: cannot open a window with OpenGL 3.3 (" + why + ")");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;

  load_fonts();
  apply_theme();
  glfwSetWindowUserPointer(window_, this);
  // ImGui calls this one after its own
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int) {
    Window& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    if (action == GLFW_PRESS) self.pressed_.push_back(key);
    if (action == GLFW_REPEAT) self.repeated_.push_back(key);
  });
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::closed() const { return glfwWindowShouldClose(window_) != 0; }
void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

bool Window::pressed(int key, bool repeated) const {
  const auto in = [key](const std::vector<int>& keys) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  };
  return in(pressed_) || (repeated && in(repeated_));
}

Target Window::target() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return {0, std::max(1, width), std::max(1, height)};
}

float Window::pixels_per_unit() const {
  int width = 0, height = 0;
  glfwGetWindowSize(window_, &width, &height);
  return width > 0 ? static_cast<float>(target().width) / static_cast<float>(width) : 1;
}

GlLoader Window::loader() const {
  return [](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); };
}

void Window::begin_frame() {
  // not every driver waits for the screen
  if (pace_) {
    const double wait = last_ + 1.0 / 60 - glfwGetTime();
    if (wait > 0) std::this_thread::sleep_for(std::chrono::duration<double>(std::min(wait, 1.0 / 60)));
  }
  last_ = glfwGetTime();
  poll();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void Window::poll() {
  ImGuiIO& io = ImGui::GetIO();
  pressed_.clear(), repeated_.clear();
  for (const int key : tapped_) io.KeysDown[key] = glfwGetKey(window_, key) == GLFW_PRESS;
  tapped_.clear();
  glfwPollEvents();
  // a key that went down and up again within one picture would never have been down for ImGui
  for (const int key : pressed_) {
    if (key < 0 || key >= IM_ARRAYSIZE(io.KeysDown) || io.KeysDown[key]) continue;
    io.KeysDown[key] = true;
    tapped_.push_back(key);
  }
}

void Window::end_frame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  if (want_picture_) read_picture();
  want_picture_ = false;
  glfwSwapBuffers(window_);
}

void Window::read_picture() {
  const auto read_pixels = reinterpret_cast<PFNGLREADPIXELSPROC>(glfwGetProcAddress("glReadPixels"));
  const auto pixel_store = reinterpret_cast<PFNGLPIXELSTOREIPROC>(glfwGetProcAddress("glPixelStorei"));
  const Target t = target();
  picture_ = Image(t.width, t.height);
  pixel_store(GL_PACK_ALIGNMENT, 1);
  read_pixels(0, 0, t.width, t.height, GL_RGBA, GL_UNSIGNED_BYTE, picture_.rgba.data());
  turn_over(picture_);
}

}  // namespace feder::view
