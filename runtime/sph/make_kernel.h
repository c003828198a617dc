// Fills the rows of the kernel table. Not for files compiled with -mavx2: includes std.
#pragma once
#include "sph/kernel.h"
#include "sph/sweeps.h"

namespace feder {
namespace {

template <class Shape>
KernelShape plain_shape() {
  KernelShape s;
  s.value = [](int d, double u) { return Shape::kNorm[d - 2] * Shape::value(u); };
  s.slope = [](int d, double u) { return Shape::kNorm[d - 2] * Shape::slope(u); };
  s.second = [](int d, double u) { return Shape::kNorm[d - 2] * Shape::second(u); };
  s.laplacian = [](int d, double u) { return Shape::kNorm[d - 2] * (Shape::second(u) + (d - 1) * Shape::slope(u)); };
  return s;
}

template <class Shape>
void set_norms(double (&norm)[2]) {
  norm[0] = Shape::kNorm[0], norm[1] = Shape::kNorm[1];
}

// One shape in all three roles.
template <class Shape>
Kernel single_kernel(const char* name, const char* summary, double support_2d, double support_3d) {
  Kernel k;
  k.name = k.density_name = k.pressure_name = k.viscosity_name = name, k.summary = summary;
  k.density = k.gradient = k.viscosity = plain_shape<Shape>();
  set_norms<Shape>(k.norm_density), set_norms<Shape>(k.norm_gradient), set_norms<Shape>(k.norm_viscosity);
  k.support[0] = support_2d, k.support[1] = support_3d;
  return k;
}

}  // namespace
}  // namespace feder
