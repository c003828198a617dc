// Energy bounds of cloths for the watchdog (step/watch.h). Strain counts as stored energy, but a link gives its two
// ends no more than the velocity that takes the strain back within one solver substep.
#include <algorithm>
#include <cmath>

#include "cloth/impl.h"
#include "forces/work_bound.h"

namespace feder {
namespace {
double number(Real x) { return static_cast<double>(x); }

constexpr const char* kCure = "take more substeps or a higher max_substeps, less stiffness, or the solver xpbd";
}  // namespace

double Cloth::Impl::kinetic_energy(const Sheet& s) const {
  Real sum[4] = {};
  for (std::uint32_t i = 0; i < s.points; ++i)
    sum[i & 3u] += vertices.mass[s.first + i] * dot(vertices.velocity[s.first + i], vertices.velocity[s.first + i]);
  return 0.5 * (static_cast<double>(sum[0]) + static_cast<double>(sum[1]) + static_cast<double>(sum[2]) +
                static_cast<double>(sum[3]));
}

// Upper bound of the work of weight, wind, scripts and generators in the step, J.
double Cloth::Impl::work(const Sheet& s, const StepContext& c) const {
  const double g = number(length(gravity)) * std::fabs(number(s.settings.gravity_scale));
  return work_bound(
      s.points, c, [&](auto&& f) { each_force(s, f); }, [&](std::uint32_t k) { return mass_point(s, s.first + k); },
      [&](std::uint32_t k) {
        const Vec3& x = vertices.position[s.first + k];
        return vertices.inv_mass[s.first + k] == 0 ? x : Vec3(x - delta_position[s.first + k].vec());
      },
      [&](std::uint32_t k) {
        const std::uint32_t i = s.first + k;
        const double m = number(vertices.mass[i]);
        return PointForces{m * number(length(acceleration[i])), m * g + number(length(vertices.script_force[i]))};
      });
}

// Energy that the step may have given, J: strain at its start, and work. Uses the displacements of the step, so it is
// asked before vertices are split.
double Cloth::Impl::given(const Sheet& s, const StepContext& c) const {
  const double rate = std::max(group_of(s).steps, 1) / number(c.h);
  const auto start = [&](std::uint32_t i) {
    const Vec3& x = vertices.position[s.first + i];
    return vertices.inv_mass[s.first + i] == 0 ? x : Vec3(x - delta_position[s.first + i].vec());
  };
  double sum = work(s, c);
  for (const ClothLink& l : s.mesh.links) {
    if (l.a >= s.points || l.b >= s.points) continue;
    const double stretch = number(length(start(l.b) - start(l.a)) - l.rest);
    const double pair = number(vertices.mass[s.first + l.a]) + number(vertices.mass[s.first + l.b]);
    sum += 0.5 * stretch * stretch * std::fmin(number(l.stiffness), pair * rate * rate);
  }
  for (const ClothHinge& h : s.mesh.hinges) {
    if (std::max({h.v[0], h.v[1], h.v[2], h.v[3]}) >= s.points) continue;
    const double bend = number(hinge_angle(start(h.v[0]), start(h.v[1]), start(h.v[2]), start(h.v[3])) - h.angle);
    const double least = std::remainder(bend, 6.283185307179586);
    sum += 0.5 * number(h.stiffness) * least * least;
  }
  return sum;
}

void Cloth::Impl::watch(StepContext& c) {
  const double least = quiet_energy(c);
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active() || s.bad_vertex != kNone) continue;  // quarantine reports those
    FEDER_ASSERT(!(s.kinetic_before < 0));               // set by prepare
    s.kinetic = kinetic_energy(s);
    if (s.kinetic <= kDiverged * s.kinetic_before) continue;  // most steps end here
    const double mass = number(s.mass), energy = s.kinetic_before + least * mass;
    if (!Watch::jumped(energy, 0, s.kinetic)) continue;
    const double energy_given = given(s, c);
    if (!Watch::jumped(energy, energy_given, s.kinetic)) continue;
    watched.suspects.push_back({kName, s.object, energy, s.kinetic, energy_given, mass, sheets.size() > 1, kCure});
  }
}

// A cloth that went non-finite.
void Cloth::Impl::suspect(const Sheet& s) {
  watched.suspects.push_back({kName, s.object, s.kinetic_before, NAN, 0, 0, false, kCure});
}

// J
double Cloth::held(const StepContext& c) {
  double sum = 0;
  for (const auto& s : impl_->sheets) {
    sum += s->kinetic_before;
    if (s->active() && impl_->delta_position.size() >= impl_->vertices.size()) sum += impl_->given(*s, c);
  }
  return sum;
}

}  // namespace feder
