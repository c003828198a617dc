// Mixtures: fluids that touch are solved as one. For a substep their particles are gathered into one pool, sorted and
// searched once, and go back after it. Every particle counts in a density as the volume that it stands for, whatever
// its mass (number density: Solenthaler & Pajarola, "Density Contrast SPH Interfaces", SCA 2008; Hu & Adams, JCP 213,
// 2006), so densities do not smear across an interface; its mass is in the equations of motion alone. Pressure is one
// field, forces of pairs stay equal and opposite, and what is lighter moves by so much more. Viscosity between fluids
// is the harmonic mean of theirs, tension between them that of add_tension(). Fluids may touch whose groups and masks
// let them; they touch where their boxes, swept over the substep, overlap. Those of one solver that may touch have at
// most one mixture, which holds all that touch another. Spacings may differ by 1.25 (uneven.cpp). Kept between
// substeps: nothing; all state is with the fluids. Weak spots: the pressure of the outermost heavy particles, of half a
// layer of them, acts on light ones: at a ratio of 100 it holds them half a spacing off. Boxes: a splash across a tank
// mixes what is in it. A fluid that sleeps wakes where another comes near. pbf and wcsph, whose particles lie in
// lattices, leave films of what is lighter by less than a half below.
#include <algorithm>
#include <cmath>

#include "feder/params.h"
#include "fluid/block_sums.h"
#include "fluid/impl.h"

namespace feder {
namespace {

bool suits(const FluidPool& a, const FluidPool& b) {
  const Real x = a.desc.spacing, y = b.desc.spacing;
  return a.meets(b) && std::max(x, y) <= kMostSpacings * std::min(x, y);
}

// Of the energy of a free surface of both, that a face between two has for the same share of the colour: in the plane
// it does not settle as much. Jumps of pressure are then 0.82 to 1.14 of Laplace's in the plane, with 17 and 20
// spacings across a radius, where the tension is a half or all of the sum of both (0.55 to 0.8 for a quarter), and
// periods 1.07 to 1.2 of Lamb's; in space, with 7 spacings, jumps are 0.5 to 1.2.
constexpr Real kFace[2] = {Real(0.758), 1};

Real cube_root(Real x) { return static_cast<Real>(std::cbrt(static_cast<double>(x))); }

// What the solver works with. The strictest demand counts.
FluidDesc desc_of(const std::vector<FluidPool*>& fluids) {
  FluidDesc d = fluids.front()->desc;
  d.max_particles = 0;
  for (const FluidPool* p : fluids) {
    const FluidDesc& o = p->desc;
    d.density = std::max(d.density, o.density), d.viscosity = std::max(d.viscosity, o.viscosity);
    d.surface_tension = std::max(d.surface_tension, o.surface_tension);
    d.adhesion = std::max(d.adhesion, o.adhesion), d.vorticity = std::max(d.vorticity, o.vorticity);
    d.stiffness = std::max(d.stiffness, o.stiffness), d.iterations = std::max(d.iterations, o.iterations);
    d.negative_pressure = std::max(d.negative_pressure, o.negative_pressure);
    d.tolerance = std::min(d.tolerance, o.tolerance), d.spacing = std::max(d.spacing, o.spacing);
    if (d.compression == 0 || (o.compression > 0 && o.compression < d.compression)) d.compression = o.compression;
    d.artificial_viscosity = std::max(d.artificial_viscosity, o.artificial_viscosity);
    d.max_substeps = std::max(d.max_substeps, o.max_substeps);
    if (std::abs(o.gravity_scale) > std::abs(d.gravity_scale)) d.gravity_scale = o.gravity_scale;
    d.max_particles += p->capacity();
    d.group |= o.group, d.mask |= o.mask;
  }
  return d;
}

// Calls f(array of the fluid, array of the mixture) for all state by particle that a substep reads or changes.
template <class F>
void each_row(FluidPool& fluid, FluidPool& mixture, F&& f) {
  f(fluid.x, mixture.x), f(fluid.v, mixture.v), f(fluid.start, mixture.start);
  f(fluid.lambda, mixture.lambda), f(fluid.ratio, mixture.ratio), f(fluid.screen, mixture.screen);
  f(fluid.id, mixture.id);
  if (!fluid.origin.empty()) f(fluid.origin, mixture.origin);
}

// State of a fluid as a whole.
template <class F>
void each_flag(FluidPool& fluid, FluidPool& mixture, F&& f) {
  f(fluid.warned_budget, mixture.warned_budget), f(fluid.warned_viscosity, mixture.warned_viscosity);
  f(fluid.layered, mixture.layered);
}

// Does what is heavier lie below what is lighter? By pairs of neighbours, one of each: where one fluid floats in
// another there are as many of either kind. Fluids that hang over lighter ones move ever so slowly at first.
bool is_layered(const FluidPool& m, const Vec3& gravity, StepContext& c) {
  struct Pairs {
    double along = 0, all = 0;  // of density times g . x, their differences
    void add(const Pairs& p) { along += p.along, all += p.all; }
  };
  constexpr double kLayered = 0.5;
  const Pairs sum = sum_blocks<Pairs>(m.count, kFluidGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Pairs& s) {
    const Real own = m.fluid_of(i).desc.density;
    for (const std::uint32_t j : m.lists.row(i)) {
      if (m.phase[i] == m.phase[j]) continue;
      const double by =
          static_cast<double>((own - m.fluid_of(j).desc.density) * dot(gravity, Vec3(m.x[i].vec() - m.x[j].vec())));
      s.along += by, s.all += std::fabs(by);
    }
  });
  return sum.along >= kLayered * sum.all;
}

// Counts by phase, one block of particles.
struct PhaseCounts {
  std::uint32_t particles = 0, contacts = 0;
};

}  // namespace

// Fluids that may touch are solved as one, so what a solver takes from its description has to be one.
void Fluid::Impl::check_suits(const FluidPool& made) const {
  for (const auto& p : pools) {
    if (!p->meets(made)) continue;
    const auto differ = [&](const char* what, const std::string& own, const std::string& other) {
      if (own == other) return;
      throw SceneError("fluid: " + std::string(what) + ": expected \"" + other + "\", that of " +
                       objects.describe(p->object) + ", got \"" + own + "\"" +
                       (made.desc.name.empty() ? "" : " for '" + made.desc.name + "'") +
                       ": fluids that may touch are solved as one; give both one " + what +
                       ", or groups and masks that keep them apart");
    };
    differ("solver", made.desc.solver, p->desc.solver);
    differ("kernel", made.desc.kernel, p->desc.kernel);
    differ("kernels.viscosity", made.desc.viscosity_kernel, p->desc.viscosity_kernel);
    differ("surface_model", made.desc.surface_model, p->desc.surface_model);
    differ("integrator", made.desc.integrator, p->desc.integrator);
    differ("wall_slip", made.desc.wall_slip, p->desc.wall_slip);
    differ("neighbors", made.desc.neighbors, p->desc.neighbors);
    differ("support", print_value(made.desc.support), print_value(p->desc.support));
  }
}

// The tension between two fluids; where none is given it is the difference of theirs (Antonow 1907).
Real Fluid::Impl::tension_between(const FluidPool& a, const FluidPool& b) const {
  for (const FluidInterface& f : interfaces)
    if ((f.a == a.object && f.b == b.object) || (f.a == b.object && f.b == a.object)) return f.tension;
  return std::abs(a.desc.surface_tension - b.desc.surface_tension);
}

// What gives the tensions of a mixture. Cohesion: forces of pairs, by sigma_aa + sigma_bb - 2 sigma_ab (Girifalco &
// Good 1957). Colour field: energies of fluids and shares of pairs, see tension.cpp. Two fluids with more tension
// between them than both have alone would part: theirs are taken as half of it then.
void Fluid::Impl::set_tensions(FluidPool& mixture) const {
  const auto& list = mixture.phases;
  std::vector<Real> own;
  Real most = 0;
  for (const FluidPool* a : list) {
    own.push_back(a->desc.surface_tension);
    for (const FluidPool* b : list) {
      const Real between = a == b ? Real(0) : tension_between(*a, *b);
      most = std::max({most, a->desc.surface_tension, between});
      if (between > a->desc.surface_tension + b->desc.surface_tension) own.back() = std::max(own.back(), between / 2);
    }
  }
  mixture.desc.surface_tension = most;
  mixture.find_tension();
  mixture.pull.clear(), mixture.color_energies.clear(), mixture.wettings.clear();
  for (std::size_t a = 0; a < list.size(); ++a) {
    mixture.color_energies.push_back(mixture.energy_unit(list[a]->desc.spacing) * own[a]);
    mixture.wettings.push_back(mixture.wetting_unit(list[a]->desc.spacing));
    for (std::size_t b = 0; b < list.size(); ++b) {
      const Real between = a == b ? Real(0) : tension_between(*list[a], *list[b]);
      const Real both = own[a] + own[b], part = both > 0 ? between / both : Real(0);
      mixture.pull.push_back(mixture.colored
                                 ? 1 - cube_root(kFace[mixture.dimension - 2] * std::min(part, Real(1)))
                                 : (list[a]->cohesion + list[b]->cohesion - mixture.force_of_tension * between) / 2);
    }
  }
}

void Fluid::set_interface(ObjectId a, ObjectId b, Real tension) {
  const Command command(impl_->commands, "fluid.set_interface", a, b, tension);
  Impl& m = *impl_;
  const auto describe = [&](ObjectId id) { return m.objects.describe(id); };
  m.objects.index(a, kFluidKind), m.objects.index(b, kFluidKind);  // throw
  const FluidPool &p = m.pool(a), &q = m.pool(b);
  if (a == b) throw SceneError("interface: expected two fluids, got " + describe(a) + " twice");
  if (!p.meets(q))
    throw SceneError("interface: expected fluids that may touch, but groups and masks of " + describe(a) + " and " +
                     describe(b) + " keep them apart");
  Need{"interface"}(tension >= 0 && is_finite(tension), "tension", "a finite number, 0 or more", tension);
  FluidInterface* known = nullptr;
  for (FluidInterface& f : m.interfaces)
    if ((f.a == a && f.b == b) || (f.a == b && f.b == a)) known = &f;
  if (known)
    known->tension = tension;
  else
    m.interfaces.push_back({a, b, tension, 0});
  *m.structure_changed = true;
}

void Fluid::Impl::make_mixtures() {
  mixtures.clear();
  std::vector<std::vector<FluidPool*>> sets;
  for (auto& p : pools) {
    // joins the sets of all that it may touch
    std::vector<FluidPool*> own{p.get()};
    const auto joins = [&](const std::vector<FluidPool*>& set) {
      const bool any = std::any_of(set.begin(), set.end(), [&](const FluidPool* o) { return suits(*o, *p); });
      if (any) own.insert(own.end(), set.begin(), set.end());
      return any;
    };
    sets.erase(std::remove_if(sets.begin(), sets.end(), joins), sets.end());
    sets.push_back(std::move(own));
  }
  for (std::vector<FluidPool*>& set : sets) {
    if (set.size() < 2) continue;
    std::sort(set.begin(), set.end(), [&](const FluidPool* a, const FluidPool* b) {
      return objects.index(a->object) < objects.index(b->object);
    });
    const FluidDesc desc = desc_of(set);
    if (desc.max_particles == 0) continue;
    auto m = std::make_unique<FluidPool>(arena, desc, dimension);
    m->phases = std::move(set);
    m->object = m->phases.front()->object;
    m->keep_origins(), m->phase.resize(1);
    if (has_forces()) m->keep_script_forces();
    solver_of(*m).keep(*m);
    m->grow(static_cast<std::uint32_t>(desc.max_particles));
    Real least = desc.density;
    for (const FluidPool* p : m->phases) least = std::min(least, p->desc.density);
    m->lightest = least / desc.density;
    for (const FluidPool* p : m->phases) {  // a fluid that is held farther off by itself would fall from there
      m->finest = std::min(m->finest, p->desc.spacing), m->clearance = std::min(m->clearance, p->clearance);
    }
    if (m->finest < desc.spacing) m->keep_shares();
    set_tensions(*m);
    mixtures.push_back(std::move(m));
  }
}

// Which fluids of each mixture are part of it in this substep; those that sleep wake beside one that does not.
void Fluid::Impl::find_touching(StepContext& c) {
  for (auto& m : mixtures) {
    const std::size_t n = m->phases.size();
    swept.clear();
    for (FluidPool* p : m->phases) {
      swept.push_back(p->count > 0 && !p->frozen ? swept_bounds(*p, c) : Aabb{});
      p->mixed = p->touches = false;
    }
    const auto touch = [&](std::size_t a, std::size_t b) {
      const FluidPool &p = *m->phases[a], &q = *m->phases[b];
      return a != b && p.count > 0 && q.count > 0 && !p.frozen && !q.frozen && suits(p, q) &&
             overlaps(swept[a], swept[b]);
    };
    for (bool again = true; again;) {
      again = false;
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) {
          if (!m->phases[a]->asleep || m->phases[b]->asleep || !touch(a, b)) continue;
          wake(*m->phases[a], WakeCause::contact, m->phases[b]->object);
          again = true;
        }
    }
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n && !m->phases[a]->mixed; ++b)
        m->phases[a]->mixed = m->phases[a]->touches = !m->phases[a]->asleep && touch(a, b);
  }
}

void Fluid::Impl::mix(StepContext& c) {
  find_touching(c);
  for (auto& mixture : mixtures) {
    FluidPool& m = *mixture;
    m.last_h = m.sound = m.excess = m.too_dense = m.unsolved = m.squeeze = 0;
    m.pressing = Vec3::Zero();
    m.steps = m.iterations = 0;
    m.pushed[0] = m.pushed[1] = m.pushed[2] = m.worked = 0;
    m.count = 0;
    std::uint32_t all = 0;
    for (const FluidPool* p : m.phases) all += p->mixed ? p->count : 0;
    FEDER_ASSERT(all <= m.capacity());
    for (std::uint32_t k = 0; k < m.phases.size(); ++k) {
      FluidPool& p = *m.phases[k];
      if (!p.mixed) continue;
      const std::uint32_t at = m.count;
      each_row(p, m, [&](const auto& from, auto& to) {
        c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
          std::copy(from.begin() + first, from.begin() + last, to.begin() + at + first);
        });
      });
      if (p.origin.empty()) std::copy(p.x.begin(), p.x.begin() + p.count, m.origin.begin() + at);
      std::fill(m.phase.begin() + at, m.phase.begin() + at + p.count, k);
      if (!m.script_force.empty()) store_forces(p, m.script_force.data() + at, c);
      // impulses of the last substep, for the time that the first fluid's were of
      if (!(m.last_h > 0)) m.last_h = p.last_h;
      const Real scale = p.last_h > 0 ? m.last_h / p.last_h : Real(1);
      if (scale != 1)
        for (std::uint32_t i = at; i < at + p.count; ++i) m.lambda[i] *= scale;
      const Real share = static_cast<Real>(p.count) / static_cast<Real>(all);
      m.excess += share * p.excess;
      m.pressing += share * p.pressing;
      m.sound = std::max(m.sound, p.sound), m.squeeze = std::max(m.squeeze, p.squeeze);
      m.too_dense = std::max(m.too_dense, p.too_dense), m.unsolved = std::max(m.unsolved, p.unsolved);
      each_flag(p, m, [&](const bool& from, bool& to) { to = m.count == 0 ? from : to || from; });
      m.count += p.count;
    }
    m.put_sentinel();
    m.origin[m.count] = {};
    if constexpr (kAsserts) m.ids_there = m.id_sum();
  }
}

// f(pool) for the others that it touches.
template <class F>
void Fluid::Impl::each_touching(const FluidPool& p, F&& f) const {
  for (const auto& m : mixtures) {
    const auto& list = m->phases;
    if (!p.touches || std::find(list.begin(), list.end(), &p) == list.end()) continue;
    for (const FluidPool* o : list)
      if (o != &p && o->touches) f(*o);
  }
}

bool Fluid::Impl::all_calm(const FluidPool& p, Real time) const {
  bool calm = !p.touches || p.layered;
  each_touching(p, [&](const FluidPool& o) { calm = calm && (o.asleep || o.calm >= time); });
  return calm;
}

double Fluid::Impl::given_by_others(const FluidPool& p, const StepContext& c) const {
  double mass = 0, before = 0, now = 0, fastest = 0;
  each_touching(p, [&](const FluidPool& o) {
    mass += static_cast<double>(o.mass) * o.count;
    before += o.kinetic_before, now += std::fmin(o.kinetic, 1e300);
    fastest = std::max(fastest, std::fabs(static_cast<double>(o.desc.gravity_scale)));
  });
  if (!(mass > 0)) return 0;
  return before +
         gravity_work(fastest * static_cast<double>(length(c.gravity)), static_cast<double>(c.dt), mass, before, now);
}

// Those that are solved as one with a fluid where it is now, itself first.
bool Fluid::Impl::list_near(const FluidPool& p, const FluidPool& mixture, std::vector<const FluidPool*>& out) const {
  out.assign(1, &p);
  const auto& list = mixture.phases;
  if (p.frozen || std::find(list.begin(), list.end(), &p) == list.end()) return false;
  Aabb box = p.bounds();
  box.grow(mixture.support);
  for (const FluidPool* o : list)
    if (o != &p && o->count > 0 && !o->frozen && suits(p, *o) && overlaps(box, o->bounds())) out.push_back(o);
  return out.size() > 1;
}

bool Fluid::Impl::meets_others(const FluidPool& p) const {
  std::vector<const FluidPool*> near;
  return std::any_of(mixtures.begin(), mixtures.end(), [&](const auto& m) { return list_near(p, *m, near); });
}

void Fluid::Impl::find_mixed_ratios(FluidPool& p) {
  std::vector<const FluidPool*> near;
  for (auto& mixture : mixtures) {
    FluidPool& m = *mixture;
    if (!list_near(p, m, near)) continue;
    for (const FluidPool* o : near) {
      const auto k = static_cast<std::uint32_t>(std::find(m.phases.begin(), m.phases.end(), o) - m.phases.begin());
      std::copy_n(o->x.begin(), o->count, m.x.begin() + m.count);
      std::copy_n(o->screen.begin(), o->count, m.screen.begin() + m.count);
      std::fill_n(m.phase.begin() + m.count, o->count, k);
      m.count += o->count;
    }
    m.put_sentinel();
    find_ratios_now(m);
    std::copy_n(m.ratio.begin(), p.count, p.ratio.begin());
    m.count = 0;
    m.put_sentinel();
  }
}

void Fluid::Impl::unmix(StepContext& c) {
  for (auto& mixture : mixtures) {
    FluidPool& m = *mixture;
    if (m.count == 0) continue;
    m.layered = is_layered(m, c.gravity, c);
    const Scratch::Frame frame(*c.scratch);
    const std::uint32_t blocks = block_count(m.count, kParticleGrain);
    const std::size_t phases = m.phases.size();
    PhaseCounts* counts = c.scratch->take<PhaseCounts>(blocks * phases);
    std::fill_n(counts, blocks * phases, PhaseCounts{});
    c.jobs->for_blocks(m.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      PhaseCounts* own = counts + first / kParticleGrain.items * phases;
      for (std::uint32_t i = first; i < last; ++i)
        ++own[m.phase[i]].particles, own[m.phase[i]].contacts += static_cast<std::uint32_t>(m.contacts_of(i).size());
    });
    for (std::size_t k = 0; k < phases; ++k) {
      FluidPool& p = *m.phases[k];
      PhaseCounts sum;
      for (std::uint32_t b = 0; b < blocks; ++b) {
        PhaseCounts& own = counts[b * phases + k];
        std::swap(own, sum);
        sum.particles += own.particles, sum.contacts += own.contacts;
      }
      if (!p.mixed) continue;
      FEDER_ASSERT(sum.particles == p.count);
      if (p.contacts.size() < sum.contacts) p.contacts.resize(sum.contacts + sum.contacts / 4);
      p.contact_first[p.count] = sum.contacts;
      p.dynamic_contacts.clear();
      p.found_pose.clear();
      for (const Pose& pose : m.found_pose) p.found_pose.push_back(pose);
      p.fast_shapes.reserve(m.found_pose.size());
      p.last_h = m.last_h, p.sound = m.sound, p.excess = m.excess;
      p.too_dense = m.too_dense, p.unsolved = m.unsolved;
      p.steps += m.steps, p.iterations += m.iterations;
      p.worked += m.worked;
      each_flag(p, m, [](bool& to, const bool& from) { to = from; });
      p.mixed = false;
    }
    for (int k = 0; k < 3; ++k) m.phases.front()->pushed[k] += m.pushed[k];
    c.jobs->for_blocks(m.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      PhaseCounts* next = counts + first / kParticleGrain.items * phases;
      for (std::uint32_t i = first; i < last; ++i) {
        FluidPool& p = *m.phases[m.phase[i]];
        PhaseCounts& at = next[m.phase[i]];
        each_row(p, m, [&](auto& to, const auto& from) { to[at.particles] = from[i]; });
        p.contact_first[at.particles] = at.contacts;
        for (const BoundaryContact& k : m.contacts_of(i)) {
          p.contacts[at.contacts] = k;
          p.contacts[at.contacts++].particle = at.particles;
        }
        ++at.particles;
      }
    });
    m.count = 0;
    m.put_sentinel();
  }
}

}  // namespace feder
