// The rows of the springs system, and what it tells about its state.
#include <algorithm>
#include <cmath>

#include "springs/impl.h"

namespace feder {

void Springs::Impl::remember(StepContext& c) {
  particles.start = particles.position;
  const Forces* forces = store.find<Forces>();
  for (auto& n : nets) n->prepare(c.gravity, forces, objects.tags(n->object));
  check_stiffness(c);
}

void Springs::Impl::check_stiffness(StepContext& c) {
  std::string message;
  for (auto& n : nets) {
    if (n->checked_step == c.h) continue;
    n->checked_step = c.h;
    double frequency = 0, decay = 0;
    n->bounds(frequency, decay);
    n->frequency = static_cast<Real>(frequency), n->decay = static_cast<Real>(decay);
    const IntegratorInfo info = n->integrator->info();
    if (n->warned_stiff || std::isinf(info.stability_limit)) continue;
    const double w = info.symplectic ? frequency : std::max(frequency, decay);
    if (!(static_cast<double>(c.h) * w > info.stability_limit)) continue;
    n->warned_stiff = true;
    message += (message.empty() ? "" : "; ") + objects.describe(n->object) + " with " + n->integrator_name;
    if (info.stability_limit == 0) {
      message += " is never stable without damping: take another integrator";
      continue;
    }
    const double needed = std::ceil(c.dt * w / info.stability_limit);
    message += " may be unstable: h w reaches " + std::to_string(static_cast<double>(c.h) * w) + ", its limit is " +
               std::to_string(info.stability_limit) + "; " + std::to_string(static_cast<long long>(needed)) +
               " substeps or implicit_euler are safe";
  }
  if (!message.empty()) c.events->warn("stiff", message);
}

void Springs::Impl::integrate(StepContext& c) {
  const double t = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  c.jobs->for_blocks(static_cast<std::uint32_t>(nets.size()), 1, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t k = first; k < last; ++k) {
      nets[k]->integrate(t, c.h);
      nets[k]->bad_point = nets[k]->find_non_finite();
    }
  });
  quarantine(c);
  for (auto& n : nets)
    if (n->can_break) break_springs(*n, *c.events);
}

void Springs::Impl::break_springs(Net& n, Events& events) {
  SpringArrays& s = n.springs;
  for (std::uint32_t k = 0; k < s.size(); ++k) {
    if (!(s.break_strain[k] < kInfinity)) continue;
    const Real strain = n.strain(k);
    if (!(strain > s.break_strain[k])) continue;
    Event e;
    e.kind = EventKind::spring_break;
    e.a = n.object;
    e.index = k;
    e.force = s.stiffness[k] * strain * s.rest_length[k];
    e.point = Real(0.5) * (particles.position[n.first + s.i[k]] + particles.position[n.first + s.j[k]]);
    events.add(e);
    s.remove(k);
    n.checked_step = 0;  // a restored net starts from fresh bounds too
  }
}

// A net with a non-finite point goes back to the start of the step and is held there: other systems never see the
// bad numbers, and the warning says where they came up.
void Springs::Impl::quarantine(StepContext& c) {
  std::string message;
  ObjectId object;
  for (auto& n : nets) {
    if (n->bad_point == kNone || n->frozen) continue;
    n->frozen = true;
    for (std::uint32_t i = n->first; i < n->first + n->points; ++i) {
      particles.position[i] = particles.start[i];
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
    n->bad_point = n->find_non_finite();  // what couplings and impulses did
    const std::uint64_t unconverged = n->integrator->stats.unconverged;
    if (unconverged == 0 || n->warned_unconverged) continue;
    n->warned_unconverged = true;
    message += (message.empty() ? "" : "; ") + objects.describe(n->object) + ": " + n->integrator_name +
               " stopped at its iteration cap, relative residual " + std::to_string(n->integrator->stats.residual);
  }
  quarantine(c);
  if (!message.empty()) c.events->warn("unconverged", message);
}

Energy Springs::energy(const Vec3& gravity) const {
  Energy sum;
  const Forces* forces = impl_->store.find<Forces>();
  for (auto& n : impl_->nets) {
    n->prepare(gravity, forces, impl_->objects.tags(n->object));
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
  double strain = 0, unconverged = 0, frozen = 0;
  for (const auto& n : impl_->nets) {
    for (std::uint32_t k = 0; k < n->springs.size(); ++k)
      strain = std::max(strain, std::fabs(static_cast<double>(n->strain(k))));
    unconverged += static_cast<double>(n->integrator->stats.unconverged);
    frozen += n->frozen;
  }
  out.push_back({"springs.max_strain", strain});
  out.push_back({"springs.unconverged_solves", unconverged});
  out.push_back({"springs.quarantined_nets", frozen});
}

bool Springs::finite() const {
  for (const auto& n : impl_->nets)
    if (n->frozen || n->find_non_finite() != kNone) return false;
  return true;
}

}  // namespace feder
