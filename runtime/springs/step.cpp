// The passes of the springs system, its conserved quantities and residuals.
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/cast.h"
#include "springs/impl.h"

namespace feder {
namespace {
constexpr JobGrain kPointGrain{2048, 1'000};  // points per job where little is done to each
constexpr std::uint32_t kElementWork = 8;     // ns, for a point or spring of a net

JobPool* threads_of(const StepContext& c) { return c.jobs->threads() > 1 ? c.jobs : nullptr; }
}  // namespace

// Start of the step: positions and energies for quarantine and watchdog, forces, warnings.
void Springs::Impl::remember(StepContext& c) {
  FEDER_ASSERT(!any_bad());  // the last step has quarantined them
  particles.start.resize(particles.position.size());
  c.jobs->for_blocks(particles.size(), kPointGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    std::copy(particles.position.begin() + first, particles.position.begin() + last, particles.start.begin() + first);
  });
  for (auto& n : nets) n->squares_before = n->squares < 0 ? n->squared_speeds() : n->squares;
  const Forces* forces = store.find<Forces>();
  for (auto& n : nets) n->prepare(c.gravity, air_density, forces, objects.tags(n->object));
  if (forces) warn_frozen_forces(*forces, *c.events);
  check_stiffness(c);
}

// Warning: a force that a script gives once per step is constant within it, so that methods of higher order have order
// 1, and implicit ones miss the force's stiffness.
void Springs::Impl::warn_frozen_forces(const Forces& forces, Events& events) {
  for (auto& n : nets) {
    if (n->warned_frozen) continue;
    const IntegratorInfo info = n->integrator->info();
    if (info.order == 1 && !info.implicit) continue;
    for (const ForceEntry& f : forces.list) {
      if (f.force || !aims_at(f, n->object, objects.tags(n->object))) continue;
      n->warned_frozen = true;
      std::string message = objects.describe(f.object) +
                            " is asked once before each step and held through it: with it " +
                            objects.describe(n->object) + " moves with order 1";
      if (info.order > 1) message += ", not " + std::to_string(info.order) + " of " + n->integrator_name;
      if (info.implicit) message += ", and " + n->integrator_name + " does not see how stiff it is";
      events.warn("frozen_force", message + "; give each as a formula in quotes, or stages = true", f.object);
      break;
    }
  }
}

// Warning: the substep is above the stability limit of a net's integrator.
void Springs::Impl::check_stiffness(StepContext& c) {
  std::string message;
  for (auto& n : nets) {
    if (n->checked_step == c.h && !n->has_power) continue;
    n->checked_step = c.h;
    double frequency = 0, decay = 0;
    n->bounds(frequency, decay, true, c.time);
    n->frequency = static_cast<Real>(frequency), n->decay = static_cast<Real>(decay);
    const IntegratorInfo info = n->integrator->info();
    if (n->warned_stiff) continue;
    const double number = stability_number(info, static_cast<double>(c.h), frequency, decay);
    if (!beyond_limit(info, number)) continue;
    n->warned_stiff = true;
    message += (message.empty() ? "" : "; ") + objects.describe(n->object) + " with " + n->integrator_name;
    if (info.stability_limit == 0) {
      message += " is never stable without damping: take another integrator";
      continue;
    }
    const double needed = std::ceil(number * c.substeps / info.stability_limit);
    message += " may be unstable: h w reaches " + std::to_string(number) + ", its limit is " +
               std::to_string(info.stability_limit) + "; " + std::to_string(whole_count(needed)) +
               " substeps or implicit_euler are safe";
  }
  if (!message.empty()) c.events->warn("stiff", message);
}

void Springs::Impl::integrate(StepContext& c) {
  const double t = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  const auto run = [&](Net& n, JobPool* inner) {
    n.integrate(t, c.h, inner);
    n.bad_point = n.find_non_finite(inner);
    n.snapped =
        n.can_break && n.bad_point == kNone && !n.frozen && n.layout.find_snapped(n.positions(), n.springs, inner);
  };
  // large nets one after another with all threads each, small ones in parallel
  for (auto& n : nets)
    if (n->wide() || n->on_stepping_thread) run(*n, n->wide() ? threads_of(c) : nullptr);
  const auto count = static_cast<std::uint32_t>(nets.size());
  std::uint32_t elements = 0;
  for (auto& n : nets)
    if (!n->wide() && !n->on_stepping_thread) elements += n->springs.size() + n->points;
  c.jobs->for_blocks(count, {1, elements / std::max(count, 1u) * kElementWork},
                     [&](std::uint32_t first, std::uint32_t last, int) {
                       for (std::uint32_t k = first; k < last; ++k)
                         if (!nets[k]->wide() && !nets[k]->on_stepping_thread) run(*nets[k], nullptr);
                     });
  if (any_bad()) quarantine(c);
  for (auto& n : nets) {
    if (n->snapped) break_springs(*n, *c.events);
    if (n->coincident > 0 && !n->warned_coincident) warn_coincident(*n, *c.events);
  }
}

void Springs::Impl::break_springs(Net& n, Events& events) {
  const SpringArrays& s = n.springs;
  const std::span<const std::uint8_t> snapped = n.layout.snapped();
  for (std::uint32_t group = 0; group < snapped.size(); ++group)
    for (std::uint32_t bits = snapped[group]; bits != 0; bits &= bits - 1) {
      const std::uint32_t k = group * kLanes + static_cast<std::uint32_t>(std::countr_zero(bits));
      FEDER_ASSERT(k < s.size() && s.alive[k]);  // else it would break twice
      Event e;
      e.kind = kSpringBreak;
      e.a = n.object;
      e.index = k;
      e.force = static_cast<Real>(s.tension(k, static_cast<double>(n.strain(k) * s.rest_length[k])));
      e.point = Real(0.5) * (particles.position[n.first + s.i[k]] + particles.position[n.first + s.j[k]]);
      events.add(e);
      n.remove_spring(k);  // the bounds of frequency and decay remain bounds
    }
}

void Springs::Impl::warn_coincident(Net& n, Events& events) {
  n.warned_coincident = true;
  std::string which = "a spring";
  const SpringArrays& s = n.springs;
  for (std::uint32_t k = 0; k < s.size(); ++k) {
    const Vec3 d = particles.start[n.first + s.j[k]] - particles.start[n.first + s.i[k]];
    if (!s.alive[k] || s.rest_length[k] == 0 || !(dot(d, d) <= kNoLength2)) continue;
    which = "spring " + std::to_string(k + 1) + " (points " + std::to_string(s.i[k] + 1) + " and " +
            std::to_string(s.j[k] + 1) + ")";
    break;
  }
  events.warn("coincident",
              objects.describe(n.object) + ": " + which + " has its ends at one spot and pushes them apart along x",
              n.object);
}

// Quarantine: a net with a non-finite point goes back to the start of the step and is pinned there, so that other
// systems never see its numbers; the warning names the point.
void Springs::Impl::quarantine(StepContext& c) {
  std::string message;
  ObjectId object;
  for (auto& n : nets) {
    if (!n->bad()) continue;
    FEDER_ASSERT(n->bad_point < n->points);
    n->frozen = true;
    suspect(*n);
    for (std::uint32_t i = n->first; i < n->first + n->points; ++i) {
      FEDER_ASSERT(is_finite(particles.start[i]));
      particles.place(i, particles.start[i]);
      particles.velocity[i] = Vec3::Zero();
      particles.inv_mass[i] = 0;
    }
    message += (message.empty() ? "" : "; ") + objects.describe(n->object) + " point " +
               std::to_string(n->bad_point + 1) + " went non-finite: the net is held where it was";
    if (!object) object = n->object;
  }
  if (!message.empty()) c.events->warn("non_finite", message, object);
}

void Springs::Impl::finish(StepContext& c) {
  std::string message;
  for (auto& n : nets) {
    n->squares = n->squared_speeds();
    // after couplings and impulses
    n->bad_point = n->find_non_finite(n->wide() ? threads_of(c) : nullptr, is_finite(n->squares));
    const std::uint64_t unconverged = n->integrator->stats.unconverged;
    if (unconverged == 0 || n->warned_unconverged) continue;
    n->warned_unconverged = true;
    message += (message.empty() ? "" : "; ") + objects.describe(n->object) + ": " + n->integrator_name +
               " stopped at its iteration cap, relative residual " + std::to_string(n->integrator->stats.residual);
  }
  watch(c);
  if (any_bad()) quarantine(c);
  if (!message.empty()) c.events->warn("unconverged", message);
}

Energy Springs::energy(const Vec3& gravity) const {
  Energy sum;
  const Forces* forces = impl_->store.find<Forces>();
  for (auto& n : impl_->nets) {
    n->prepare(gravity, impl_->air_density, forces, impl_->objects.tags(n->object));
    const Energy e = n->energy();
    sum.kinetic += e.kinetic, sum.potential += e.potential, sum.elastic += e.elastic;
  }
  return sum;
}

Momentum Springs::momentum() const {
  Momentum sum;
  const Particles& p = impl_->particles;
  for (std::uint32_t i = 0; i < p.size(); ++i) {
    const double m = p.mass[i];
    const double x[3] = {p.position[i][0], p.position[i][1], p.position[i][2]};
    const double v[3] = {m * p.velocity[i][0], m * p.velocity[i][1], m * p.velocity[i][2]};
    for (int k = 0; k < 3; ++k) {
      sum.linear[k] += v[k];
      sum.angular[k] += x[(k + 1) % 3] * v[(k + 2) % 3] - x[(k + 2) % 3] * v[(k + 1) % 3];
    }
  }
  return sum;
}

void Springs::residuals(std::vector<Residual>& out) const {
  double strain = 0, unconverged = 0, frozen = 0, coincident = 0;
  for (const auto& n : impl_->nets) {
    for (std::uint32_t k = 0; k < n->springs.size(); ++k)
      strain = std::max(strain, std::fabs(static_cast<double>(n->strain(k))));
    unconverged += static_cast<double>(n->integrator->stats.unconverged);
    frozen += n->frozen;
    coincident += static_cast<double>(n->coincident);
  }
  out.push_back({"springs.max_strain", strain});
  out.push_back({"springs.unconverged_solves", unconverged});
  out.push_back({"springs.quarantined_nets", frozen});
  out.push_back({"springs.coincident_ends", coincident});
}

bool Springs::finite() const {
  for (const auto& n : impl_->nets)
    if (n->frozen || n->find_non_finite() != kNone) return false;
  return true;
}

}  // namespace feder
