// The fluid system: descriptions are checked, pools made, filled and destroyed, and the passes listed. Arrays of
// particles grow outside steps only.
#include "feder/fluid.h"

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "feder/params.h"
#include "fluid/boundary.h"
#include "fluid/impl.h"
#include "step/watch.h"

namespace feder {
namespace {

// Of the spacing, along each axis of a shape that is filled: one layer in less would weigh more than a third too much.
constexpr double kLeastWidth = 0.75;

void check_desc(const FluidDesc& d) {
  const Need need{"fluid"};
  need(d.spacing > 0 && is_finite(d.spacing), "spacing", "a finite number above 0", d.spacing);
  need(d.density > 0 && is_finite(d.density), "density", "a finite number above 0", d.density);
  need(d.viscosity >= 0 && is_finite(d.viscosity), "viscosity", "a finite number, 0 or more", d.viscosity);
  if (d.wall_slip != "none" && d.wall_slip != "free")
    throw SceneError("fluid: wall_slip: expected \"none\" or \"free\", got \"" + d.wall_slip + "\"");
  need(d.surface_tension >= 0 && is_finite(d.surface_tension), "surface_tension", "a finite number, 0 or more",
       d.surface_tension);
  if (!d.surface_model.empty() && d.surface_model != "cohesion" && d.surface_model != "color_field")
    throw SceneError("fluid: surface_model: expected \"cohesion\" or \"color_field\", got \"" + d.surface_model + "\"");
  need(d.adhesion >= 0 && is_finite(d.adhesion), "adhesion", "a finite number, 0 or more", d.adhesion);
  need(d.friction >= 0 && is_finite(d.friction), "friction", "a finite number, 0 or more", d.friction);
  need(d.vorticity >= 0 && is_finite(d.vorticity), "vorticity", "a finite number, 0 or more", d.vorticity);
  if (d.integrator != "leapfrog" && d.integrator != "symplectic_euler")
    throw SceneError("fluid: integrator: expected \"leapfrog\" or \"symplectic_euler\", got \"" + d.integrator + "\"");
  need(d.support == 0 || (d.support >= Real(1.2) && d.support <= 4), "support", "1.2 to 4 spacings", d.support);
  need(d.stiffness >= 0 && is_finite(d.stiffness), "stiffness", "a finite number, 0 or more", d.stiffness);
  need(d.iterations >= 1 && d.iterations <= 1000, "iterations", "1 to 1000", d.iterations);
  need(d.tolerance > 0 && d.tolerance <= 100, "tolerance", "above 0, to 100 per cent", d.tolerance);
  need(d.negative_pressure >= 0 && d.negative_pressure <= 1, "negative_pressure", "0 to 1 atmospheres",
       d.negative_pressure);
  need(d.compression >= 0 && d.compression <= Real(0.5), "compression", "0 to 0.5", d.compression);
  need(d.artificial_viscosity >= 0 && d.artificial_viscosity <= 10, "artificial_viscosity", "0 to 10",
       d.artificial_viscosity);
  need(d.max_substeps >= 1 && d.max_substeps <= 100000, "max_substeps", "1 to 100000", d.max_substeps);
  need(d.max_particles >= 1 && d.max_particles <= (1u << 27), "max_particles", "1 to 134217728",
       static_cast<double>(d.max_particles));
  need(is_finite(d.gravity_scale), "gravity_scale", "a finite number", d.gravity_scale);
  need(d.kill_height < kInfinity, "kill_height", "a height, or minus infinity for none", d.kill_height);
}

}  // namespace

Fluid::Impl::Impl(SystemSetup& s)
    : arena(s.store.arena(kName)), store(s.store), objects(s.objects), commands(s.commands), events(s.events),
      watched(s.store.need<Watch>("watch")), boundary(s.store.need<Boundary>(kName)), dimension(s.dimension),
      structure_changed(s.structure_changed) {}

const SystemDescriptor& Fluid::descriptor() {
  static constexpr ObjectKind kinds[] = {kFluidKind, kEmitterKind, kDrainKind};
  static constexpr WakeCause causes[] = {kFluidCause};
  static constexpr EventKind events[] = {kEmitterDone, kDrained};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "particles",
                                     .unit = "particle",
                                     .kinds = kinds,
                                     .causes = causes,
                                     .events = events,
                                     .make = &make_system<Fluid>};
  return d;
}

Fluid::Fluid(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Fluid::~Fluid() = default;

FluidSolver& Fluid::Impl::solver_of(const FluidPool& p) {
  const auto table = fluid_solvers();
  solvers.resize(table.size());
  for (std::size_t k = 0; k < table.size(); ++k) {
    if (p.desc.solver != table[k].name) continue;
    if (!solvers[k]) solvers[k] = table[k].make(arena, Params());
    solvers[k]->boundary = &boundary;
    return *solvers[k];
  }
  find_variant(table, p.desc.solver, "fluid solver");  // throws: the error names the known solvers
  return *solvers[0];
}

void Fluid::Impl::group_pools() {
  for (auto& s : solvers)
    if (s) s->pools.clear();
  for (auto& p : pools) solver_of(*p).pools.push_back(p.get());
  make_mixtures();
  for (auto& p : mixtures) solver_of(*p).pools.push_back(p.get());
}

void Fluid::add_passes(StepPlan& plan) {
  Impl* m = impl_.get();
  m->make_room();
  m->group_pools();
  std::size_t most = 0;
  for (const auto& p : m->pools) most += p->capacity();
  if (most == 0) return;
  const auto rides = [](const auto& s) { return static_cast<bool>(s.body); };
  if (std::any_of(m->emitters.begin(), m->emitters.end(), rides) ||
      std::any_of(m->drains.begin(), m->drains.end(), rides))
    plan.add<&Impl::stop_lost_sources>(Rank::boundary_list, "stop lost sources", kName, m);
  if (!m->emitters.empty()) plan.add<&Impl::emit>(Rank::fluid_emit, "emit", kName, m);
  bool fresh = false;
  for (const auto& p : m->pools) fresh = fresh || p->fresh;
  if (fresh) plan.add<&Impl::relax>(Rank::fluid_settle, "make room", kName, m);
  plan.add<&Impl::begin_substep>(before(Rank::fluid_choose), "wake", kName, m);
  if (m->has_forces()) {
    if (m->has_wind()) plan.add<&Impl::find_surfaces>(before(Rank::fluid_choose), "surfaces", kName, m);
    plan.add<&Impl::find_pressing>(before(Rank::fluid_choose), "what presses", kName, m);
    plan.add<&Impl::apply_forces>(before(Rank::fluid_predict), "forces", kName, m);
  } else {
    for (auto& p : m->pools) p->pressing = Vec3::Zero(), p->squeeze = 0;
  }
  plan.add<&Impl::make_groups>(before(Rank::fluid_choose), "groups", kName, m);
  for (auto& s : m->solvers)
    if (s && !s->pools.empty()) s->add_passes(plan);
  if (m->has_forces() && std::any_of(m->pools.begin(), m->pools.end(), [](const auto& p) { return p->half_kicks; }))
    plan.add<&Impl::close_forces>(Rank::fluid_project, "forces, last half", kName, m);
  if (!m->mixtures.empty()) plan.add<&Impl::unmix>(before(Rank::fluid_check), "unmix", kName, m);
  plan.add<&Impl::project>(Rank::boundary_project, "non-penetration", kName, m);
  if (!m->drains.empty()) plan.add<&Impl::drain>(Rank::fluid_drain, "drain", kName, m);
  const bool kills =
      std::any_of(m->pools.begin(), m->pools.end(), [](const auto& p) { return p->desc.kill_height > -kInfinity; });
  if (kills) plan.add<&Impl::kill>(Rank::fluid_drain, "kill height", kName, m);
  const auto& first = m->pools.front()->desc;
  if (std::any_of(m->pools.begin(), m->pools.end(),
                  [&](const auto& p) { return p->desc.spacing != first.spacing || p->desc.density != first.density; }))
    plan.add<&Impl::check_fluids_that_meet>(Rank::check, "check fluids that meet", kName, m);
  if (!m->interfaces.empty()) plan.add<&Impl::check_interfaces>(Rank::check, "check interfaces", kName, m);
  plan.add<&Impl::check>(Rank::check, "check fluids", kName, m);
}

std::size_t Fluid::count() const {
  std::size_t sum = 0;
  for (const auto& p : impl_->pools) sum += p->count;
  return sum;
}

ObjectId Fluid::add_fluid(const FluidDesc& desc) {
  const Command command(impl_->commands, "fluid.add_fluid", desc);
  check_desc(desc);
  find_variant(fluid_solvers(), desc.solver, "fluid solver");
  Impl& m = *impl_;
  auto p = std::make_unique<FluidPool>(m.arena, desc, m.dimension);
  m.check_suits(*p);
  if (p->colored && !m.solver_of(*p).bears_color_field())
    throw SceneError("fluid: surface_model: expected \"cohesion\" with solver \"" + desc.solver +
                     "\", whose surface would crowd until it has no tension, got \"color_field\"");
  if (desc.negative_pressure > 0 && !m.solver_of(*p).bears_suction())
    throw SceneError("fluid: negative_pressure: expected 0 with solver \"" + desc.solver +
                     "\", which cannot tell suction from a free surface; take the default solver");
  p->object = m.objects.add(kFluidKind, static_cast<std::uint32_t>(m.pools.size()), desc.name, desc.tags);
  m.solver_of(*p).keep(*p);
  m.pools.push_back(std::move(p));
  *m.structure_changed = true;
  return m.pools.back()->object;
}

void Fluid::destroy_fluid(ObjectId id, std::string where) {
  const Command command(impl_->commands, "fluid.destroy_fluid", id, where);
  Impl& m = *impl_;
  std::vector<ObjectId> emitters, drains;
  for (const FluidEmitter& e : m.emitters)
    if (e.fluid == id) emitters.push_back(e.object);
  for (const FluidDrain& d : m.drains)
    if (d.fluid == id) drains.push_back(d.object);
  for (const ObjectId e : emitters) destroy_emitter(e, where);
  for (const ObjectId d : drains) destroy_drain(d, where);
  FEDER_ASSERT(
      std::none_of(m.emitters.begin(), m.emitters.end(), [&](const FluidEmitter& e) { return e.fluid == id; }));
  FEDER_ASSERT(std::none_of(m.drains.begin(), m.drains.end(), [&](const FluidDrain& d) { return d.fluid == id; }));
  std::erase_if(m.interfaces, [&](const FluidInterface& f) { return f.a == id || f.b == id; });
  m.destroy(m.pools, id, std::move(where));
}

// A lattice of whole cells in the shape's box: centred in it along x and z, from its bottom upwards along y.
std::size_t Fluid::fill(ObjectId id, const Shape& shape, const Pose& pose, const Vec3& velocity) {
  const Command command(impl_->commands, "fluid.fill", id, shape, pose, velocity);
  FluidPool& p = impl_->pool(id);
  check_pose(pose, "fluid: fill");
  const Aabb box = shape.bounds(Pose{});
  const double d = p.desc.spacing;
  // cells along each axis, and the middle of the first
  int cells[3];
  Vec3 first;
  double total = 1, narrowest = d;
  for (int k = 0; k < 3; ++k) {
    const double size = static_cast<double>(box.hi[k]) - static_cast<double>(box.lo[k]);
    if (!(size < 1e9)) throw SceneError("fluid: fill: expected a shape of finite size");
    const bool counts = k < p.dimension;
    if (counts && size < kLeastWidth * d)
      throw SceneError("fluid: fill: the shape is " + print_value(static_cast<float>(size)) + " m wide along " +
                       "xyz"[k] + ", narrower than the spacing of " + print_value(p.desc.spacing) +
                       " m: take a smaller spacing or a larger shape");
    if (counts && size < 0.99 * d) narrowest = std::min(narrowest, size);
    const double n = k == 2 && p.dimension == 2 ? 1 : std::max(1.0, std::floor(size / d + 0.01));
    total *= n;
    if (total > 2e9)
      throw SceneError("fluid: fill: the shape holds too many particles of spacing " + std::to_string(d));
    cells[k] = static_cast<int>(n);
    const double low = box.lo[k], middle = (low + static_cast<double>(box.hi[k])) / 2;
    first[k] = static_cast<Real>(k == 1 && n * d < size ? low + d / 2 : middle - (n - 1) * d / 2);
    if (k == 2 && p.dimension == 2) first[k] = 0;
  }
  // those whose middle lies in the shape
  std::vector<Vec3> points;
  for (int z = 0; z < cells[2]; ++z)
    for (int y = 0; y < cells[1]; ++y)
      for (int x = 0; x < cells[0]; ++x) {
        const Vec3 at = first + p.desc.spacing * vec3(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z));
        Vec3 n;
        if (shape.distance(at, p.desc.spacing, n) < 0) points.push_back(to_world(pose, at));
        if (p.count + points.size() > p.desc.max_particles)
          throw SceneError("fluid: fill: expected at most max_particles = " + std::to_string(p.desc.max_particles) +
                           ", the shape holds more, beside " + std::to_string(p.count) + " that are there");
      }
  const std::size_t made = fill(id, points, velocity);
  if (narrowest < d && made > 0) p.filled_width = static_cast<Real>(narrowest);
  return made;
}

std::size_t Fluid::fill(ObjectId id, std::span<const Vec3> points, const Vec3& velocity) {
  const Command command(impl_->commands, "fluid.fill_points", id, points, velocity);
  Impl& m = *impl_;
  FluidPool& p = m.pool(id);
  if (!is_finite(velocity)) throw SceneError("fluid: fill: expected a finite velocity");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_finite(points[i]))
      throw SceneError("fluid: fill: expected finite points, but point " + std::to_string(i + 1) + " is not");
  if (p.count + points.size() > p.desc.max_particles)
    throw SceneError("fluid: fill: expected at most max_particles = " + std::to_string(p.desc.max_particles) +
                     ", got " + std::to_string(p.count) + " + " + std::to_string(points.size()));
  p.grow(p.count + static_cast<std::uint32_t>(points.size()));
  for (const Vec3& x : points) {
    // displaced by a thousandth of a spacing, by its id: particles in the same position could not push each other apart
    Rng rng(p.next_id);
    const Real e = Real(1e-3) * p.desc.spacing;
    const Real dx = rng.uniform(-e, e), dy = rng.uniform(-e, e), dz = rng.uniform(-e, e);
    p.add(vec3(x[0] + dx, x[1] + dy, p.dimension == 2 ? Real(0) : x[2] + dz), velocity);
  }
  FEDER_ASSERT(p.next_id >= p.count);
  m.wake(p, WakeCause::script, {});
  p.fresh = true;
  p.crowded = kScriptWindow;
  *m.structure_changed = true;
  return points.size();
}

std::size_t Fluid::particle_count(ObjectId id) const { return impl_->pool(id).count; }
Real Fluid::particle_mass(ObjectId id) const { return impl_->pool(id).mass; }
FluidDesc Fluid::desc(ObjectId id) const { return impl_->pool(id).desc; }
Boundary& Fluid::boundary() { return impl_->boundary; }

bool Fluid::asleep(ObjectId id) const { return impl_->pool(id).asleep; }

void Fluid::wake(ObjectId id, WakeCause cause, ObjectId other) {
  const Command command(impl_->commands, "fluid.wake", id, cause, other);
  impl_->wake(impl_->pool(id), cause, other);
}

std::size_t Fluid::pool_count() const { return impl_->pools.size(); }

FluidPool& Fluid::pool_at(std::size_t n) {
  FEDER_ASSERT(n < impl_->pools.size());
  return *impl_->pools[n];
}

void Fluid::set_velocities(ObjectId id, std::span<const Vec3> v) {
  const Command command(impl_->commands, "fluid.set_velocities", id, v);
  FluidPool& p = impl_->pool(id);
  if (v.size() != p.count)
    throw SceneError("set_velocities: expected " + std::to_string(p.count) + " velocities, one per particle, got " +
                     std::to_string(v.size()));
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!is_finite(v[i]))
      throw SceneError("set_velocities: expected finite numbers, but velocity " + std::to_string(i + 1) + " is not");
  const std::vector<std::uint32_t> order = impl_->by_id(p);
  FEDER_ASSERT(order.size() == v.size());
  impl_->wake(p, WakeCause::script, {});
  for (std::size_t k = 0; k < order.size(); ++k) p.v[order[k]].set(v[k]);
  p.kinetic = p.kinetic_energy();
}

}  // namespace feder
