#include "geom/surfaces.h"

#include "feder/error.h"

namespace feder {

void check_surfaces(const char* what, std::span<const ShapeSurface> surfaces) {
  if (surfaces.size() > kMaxSurfaces)
    throw SceneError(std::string(what) + ": expected at most " + std::to_string(kMaxSurfaces) + " surfaces, got " +
                     std::to_string(surfaces.size()));
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const ShapeSurface& s = surfaces[k];
    const auto fail = [&](const char* message) {
      throw SceneError(std::string(what) + ": surface " + std::to_string(k + 1) + ": " + message);
    };
    SurfaceNumbers::each_field(s.numbers, [&](Real x) {
      if (!is_finite(x)) fail("expected finite numbers");
    });
    if (s.numbers.restitution > 1) fail("expected a restitution from 0 to 1");
    if (!is_finite(s.velocity)) fail("expected a finite velocity");
  }
}

void fail_surface_number(const std::string& what, SurfaceNumber number, std::span<const ShapeSurface> surfaces) {
  throw SceneError(what + " names surface " + std::to_string(number) + ", but there are " +
                   std::to_string(surfaces.size()));
}

}  // namespace feder
