// Smoothing kernels of particle fluids. One file per kernel, one feder_kernel line. Contract, checked for every kernel
// by tests/sph/test_kernel_contract.cpp:
//  - W integrates to 1 in 2D and 3D, and is zero at the support;
//  - slope and Laplacian are its derivatives;
//  - the sums over neighbours equal plain sums.
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "sph/sweep_table.h"

namespace feder {

// A kernel of support 1 in `dimension` 2 or 3, normalised, as functions of u = r / support. One of support H is
// value(r/H) / H^D, its gradient slope(r/H) / H^(D+2) times the offset, its Laplacian laplacian(r/H) / H^(D+2).
struct KernelShape {
  double (*value)(int dimension, double u) = nullptr;
  double (*slope)(int dimension, double u) = nullptr;   // W' / u
  double (*second)(int dimension, double u) = nullptr;  // W''; null where nobody needs it
  double (*laplacian)(int dimension, double u) = nullptr;
};

struct Kernel {
  const char* name = "";
  const char* summary = "";
  KernelShape density, gradient, viscosity;  // the sums below use them in these roles
  const char *density_name = "", *pressure_name = "", *viscosity_name = "";
  double norm_density[2], norm_gradient[2], norm_viscosity[2];  // factors the sums leave out, for 2D and 3D
  bool radial_viscosity = true;    // pair term along the offset, factor 2 (D + 2) slope; else Laplacian times velocity
  double support[2] = {0, 0};      // proposed, in particle spacings, for 2D and 3D
  const Sweeps* sweeps = nullptr;  // null: only a part of other kernels
  const Sweeps* sweeps_wide = nullptr;  // for processors with AVX2; same bits
};

std::span<const Kernel> kernels();
// Names of those that have sums; of those in the roles of densities and pressures, and in that of viscosity.
std::string kernel_names();
std::string pressure_names();
std::string viscosity_names();
// The name of the kernel with these in its roles; pressure that is not the slope of the density's kernel is known for
// one pair only. SceneError otherwise.
std::string kernel_by_roles(std::string_view density, std::string_view pressure);
const Kernel& kernel_by_name(std::string_view name);            // SceneError
const Kernel& kernel_by_viscosity(std::string_view viscosity);  // SceneError
// The sums for this processor.
const Sweeps& sweeps_of(const Kernel& kernel);

}  // namespace feder
