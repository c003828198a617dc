// Energy bounds of ropes for the watchdog (step/watch.h). The method of a rope only takes energy out; forces that are
// constant in a substep may give too much, and so may what a contact or an attachment undoes.
#include <algorithm>
#include <cmath>

#include "forces/work_bound.h"
#include "rope/impl.h"

namespace feder {
namespace {
constexpr double kTieSpeed = 3;  // m/s, at which attachments close (contact/rows.cpp, contact/links.cpp)

double scalar(Real x) { return static_cast<double>(x); }
}  // namespace

double Line::kinetic_energy() const {
  double sum = 0;
  for (std::uint32_t i = 0; i < size(); ++i) sum += scalar(mass[i]) * scalar(dot(velocity[i], velocity[i]));
  return 0.5 * sum;
}

// Upper bound of the work of weight, air, scripts and generators in the step, J.
double Rope::Impl::work(const Line& l, const StepContext& c) const {
  const double g = scalar(length(gravity)) * std::fabs(scalar(l.settings.gravity_scale));
  return work_bound(
      l.size(), c, [&](auto&& f) { each_force(l, f); }, [&](std::uint32_t i) { return mass_point(l, i); },
      [&](std::uint32_t i) { return l.inv_mass[i] != 0 ? l.began[i] : l.position[i]; },
      [&](std::uint32_t i) {
        const double m = scalar(l.mass[i]);
        return PointForces{m * scalar(length(l.acceleration[i])), m * g + scalar(length(l.script_force[i]))};
      });
}

// Energy that the step may have given, J: strain at its start, work, and what penetration and gaps of attachments are
// undone at.
double Rope::Impl::given(const Line& l, const StepContext& c) const {
  const double undone = kPushSpeed * kPushSpeed + (l.linked ? kTieSpeed * kTieSpeed : 0);
  return l.elastic_energy(l.began) + work(l, c) + 0.5 * scalar(l.total_mass) * undone;
}

void Rope::Impl::watch(const Line& l, const StepContext& c) {
  const double now = l.kinetic_energy();
  if (now <= kDiverged * l.kinetic_before) return;  // most steps end here
  const double before = l.kinetic_before + quiet_energy(c) * scalar(l.total_mass);
  if (!Watch::jumped(before, 0, now)) return;
  const double sum = given(l, c);
  if (!Watch::jumped(before, sum, now)) return;
  watched.suspects.push_back({kName, l.object, before, now, sum, scalar(l.total_mass), lines.size() > 1, kRopeCure});
}

// J
double Rope::held(const StepContext& c) {
  double sum = 0;
  for (const auto& l : impl_->lines) {
    sum += l->kinetic_before;
    if (l->active() && l->began.size() == l->size()) sum += impl_->given(*l, c);
  }
  return sum;
}

}  // namespace feder
