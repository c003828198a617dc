// Energy bounds of fluids for the watchdog (step/watch.h). Stored energy of a fluid is its excess of density: while a
// fill may overlap something, that of a push of a spacing in a substep, or of a velocity of the speed of sound.
#include <algorithm>
#include <cmath>

#include "fluid/impl.h"

namespace feder {
namespace {

constexpr const char* kCure = "take more substeps or a higher max_substeps, or a larger viscosity or compression";

// Energy that the step may have given, J.
double given(const FluidPool& p, const StepContext& c) {
  const double n = p.count, m = static_cast<double>(p.mass), d = static_cast<double>(p.desc.spacing);
  const double dt = static_cast<double>(c.dt), h = static_cast<double>(c.h);
  const double g = static_cast<double>(length(c.gravity)) * std::fabs(static_cast<double>(p.desc.gravity_scale));
  double sum = gravity_work(g, dt, n * m + 1e-30, p.kinetic_before, std::fmin(p.kinetic, 1e300));
  sum += 2 * p.worked;
  sum += 8 * n * static_cast<double>(p.desc.surface_tension) * d * d;  // all the surface that particles can lose
  FEDER_ASSERT(h > 0 && !(p.kinetic_before < 0));
  const double push = d / h + static_cast<double>(p.sound);
  if (p.crowded > 0) sum += 0.5 * n * m * push * push;
  return sum;
}

}  // namespace

double FluidPool::kinetic_energy() const {
  double square = 0;
  for (std::uint32_t first = 0; first < count; first += kParticleGrain.items) {
    double of_block = 0;
    for (std::uint32_t i = first; i < std::min(count, first + kParticleGrain.items); ++i)
      of_block += static_cast<double>(dot(v[i].vec(), v[i].vec()));
    square += of_block;
  }
  return 0.5 * static_cast<double>(mass) * square;
}

void Fluid::Impl::watch(FluidPool& p, double square, StepContext& c) {
  p.kinetic_before = p.kinetic;
  p.kinetic = 0.5 * static_cast<double>(p.mass) * square;
  const double mass = static_cast<double>(p.mass) * p.count, before = p.kinetic_before + quiet_energy(c) * mass;
  if (Watch::jumped(before, 0, p.kinetic)) {
    const double found = given(p, c) + given_by_others(p, c);
    if (Watch::jumped(before, found, p.kinetic))
      watched.suspects.push_back({Fluid::kName, p.object, before, p.kinetic, found, mass, pools.size() > 1, kCure});
  }
  p.crowded = std::fmax(p.crowded - static_cast<double>(c.dt), 0.0);
}

// A fluid in which a particle went non-finite.
void Fluid::Impl::suspect(const FluidPool& p) {
  watched.suspects.push_back({Fluid::kName, p.object, p.kinetic, NAN, 0, 0, false, kCure});
}

double Fluid::held(const StepContext& c) {
  double sum = 0;
  for (const auto& p : impl_->pools) sum += p->kinetic_before + given(*p, c);
  return sum;
}

}  // namespace feder
