// An OpenGL context without a display: EGL (surfaceless, then pbuffer), then OSMesa. Both are loaded when asked for, so
// a program that draws nothing needs neither.
#pragma once
#include <memory>
#include <string>

#include "view/image.h"
#include "view/renderer.h"

namespace feder::view {

class Headless {
 public:
  // GlError that lists each way tried and why it failed. FEDER_GL=egl|osmesa picks one.
  Headless(int width, int height);
  ~Headless();
  Headless(const Headless&) = delete;
  Headless& operator=(const Headless&) = delete;

  const GlLoader& loader() const;
  const std::string& how() const;  // "EGL surfaceless, llvmpipe (LLVM 15.0.6, 256 bits)"
  Target target() const;
  Image read() const;  // what was drawn, top row first

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder::view
