#include <GL/osmesa.h>

#include "view/context.h"

namespace feder::view {
namespace {

class OsMesa final : public Context {
 public:
  OsMesa() {
    const Library mesa({"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"});
    if (!mesa) throw GlError("libOSMesa.so.8 is not installed");
    const auto create = mesa.function<decltype(&OSMesaCreateContextAttribs)>("OSMesaCreateContextAttribs");
    const auto current = mesa.function<decltype(&OSMesaMakeCurrent)>("OSMesaMakeCurrent");
    const auto get = mesa.function<decltype(&OSMesaGetProcAddress)>("OSMesaGetProcAddress");
    destroy_ = mesa.function<decltype(&OSMesaDestroyContext)>("OSMesaDestroyContext");
    if (!create || !current || !get || !destroy_) throw GlError("this OSMesa is too old");
    const int wanted[] = {OSMESA_FORMAT,
                          OSMESA_RGBA,
                          OSMESA_PROFILE,
                          OSMESA_CORE_PROFILE,
                          OSMESA_CONTEXT_MAJOR_VERSION,
                          3,
                          OSMESA_CONTEXT_MINOR_VERSION,
                          3,
                          0};
    context_ = create(wanted, nullptr);
    if (!context_) throw GlError("no context of OpenGL 3.3 core");
    if (!current(context_, pixels_, GL_UNSIGNED_BYTE, 8, 8)) throw GlError("the context cannot be made current");
    load = [get](const char* function) { return reinterpret_cast<void*>(get(function)); };
    name = "OSMesa";
  }
  ~OsMesa() override {
    if (context_) destroy_(context_);
  }

 private:
  decltype(&OSMesaDestroyContext) destroy_ = nullptr;
  OSMesaContext context_ = nullptr;
  unsigned char pixels_[8 * 8 * 4] = {};
};

}  // namespace

std::unique_ptr<Context> make_osmesa() { return std::make_unique<OsMesa>(); }

}  // namespace feder::view
