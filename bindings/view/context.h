// Contexts of OpenGL 3.3 core without a window. The libraries are opened at run time; one file each, because their
// headers do not go together.
#pragma once
#include <dlfcn.h>

#include <initializer_list>
#include <memory>
#include <string>

#include "view/renderer.h"

namespace feder::view {

// A shared library that stays open: drivers do not survive being closed.
class Library {
 public:
  explicit Library(std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (!handle_) handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  }
  explicit operator bool() const { return handle_ != nullptr; }
  template <class F>
  F function(const char* name) const {
    return reinterpret_cast<F>(dlsym(handle_, name));
  }

 private:
  void* handle_ = nullptr;
};

class Context {
 public:
  virtual ~Context() = default;
  GlLoader load;
  std::string name;
};

// Current when they return; GlError says why not.
std::unique_ptr<Context> make_egl_surfaceless();  // Mesa without any display
std::unique_ptr<Context> make_egl_pbuffer();      // the default display: other drivers, Xvfb
std::unique_ptr<Context> make_osmesa();           // into plain memory

}  // namespace feder::view
