// Energy bounds of soft bodies for the watchdog (step/watch.h). Their method keeps energy or takes it out; forces that
// are constant in a substep may give too much, and so may what a contact or an attachment undoes.
#include <algorithm>
#include <cmath>

#include "forces/work_bound.h"
#include "soft/impl.h"

namespace feder {
namespace {
// m/s, at which overlap is undone (contact/rows.cpp), and gaps of attachments (contact/links.cpp)
constexpr double kSoftPush = 1, kSoftPull = 3;
}  // namespace

double SoftBody::kinetic_energy() const {
  double sum = 0;
  for (std::uint32_t i = 0; i < size(); ++i) sum += double(mass[i]) * double(dot(velocity[i], velocity[i]));
  return 0.5 * sum;
}

// Upper bound of the work of weight, scripts and generators in the step, J.
double Soft::Impl::work(const SoftBody& b, const StepContext& c) const {
  const double g = double(length(gravity)) * std::fabs(double(b.settings.gravity_scale));
  return work_bound(
      b.size(), c, [&](auto&& f) { each_force(b, f); }, [&](std::uint32_t i) { return mass_point(b, i); },
      [&](std::uint32_t i) { return b.inv_mass[i] != 0 ? b.began[i] : b.position[i]; },
      [&](std::uint32_t i) {
        const double m = double(b.mass[i]);
        return PointForces{m * double(length(b.acceleration[i])), m * g + double(length(b.script_force[i]))};
      });
}

// Energy that the step may have given, J: strain at its start, work, and what overlap and gaps of attachments are
// undone at.
double Soft::Impl::given(const SoftBody& b, const StepContext& c) const {
  const double undone = kSoftPush * kSoftPush + (b.linked ? kSoftPull * kSoftPull : 0);
  return std::fmax(b.elastic_energy(b.began), 0.0) + work(b, c) + 0.5 * double(b.total_mass) * undone;
}

void Soft::Impl::watch(const SoftBody& b, const StepContext& c) {
  const double now = b.kinetic_energy();
  if (now <= kDiverged * b.kinetic_before) return;  // most steps end here
  const double before = b.kinetic_before + quiet_energy(c) * double(b.total_mass);
  if (!Watch::jumped(before, 0, now)) return;
  const double sum = given(b, c);
  if (!Watch::jumped(before, sum, now)) return;
  watched.suspects.push_back({kName, b.object, before, now, sum, double(b.total_mass), bodies.size() > 1, kSoftCure});
}

// J
double Soft::held(const StepContext& c) {
  double sum = 0;
  for (const auto& b : impl_->bodies) {
    sum += b->kinetic_before;
    if (b->active() && b->began.size() == b->size()) sum += impl_->given(*b, c);
  }
  return sum;
}

}  // namespace feder
