// Warnings about fluids that cannot go well together, tensions that they cannot have, and about fluids that do not
// fit: where they meet, spacings and densities within the ratio that their solver holds are wanted. Once each. Kept
// between calls: who has been warned.
#include <algorithm>

#include "feder/params.h"
#include "fluid/impl.h"

namespace feder {
namespace {

constexpr std::uint32_t kTried = 256;  // particles of one fluid, evenly taken, that look for another
constexpr Real kNarrow = Real(0.9);    // of the spacing, width between two walls that has no room for a particle

// Is a particle of one within `distance` of one of the other?
bool near(const FluidPool& a, const FluidPool& b, Real distance) {
  const std::uint32_t stride = a.count / kTried + 1;
  for (std::uint32_t i = 0; i < a.count; i += stride)
    for (std::uint32_t k = 0; k < b.count; ++k) {
      const Vec3 apart = a.x[i].vec() - b.x[k].vec();
      if (dot(apart, apart) < distance * distance) return true;
    }
  return false;
}

Real ratio_of(Real a, Real b) { return std::max(a, b) / std::min(a, b); }

}  // namespace

void Fluid::Impl::check_fluids_that_meet(StepContext& c) {
  const auto suits = [this](const FluidPool& a, const FluidPool& b) {
    return (a.warned_spacing || ratio_of(a.desc.spacing, b.desc.spacing) <= kMostSpacings) &&
           (a.warned_density || ratio_of(a.desc.density, b.desc.density) <= solver_of(a).most_density_ratio());
  };
  for (std::size_t k = 1; k < pools.size(); ++k)
    for (std::size_t j = 0; j < k; ++j) {
      FluidPool &a = *pools[k], &b = *pools[j];
      if (a.count == 0 || b.count == 0 || suits(a, b)) continue;
      if (!a.meets(b)) continue;
      const Real reach = std::max(a.desc.spacing, b.desc.spacing) * Real(1.5);
      Aabb box = a.bounds();
      box.grow(reach);
      if (!overlaps(box, b.bounds()) || !near(a, b, reach)) continue;
      const auto pair = [&](const char* what, Real x, Real y, const char* unit) {
        return objects.describe(a.object) + " with a " + what + " of " + print_value(x) + " " + unit + " touches " +
               objects.describe(b.object) + " with " + print_value(y);
      };
      if (!a.warned_spacing && ratio_of(a.desc.spacing, b.desc.spacing) > kMostSpacings) {
        a.warned_spacing = true;
        c.events->warn("fluid_spacing",
                       pair("spacing", a.desc.spacing, b.desc.spacing, "m") +
                           ": particles more than 1.25 times as wide as others are not solved as one with them, and "
                           "pass through; bring the spacings nearer to each other",
                       a.object);
      }
      const Real most = solver_of(a).most_density_ratio();
      if (!a.warned_density && ratio_of(a.desc.density, b.desc.density) > most) {
        a.warned_density = true;
        c.events->warn("density_ratio",
                       pair("density", a.desc.density, b.desc.density, "kg/m3") + ": with " + a.desc.solver +
                           " a ratio of more than " + print_value(most) +
                           " throws the lighter one about; bring the densities nearer to each other",
                       a.object);
      }
    }
}

void Fluid::Impl::check_interfaces(StepContext& c) {
  for (FluidInterface& f : interfaces) {
    const Real a = pool(f.a).desc.surface_tension, b = pool(f.b).desc.surface_tension;
    if (f.tension <= a + b || f.warned_of == f.tension) continue;
    f.warned_of = f.tension;
    c.events->warn("interface_tension",
                   "a tension of " + print_value(f.tension) + " N/m between " + objects.describe(f.a) + " and " +
                       objects.describe(f.b) + ", whose own are " + print_value(a) + " and " + print_value(b) +
                       " N/m: fluids with more between them than both have alone would part, so half of it is taken "
                       "as the tension of either where they touch; give them a surface_tension",
                   f.a);
  }
}

// After contacts have been found. Most of a new fluid lies between walls that are nearer to each other than particles.
void Fluid::Impl::check_room(FluidPool& p, StepContext& c) {
  if (p.filled_width > 0)
    c.events->warn("fluid_narrow",
                   objects.describe(p.object) + " with a spacing of " + print_value(p.desc.spacing) +
                       " m was filled into a shape that is " + print_value(p.filled_width) +
                       " m wide: one layer there weighs more than the shape holds; take a smaller spacing",
                   p.object);
  p.filled_width = 0;
  std::uint32_t squeezed = 0;
  Real narrowest = kInfinity;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const auto contacts = p.contacts_of(i);
    Real width = kInfinity;
    for (std::size_t k = 1; k < contacts.size(); ++k)
      for (std::size_t j = 0; j < k; ++j) {
        if (dot(contacts[k].normal, contacts[j].normal) > Real(-0.9)) continue;
        width = std::min(width, contacts[k].distance(p.x[i].vec()) + contacts[j].distance(p.x[i].vec()));
      }
    squeezed += width < kNarrow * p.desc.spacing;
    narrowest = std::min(narrowest, width);
  }
  if (2 * squeezed <= p.count) return;
  c.events->warn("fluid_narrow",
                 objects.describe(p.object) + " has a spacing of " + print_value(p.desc.spacing) +
                     " m, but lies between walls that are " + print_value(std::max(narrowest, Real(0))) +
                     " m apart: take a smaller spacing or a wider tank",
                 p.object);
}

}  // namespace feder
