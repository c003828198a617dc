// Tries the ways to draw without a window in turn, and keeps a framebuffer of the picture's size.
#include "view/headless.h"

#include <cstdlib>
#include <tuple>

#include "view/context.h"
#include "view/gl.h"

namespace feder::view {
namespace {

std::unique_ptr<Context> make_context() {
  const char* asked = std::getenv("FEDER_GL");
  const std::string wanted = asked ? asked : "";
  if (!wanted.empty() && wanted != "egl" && wanted != "osmesa")
    throw GlError("FEDER_GL=" + wanted + ": expected egl or osmesa");
  std::string tried;
  const std::tuple<const char*, const char*, std::unique_ptr<Context> (*)()> ways[] = {
      {"egl", "EGL surfaceless", make_egl_surfaceless},
      {"egl", "EGL pbuffer", make_egl_pbuffer},
      {"osmesa", "OSMesa", make_osmesa}};
  for (const auto& [family, name, make] : ways) {
    if (!wanted.empty() && wanted != family) continue;
    try {
      return make();
    } catch (const GlError& e) {
      tried += std::string("\n  ") + name + ": " + e.what();
    }
  }
  throw GlError("no way to draw without a display:" + tried +
                "\n  install libegl1 and libgl1-mesa-dri (or libosmesa6), or run under xvfb-run");
}

}  // namespace

struct Headless::Impl {
  Impl(int w, int h)
      : context(make_context()), gl(context->load), width(w), height(h),
        frame(gl.GenFramebuffers, gl.DeleteFramebuffers), color(gl.GenRenderbuffers, gl.DeleteRenderbuffers) {
    GLint largest = 0;
    gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
    if (w < 1 || h < 1 || w > largest || h > largest)
      throw GlError("expected a picture of 1 to " + std::to_string(largest) + " pixels each way, got " +
                    std::to_string(w) + " x " + std::to_string(h));
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame.id());
    attach_renderbuffer(gl, color, GL_RGBA8, GL_COLOR_ATTACHMENT0, w, h, 0);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) throw GlError("OpenGL: no framebuffer");
    how = context->name + ", " + reinterpret_cast<const char*>(gl.GetString(GL_RENDERER));
  }
  std::unique_ptr<Context> context;
  Gl gl;
  int width, height;
  GlObject frame, color;
  std::string how;
};

Headless::Headless(int width, int height) : impl_(std::make_unique<Impl>(width, height)) {}
Headless::~Headless() = default;
const GlLoader& Headless::loader() const { return impl_->context->load; }
const std::string& Headless::how() const { return impl_->how; }
Target Headless::target() const { return {impl_->frame.id(), impl_->width, impl_->height}; }

Image Headless::read() const {
  const Gl& gl = impl_->gl;
  Image image(impl_->width, impl_->height);
  gl.BindFramebuffer(GL_FRAMEBUFFER, impl_->frame.id());
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
  gl.check("the read back");
  turn_over(image);
  return image;
}

}  // namespace feder::view
