#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "view/context.h"

namespace feder::view {
namespace {

class EglContext final : public Context {
 public:
  // `platform`: EGL_PLATFORM_SURFACELESS_MESA, or 0 for the default display with a pbuffer.
  explicit EglContext(EGLenum platform) {
    const Library egl({"libEGL.so.1", "libEGL.so"});
    if (!egl) throw GlError("libEGL.so.1 is not installed");
    get_ = egl.function<decltype(get_)>("eglGetProcAddress");
    if (!get_) throw GlError("libEGL.so.1 has no eglGetProcAddress");
    open(platform);
    make_context(platform == 0);
    load = [get = get_](const char* function) { return reinterpret_cast<void*>(get(function)); };
    name = platform ? "EGL surfaceless" : "EGL pbuffer";
  }

  ~EglContext() override {
    find<decltype(&eglMakeCurrent)>("eglMakeCurrent")(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) find<decltype(&eglDestroyContext)>("eglDestroyContext")(display_, context_);
    if (surface_ != EGL_NO_SURFACE) find<decltype(&eglDestroySurface)>("eglDestroySurface")(display_, surface_);
    find<decltype(&eglTerminate)>("eglTerminate")(display_);
  }

 private:
  template <class F>
  F find(const char* function) const {
    const auto found = reinterpret_cast<F>(get_(function));
    if (!found) throw GlError(std::string("EGL lacks ") + function);
    return found;
  }

  void open(EGLenum platform) {
    display_ = platform ? find<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT")(
                              platform, EGL_DEFAULT_DISPLAY, nullptr)
                        : find<decltype(&eglGetDisplay)>("eglGetDisplay")(EGL_DEFAULT_DISPLAY);
    if (display_ == EGL_NO_DISPLAY) throw GlError("no such display");
    if (!find<decltype(&eglInitialize)>("eglInitialize")(display_, nullptr, nullptr))
      throw GlError("the display does not open");
    if (!find<decltype(&eglBindAPI)>("eglBindAPI")(EGL_OPENGL_API)) throw GlError("no desktop OpenGL");
  }

  void make_context(bool pbuffer) {
    const EGLint wanted[] = {EGL_SURFACE_TYPE, pbuffer ? EGL_PBUFFER_BIT : 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                             EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!find<decltype(&eglChooseConfig)>("eglChooseConfig")(display_, wanted, &config, 1, &count) || count == 0)
      throw GlError("no configuration with desktop OpenGL");
    const EGLint version[] = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context_ = find<decltype(&eglCreateContext)>("eglCreateContext")(display_, config, EGL_NO_CONTEXT, version);
    if (context_ == EGL_NO_CONTEXT) throw GlError("no context of OpenGL 3.3 core");
    const EGLint tiny[] = {EGL_WIDTH, 8, EGL_HEIGHT, 8, EGL_NONE};
    if (pbuffer) surface_ = find<decltype(&eglCreatePbufferSurface)>("eglCreatePbufferSurface")(display_, config, tiny);
    if (!find<decltype(&eglMakeCurrent)>("eglMakeCurrent")(display_, surface_, surface_, context_))
      throw GlError("the context cannot be made current");
  }

  decltype(&eglGetProcAddress) get_ = nullptr;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
};

}  // namespace

std::unique_ptr<Context> make_egl_surfaceless() { return std::make_unique<EglContext>(EGL_PLATFORM_SURFACELESS_MESA); }
std::unique_ptr<Context> make_egl_pbuffer() { return std::make_unique<EglContext>(EGLenum(0)); }

}  // namespace feder::view
