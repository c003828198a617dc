// Forces of the world and of scripts on particles, at the start of each solver substep, as accelerations of that
// substep: where a solver adds gravity. Generators act on particles as on any mass points. Those on areas (wind) act on
// the surface: the gradient of the colour field, times the volume of a particle, is the area that it stands for, with
// its normal (Brackbill, Kothe & Zemach 1992; Mueller, Charypar & Gross 2003); the part of it that faces the flow is
// pushed along the flow, what lies along it rubs at kSkin. A particle alone has its own section. Kept between calls:
// forces of scripts, by particle. What presses the fluid together counts for the substeps that solvers choose, and for
// the speed of sound: the mean acceleration as gravity does, and of the rest the virial -<a . r> (Clausius 1870), which
// is the pressure over the density in the middle of a drop that an attractor holds. Wind and drag do not: what they
// press is no column. Weak spots: no wind shadow; forces that cancel in both means press unseen.
#include <algorithm>

#include "fluid/block_sums.h"
#include "fluid/impl.h"
#include "forces/area.h"
#include "forces/forces.h"

namespace feder {
namespace {

// The gradient lies half outside of the surface, where no particles are.
constexpr Real kOneSided = 2;
// Density over that at rest below which a particle counts as spray.
constexpr Real kSpray = Real(0.5);
constexpr std::uint32_t kForceBlock = 128;  // particles of one call of a generator

struct Sums {
  double momentum[3] = {0, 0, 0}, kinetic = 0;  // kg m/s, J
  void add(const Sums& s) {
    for (int k = 0; k < 3; ++k) momentum[k] += s.momentum[k];
    kinetic += s.kinetic;
  }
};

// Of positions and accelerations.
struct Pressing {
  double acceleration[3] = {0, 0, 0}, position[3] = {0, 0, 0}, along = 0;  // m/s^2, m, m^2/s^2
  void add(const Pressing& s) {
    for (int k = 0; k < 3; ++k) acceleration[k] += s.acceleration[k], position[k] += s.position[k];
    along += s.along;
  }
};

Sums sums_of(const FluidPool& p, const StepContext& c) {
  // of velocities and their squares
  Sums s = sum_blocks<Sums>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Sums& sum) {
    const double v[3] = {p.v[i].x, p.v[i].y, p.v[i].z};
    const double mass = p.is_mixture() ? static_cast<double>(p.mass_of(i)) : 1;
    for (int k = 0; k < 3; ++k) sum.momentum[k] += mass * v[k], sum.kinetic += mass * v[k] * v[k];
  });
  const double mass = p.is_mixture() ? 1 : static_cast<double>(p.mass);
  for (double& m : s.momentum) m *= mass;
  s.kinetic *= 0.5 * mass;
  return s;
}

// Wind on the surface of a particle, N. `full`: force on a square metre across the flow.
Vec3 wind_force(const Vec3& full, const Row4& surface) {
  const Real size = length(full);
  if (!(size > 0)) return Vec3::Zero();
  const Vec3 out = surface.vec();
  const Real facing = std::max(Real(0), -dot(out, full) / size);
  return (facing + kSkin * length(out) + surface.w) * full;
}

// Adds the forces on the particles [first, last), at most kForceBlock, to `out`; `drag`: what each may stop of a
// velocity, 1/s, or 0: without drag and wind.
template <class EachForce>
void add_generators(const FluidPool& p, std::uint32_t first, std::uint32_t last, double time, Real drag,
                    EachForce&& each_force, Vec3* out) {
  MassPoint points[kForceBlock];
  Vec3 full[kForceBlock];
  const std::uint32_t count = last - first;
  FEDER_ASSERT(count <= kForceBlock);
  for (std::uint32_t k = 0; k < count; ++k) {
    MassPoint& m = points[k];
    m.position = p.x[first + k].vec(), m.velocity = p.v[first + k].vec();
    m.mass = p.mass, m.volume = p.volume, m.most_drag = drag * p.mass;
  }
  each_force(p, [&](const ForceEntry& f) {
    if (!f.force->on_area()) return f.force->add(points, count, time, out);
    if (!(drag > 0)) return;
    for (std::uint32_t k = 0; k < count; ++k) {
      const Row4& surface = p.surface[first + k];
      const Real area = (1 + kSkin) * length(surface.vec()) + surface.w;
      full[k] = Vec3::Zero();
      if (!(area > 0)) continue;
      MassPoint m = points[k];
      m.area = 1, m.most_drag = drag * p.mass / area;
      f.force->add(&m, 1, time, &full[k]);
      out[k] += wind_force(full[k], surface);
    }
  });
}

}  // namespace

template <class F>
void Fluid::Impl::each_force(const FluidPool& p, F&& f) const {
  const Forces* forces = store.find<Forces>();
  if (!forces || p.is_mixture()) return;  // those on its fluids are in script_force
  const TagMask tags = objects.tags(p.object);
  for (const ForceEntry& entry : forces->list)
    if (acts_on(entry, p.object, tags)) f(entry);
}

bool Fluid::Impl::has_forces() const {
  const Forces* forces = store.find<Forces>();
  if (forces && !forces->list.empty()) return true;
  return std::any_of(pools.begin(), pools.end(), [](const auto& p) { return !p->script_force.empty(); });
}

bool Fluid::Impl::is_forced(const FluidPool& p) const {
  bool forced = !p.script_force.empty();
  each_force(p, [&](const ForceEntry&) { forced = true; });
  return forced;
}

bool Fluid::Impl::has_wind() {
  const Forces* forces = store.find<Forces>();
  if (!forces) return false;
  const bool wind = std::any_of(forces->list.begin(), forces->list.end(),
                                [](const ForceEntry& f) { return f.force && f.force->on_area(); });
  for (auto& p : pools)
    if (wind && p->surface.size() < p->x.size()) p->surface.resize(p->x.size());
  return wind;
}

// Surfaces of the pools that wind acts on, before the solver substeps.
void Fluid::Impl::find_surfaces(StepContext& c) {
  for (auto& pool : pools) {
    FluidPool& p = *pool;
    bool blown = false;
    each_force(p, [&](const ForceEntry& f) { blown = blown || f.force->on_area(); });
    if (!blown || !p.active()) continue;
    FEDER_ASSERT(p.surface.size() > p.count);
    boundary.move_to(0);
    p.sort_by_cell(*c.jobs);
    p.copy(p.x, p.start, *c.jobs);
    p.find_neighbors(*c.jobs, 0);
    p.find_contacts(*c.jobs, boundary, 0, c.gravity, false);
    p.find_ratios(boundary, *c.jobs);
    const SweepInput in = p.sweep_input();
    const Real section = p.volume / p.desc.spacing;
    c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      p.sweeps->slopes(in, first, last, &p.move[0].x, p.squares.data());
      for (std::uint32_t i = first; i < last; ++i) {
        Vec3 inward = p.slope_factor * p.move[i].vec();
        for (const BoundaryContact& k : p.contacts_of(i))
          inward -= p.table->at(k.distance(p.x[i].vec()) / p.support).colour / p.support * k.normal;
        p.surface[i].set(-kOneSided * p.volume * inward);
        p.surface[i].w = section * clamp((kSpray - p.ratio[i]) / (kSpray - p.own_value), 0, 1);
      }
    });
  }
}

// Forces on the particles, those of scripts included; f(first, last, forces) gets them block by block.
template <class F>
void Fluid::Impl::each_force_block(const FluidPool& p, std::uint32_t first, std::uint32_t last, double time, Real drag,
                                   F&& f) const {
  Vec3 force[kForceBlock];
  for (std::uint32_t from = first; from < last; from += kForceBlock) {
    const std::uint32_t to = std::min(from + kForceBlock, last);
    for (std::uint32_t i = from; i < to; ++i)
      force[i - from] = p.script_force.empty() ? Vec3(Vec3::Zero()) : p.script_force[i].vec();
    add_generators(
        p, from, to, time, drag, [&](const FluidPool& q, auto&& g) { each_force(q, g); }, force);
    f(from, to, force);
  }
}

// Null: none acts on the pool. Else the threads that may ask for them.
JobPool* Fluid::Impl::jobs_of_forces(const FluidPool& p, StepContext& c) {
  bool any = !p.script_force.empty(), serial = false;
  each_force(p, [&](const ForceEntry& f) { any = true, serial = serial || f.force->on_stepping_thread(); });
  return any ? (serial ? &one_thread : c.jobs) : nullptr;
}

// What presses the pools together in this substep, before they choose their solver substeps.
void Fluid::Impl::find_pressing(StepContext& c) {
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  for (auto& pool : pools) {
    FluidPool& p = *pool;
    p.pressing = Vec3::Zero(), p.squeeze = 0;
    if (!p.active()) continue;
    JobPool* jobs = jobs_of_forces(p, c);
    if (!jobs) continue;
    const double inv_mass = 1 / static_cast<double>(p.mass), n = p.count;
    const Pressing all = sum_ranges<Pressing>(
        p.count, kParticleGrain, *jobs, *c.scratch, [&](std::uint32_t first, std::uint32_t last, Pressing& sum) {
          each_force_block(p, first, last, time, 0, [&](std::uint32_t from, std::uint32_t to, const Vec3* force) {
            for (std::uint32_t i = from; i < to; ++i)
              for (int k = 0; k < (p.dimension == 2 ? 2 : 3); ++k) {
                const double a = static_cast<double>(force[i - from][k]) * inv_mass;
                const double x = static_cast<double>(p.x[i].vec()[k]);
                sum.acceleration[k] += a, sum.position[k] += x, sum.along += a * x;
              }
          });
        });
    double virial = -all.along / n;
    for (int k = 0; k < 3; ++k) {
      p.pressing[k] = static_cast<Real>(all.acceleration[k] / n);
      virial += all.acceleration[k] / n * (all.position[k] / n);
    }
    p.squeeze = static_cast<Real>(std::max(0.0, virial));
  }
}

// Of the running group, each pool for seconds(pool).
template <class F>
void Fluid::Impl::kick_by_forces(double time, StepContext& c, F&& seconds) {
  const Forces* forces = store.find<Forces>();
  const Real share = forces ? forces->drag_share() : Real(1);
  const auto kick_pool = [&](FluidPool& p) {
    if (!p.active() || p.group != static_cast<std::uint32_t>(c.inner.group)) return;
    const Real h = seconds(p);
    JobPool* jobs = h > 0 ? jobs_of_forces(p, c) : nullptr;
    if (!jobs) return;
    const Sums before = sums_of(p, c);
    jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      each_force_block(p, first, last, time, share / h, [&](std::uint32_t from, std::uint32_t to, const Vec3* force) {
        for (std::uint32_t i = from; i < to; ++i) {
          Vec3 kick = (h / p.mass_of(i)) * force[i - from];
          if (p.dimension == 2) kick[2] = 0;
          p.v[i].set(p.v[i].vec() + kick);
        }
      });
    });
    const Sums after = sums_of(p, c);
    for (int k = 0; k < 3; ++k) p.pushed[k] += after.momentum[k] - before.momentum[k];
    p.worked += std::max(0.0, after.kinetic - before.kinetic);
  };
  for (auto& p : pools) kick_pool(*p);
  for (auto& p : mixtures) kick_pool(*p);
}

// Forces on the particles of a fluid for this substep, into rows that it keeps in a mixture.
void Fluid::Impl::store_forces(const FluidPool& p, Row4* to, StepContext& c) {
  JobPool* jobs = jobs_of_forces(p, c);
  if (!jobs) return std::fill(to, to + p.count, Row4{});
  const Forces* forces = store.find<Forces>();
  const Real share = forces ? forces->drag_share() : Real(1);
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    each_force_block(p, first, last, time, share / c.h, [&](std::uint32_t from, std::uint32_t end, const Vec3* force) {
      for (std::uint32_t i = from; i < end; ++i) to[i].set(force[i - from]);
    });
  });
}

void Fluid::Impl::apply_forces(StepContext& c) {
  const Real h = c.h / static_cast<Real>(c.inner.count);
  const double time =
      c.time + static_cast<double>(c.substep) * static_cast<double>(c.h) + c.inner.index * static_cast<double>(h);
  kick_by_forces(time, c, [&](const FluidPool& p) { return p.half_kicks && c.inner.index == 0 ? h / 2 : h; });
}

// The last half of pools that began with one.
void Fluid::Impl::close_forces(StepContext& c) {
  if (!c.inner.last()) return;
  const Real h = c.h / static_cast<Real>(c.inner.count);
  const double time = c.time + static_cast<double>(c.substep + 1) * static_cast<double>(c.h);
  kick_by_forces(time, c, [&](const FluidPool& p) { return p.half_kicks ? h / 2 : Real(0); });
}

double Fluid::Impl::potential(const FluidPool& p) const {
  double sum = 0;
  each_force(p, [&](const ForceEntry& f) {
    for (std::uint32_t i = 0; i < p.count; ++i) {
      MassPoint m;
      m.position = p.x[i].vec(), m.velocity = p.v[i].vec(), m.mass = p.mass, m.volume = p.volume;
      sum += f.force->potential(&m, 1);
    }
  });
  return sum;
}

void Fluid::set_script_forces(ObjectId id, std::span<const Vec3> force) {
  const Command command(impl_->commands, "fluid.set_script_forces", id, force);
  FluidPool& p = impl_->pool(id);
  if (force.size() != p.count)
    throw SceneError("force: expected " + std::to_string(p.count) + " forces, one per particle, got " +
                     std::to_string(force.size()));
  for (const Vec3& f : force)
    if (!is_finite(f)) throw SceneError("force: expected three finite numbers");
  if (p.script_force.empty()) *impl_->structure_changed = true;
  p.keep_script_forces();
  const std::vector<std::uint32_t> order = impl_->by_id(p);
  for (std::size_t k = 0; k < order.size(); ++k) p.script_force[order[k]].set(force[k]);
}

void Fluid::clear_script_forces() {
  const Command command(impl_->commands, "fluid.clear_script_forces");
  for (auto& p : impl_->pools) std::fill(p->script_force.begin(), p->script_force.end(), Row4{});
}

}  // namespace feder
