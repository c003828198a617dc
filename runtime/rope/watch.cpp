// Energy bounds of ropes for the watchdog (step/watch.h). The method of a rope only takes energy out; forces that are
// constant in a substep may give too much, and so may what a contact or an attachment undoes.
#include <algorithm>
#include <cmath>

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

// Upper bound of the work of weight, air, scripts and generators in the step, J: force times path. For a generator
// with a potential it is the loss of potential instead: where one is too stiff for the step, force times path would
// explain any energy.
double Rope::Impl::work(const Line& l, const StepContext& c) const {
  double all = 0, weight = 0, fall = 0, push = 0;
  bool held = false, area = false;
  const auto path = [&](std::uint32_t i) { return scalar(length(Vec3(l.position[i] - l.began[i]))); };
  const double g = scalar(length(gravity)) * std::fabs(scalar(l.settings.gravity_scale));
  for (std::uint32_t i = 0; i < l.size(); ++i) {
    if (l.inv_mass[i] == 0) continue;
    const double m = scalar(l.mass[i]);
    all += m * scalar(length(l.acceleration[i])) * path(i);
    weight += (m * g + scalar(length(l.script_force[i]))) * path(i);
  }
  each_force(l, [&](const ForceEntry& f) {
    area = area || f.force->on_area();
    double potential[2] = {0, 0}, most = 0;
    for (std::uint32_t i = 0; i < l.size(); ++i) {
      MassPoint point = mass_point(l, i);
      Vec3 before = Vec3::Zero(), after = Vec3::Zero();
      potential[1] += f.force->potential(&point, 1);
      f.force->add(&point, 1, c.time + scalar(c.dt), &after);
      point.position = l.began[i];
      potential[0] += f.force->potential(&point, 1);
      f.force->add(&point, 1, c.time, &before);
      if (l.inv_mass[i] != 0) most += scalar(std::max(length(before), length(after))) * path(i);
    }
    const bool conserves = potential[0] != 0 || potential[1] != 0;
    held = held || conserves;
    if (conserves)
      fall += std::fmax(potential[0] - potential[1], 0.0);
    else
      push += most;
  });
  return !held || area ? all : std::fmin(all, fall + push + weight);
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
