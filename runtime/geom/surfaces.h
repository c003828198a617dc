// Checks of the surfaces that a shape is made with. SceneErrors begin with `what`.
#pragma once
#include <span>
#include <string>

#include "feder/shape.h"

namespace feder {

void check_surfaces(const char* what, std::span<const ShapeSurface> surfaces);
[[noreturn]] void fail_surface_number(const std::string& what, SurfaceNumber number,
                                      std::span<const ShapeSurface> surfaces);

}  // namespace feder
