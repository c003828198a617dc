// Watchdog over the kinetic energy of nets, see step/watch.h: a sum over velocities at the end of a step; for a net
// that jumped, its strain energy at the start of the step and upper bounds of the work on it.
#include <algorithm>
#include <cmath>

#include "springs/impl.h"

namespace feder {
namespace {
constexpr const char* kCure = "take more substeps, softer springs or the integrator implicit_euler";
}

// Sum of squared speeds. In Real: an overflow counts as a jump. Eight partial sums, so that it is vectorised.
Real Net::squared_speeds() const {
  constexpr std::size_t kPart = 8;
  const Real* v = particles_.velocity[first].data();
  const std::size_t size = std::size_t(points) * 3;
  std::size_t i = 0;
  Real sum = 0;
  if (size >= kPart) {
    Real part[kPart] = {};
    for (; i + kPart <= size; i += kPart)
      for (std::size_t k = 0; k < kPart; ++k) part[k] += v[i + k] * v[i + k];
    for (const Real p : part) sum += p;
  }
  for (; i < size; ++i) sum += v[i] * v[i];
  return sum;
}

double Net::kinetic_energy() const {
  double sum = 0;
  for (std::uint32_t i = first; i < first + points; ++i)
    sum += static_cast<double>(particles_.mass[i]) *
           static_cast<double>(dot(particles_.velocity[i], particles_.velocity[i]));
  return sum / 2;
}

double Net::kinetic_before() const {
  FEDER_ASSERT(!(squares_before < 0));
  Real most = 0;
  for (std::uint32_t i = first; i < first + points; ++i) most = std::max(most, particles_.mass[i]);
  return 0.5 * static_cast<double>(most) * static_cast<double>(squares_before);
}

// Strain energy at the start of the step, and an upper bound of the work of weight, scripts and generators in it, J.
double Net::given(double dt) {
  FEDER_ASSERT(particles_.start.size() == particles_.size());
  const Vec3* from = particles_.start.data() + first;
  const std::span<const Vec3> x = positions(), v = velocities();
  double sum = 0, all = 0;
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const double stretch = static_cast<double>(length(from[springs.j[k]] - from[springs.i[k]])) -
                           static_cast<double>(springs.rest_length[k]);
    if (springs.tension_only[k] && stretch < 0) continue;
    sum += springs.tension(k, stretch) * stretch / (springs.power[k] + 1);
  }
  for (std::uint32_t i = 0; i < points; ++i) {
    const double m = particles_.mass[first + i];
    all += m;
    sum +=
        static_cast<double>(length(particles_.script_force[first + i])) * static_cast<double>(length(x[i] - from[i]));
  }
  sum += gravity_work(static_cast<double>(length(gravity_)), dt, all, kinetic_before(),
                      std::fmin(kinetic_energy(), 1e300));
  if (acting_.empty()) return sum;
  // generators: the loss of potential, or, where there is none, force times path
  const std::span<const Vec3> begin(from, points);
  for (const ForceEntry* f : acting_) {
    double potential[2], push[2] = {0, 0};
    for (int end = 0; end < 2; ++end) {
      fill_points(end ? x : begin, v);
      potential[end] = f->points.empty() ? f->force->potential(points_.data(), points)
                                         : f->force->potential(some_.data(), pick_points(*f));
      above_.assign(points, Vec3(0, 0, 0));
      add_generator(*f, 0, above_.data());
      for (std::uint32_t i = 0; i < points; ++i)
        push[end] += static_cast<double>(length(above_[i])) * static_cast<double>(length(x[i] - from[i]));
    }
    if (potential[0] != 0 || potential[1] != 0)
      sum += std::fmax(potential[0] - potential[1], 0.0);
    else
      sum += std::fmax(push[0], push[1]);
  }
  return sum;
}

void Springs::Impl::watch(StepContext& c) {
  for (auto& p : nets) {
    Net& n = *p;
    if (n.squares <= Real(kDiverged) * n.squares_before) continue;  // most steps end here
    if (n.bad_point != kNone) continue;                             // quarantine reports it
    double mass = 0;
    for (std::uint32_t i = n.first; i < n.first + n.points; ++i) mass += static_cast<double>(particles.mass[i]);
    const double before = n.kinetic_before() + quiet_energy(c) * mass, after = n.kinetic_energy();
    if (!Watch::jumped(before, 0, after)) continue;
    const double given = n.given(static_cast<double>(c.dt));
    if (!Watch::jumped(before, given, after)) continue;
    const bool met =
        nets.size() > 1 && particles.radius[n.first] > 0;  // contact with other nets may have given the energy
    watched.suspects.push_back({kName, n.object, before, after, given, mass, met, kCure});
  }
}

// Reports a non-finite net.
void Springs::Impl::suspect(const Net& n) {
  watched.suspects.push_back({kName, n.object, n.kinetic_before(), NAN, 0, 0, false, kCure});
}

double Springs::held(const StepContext& c) {
  double sum = 0;
  for (auto& n : impl_->nets) sum += n->kinetic_before() + n->given(static_cast<double>(c.dt));
  return sum;
}

}  // namespace feder
