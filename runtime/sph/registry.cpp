// The table of kernels, from the generated list of the feder_kernel lines.
#include "feder/error.h"
#include "sph/kernel.h"

namespace feder {

using Row = Kernel;
#include "sph_declare.inc"

std::span<const Kernel> kernels() {
  static const std::initializer_list<Kernel> table = {
#include "sph_rows.inc"
  };
  return {table.begin(), table.size()};
}

namespace {

// name(kernel) of those that have sums, each once.
template <class F>
std::string list_names(F&& name) {
  std::string all;
  for (const Kernel& k : kernels()) {
    if (!k.sweeps) continue;
    const std::string one = name(k);
    if ((", " + all + ", ").find(", " + one + ", ") == std::string::npos) all += (all.empty() ? "" : ", ") + one;
  }
  return all;
}

template <class F>
const Kernel* find_kernel(F&& suits) {
  for (const Kernel& k : kernels())
    if (k.sweeps && suits(k)) return &k;
  return nullptr;
}

}  // namespace

std::string kernel_names() {
  return list_names([](const Kernel& k) { return std::string(k.name); });
}
std::string pressure_names() {
  return list_names([](const Kernel& k) {
    const std::string density = k.density_name;
    return density == k.pressure_name ? density : density + " with " + k.pressure_name;
  });
}
std::string viscosity_names() {
  return list_names([](const Kernel& k) { return std::string(k.viscosity_name); });
}

std::string kernel_by_roles(std::string_view density, std::string_view pressure) {
  const Kernel* found =
      find_kernel([&](const Kernel& k) { return density == k.density_name && pressure == k.pressure_name; });
  if (!found)
    throw SceneError("fluid.kernels: expected for density and pressure one of " + pressure_names() + ", got " +
                     std::string(density) + " with " + std::string(pressure) +
                     ": pressure keeps energy only as the slope of the density's kernel");
  return found->name;
}

const Kernel& kernel_by_name(std::string_view name) {
  const Kernel* found = find_kernel([&](const Kernel& k) { return name == k.name; });
  if (!found) throw SceneError("fluid.kernel: unknown kernel '" + std::string(name) + "'; known: " + kernel_names());
  return *found;
}

const Kernel& kernel_by_viscosity(std::string_view viscosity) {
  const Kernel* found = find_kernel([&](const Kernel& k) { return viscosity == k.viscosity_name; });
  if (!found)
    throw SceneError("fluid.kernels.viscosity: unknown kernel '" + std::string(viscosity) +
                     "'; known: " + viscosity_names());
  return *found;
}

const Sweeps& sweeps_of(const Kernel& k) {
#ifdef __x86_64__
  if (k.sweeps_wide && __builtin_cpu_supports("avx2")) return *k.sweeps_wide;
#endif
  return *k.sweeps;
}

}  // namespace feder
