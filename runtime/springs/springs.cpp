// The springs system: owner of nets. In each substep every net's integrator evaluates the net's forces; nets are
// independent, so they run in parallel, and what concerns others (events, warnings) is done afterwards, in order.
#include <cmath>

#include "base/wide.h"
#include "feder/net.h"
#include "integrate/integrator.h"
#include "springs/impl.h"
#include "state/particles.h"
#include "state/surface.h"
#include "state/surface_links.h"

namespace feder {
namespace {

void check_finite(const Vec3& v, const char* what) {
  if (!is_finite(v)) throw SceneError(std::string(what) + ": expected three finite numbers");
}

}  // namespace

const SystemDescriptor& Springs::descriptor() {
  static constexpr ObjectKind kinds[] = {kNetKind};
  static constexpr EventKind events[] = {kSpringBreak};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "points",
                                     .unit = "point",
                                     .shows = "surface",
                                     .kinds = kinds,
                                     .events = events,
                                     .make = &make_system<Springs>};
  return d;
}

Springs::Springs(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Springs::~Springs() = default;

void Springs::add_passes(StepPlan& plan) {
  if (impl_->nets.empty()) return;
  plan.add<&Impl::remember>(Rank::gather_points, "remember", kName, impl_.get());
  plan.add<&Impl::integrate>(Rank::net_integrate, "integrate", kName, impl_.get());
  plan.add<&Impl::finish>(Rank::check, "check nets", kName, impl_.get());
  const Surfaces* surfaces = impl_->store.find<Surfaces>();
  if (!surfaces || !surfaces->shows(kName)) return;
  plan.add<&Impl::show_surfaces>(Rank::net_surface, "surfaces", kName, impl_.get());
  plan.add<&Impl::mark_surfaces>(before(Rank::net_prepare), "mark", kName, impl_.get());
  plan.add<&Impl::coast_surfaces>(Rank::net_coast, "coast", kName, impl_.get());
  plan.add<&Impl::follow_surfaces>(Rank::net_follow, "follow contacts", kName, impl_.get());
}

std::size_t Springs::count() const { return impl_->particles.size(); }

std::uint32_t Springs::Impl::point(ObjectId id, std::size_t i) const {
  const Net& n = net(id);
  if (i >= n.points)
    throw SceneError(objects.describe(id) + ": expected a point number from 1 to " + std::to_string(n.points) +
                     ", got " + std::to_string(i + 1));
  return n.first + static_cast<std::uint32_t>(i);
}

std::uint32_t Springs::Impl::spring(ObjectId id, std::size_t k) const {
  const std::uint32_t size = net(id).springs.size();
  if (k >= size)
    throw SceneError(objects.describe(id) + ": expected a spring number from 1 to " + std::to_string(size) + ", got " +
                     std::to_string(k + 1));
  return static_cast<std::uint32_t>(k);
}

const SpringKernels& pick_kernels([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && runs_avx2()) return kSpringKernelsAvx2;
#endif
  return kSpringKernelsPlain;
}

std::unique_ptr<Net> Springs::Impl::make_net() {
  auto n = std::make_unique<Net>(arena, particles);
  n->layout.choose(kernels);
  return n;
}

void Springs::Impl::attach_integrator(Net& n, const std::string& name, const Params& options) {
  n.integrator = find_variant(integrators(), name, "integrator").make(arena, options);
  options.check_all_read(name);
  n.integrator_name = name;
  n.integrator_options = options;
}

ObjectId Springs::add_net(const NetDesc& desc) {
  const Command command(impl_->commands, "springs.add_net", desc);
  const std::string owner = desc.name.empty() ? "net" : "net '" + desc.name + "'";
  check_net(desc, owner);
  Impl& m = *impl_;
  auto n = m.make_net();
  m.attach_integrator(*n, desc.integrator, desc.integrator_options);
  n->settings = {desc.damping, desc.gravity_scale, desc.friction,      desc.restitution,
                 desc.group,   desc.mask,          desc.self_collision};
  n->faces.assign(desc.faces.begin(), desc.faces.end());
  if (desc.self_collision) n->rest_position.assign(desc.points.begin(), desc.points.end());
  for (std::size_t k = 0; k < desc.springs.size(); ++k) {
    const SpringDesc& s = desc.springs[k];
    n->springs.add(s, rest_length_of(s, desc.points[s.i], desc.points[s.j], k, owner));
    n->can_break = n->can_break || s.break_strain < kInfinity;
    n->has_power = n->has_power || s.power != 1;
  }

  // from here on nothing fails
  Particles& p = m.particles;
  FEDER_ASSERT(p.size() == (m.nets.empty() ? 0 : m.nets.back()->first + m.nets.back()->points));
  n->first = p.size();
  n->points = static_cast<std::uint32_t>(desc.points.size());
  n->object = m.objects.add(kNetKind, static_cast<std::uint32_t>(m.nets.size()), desc.name, desc.tags);
  const std::size_t size = n->first + n->points;
  Particles::each_array(p, [&](auto& array) { array.resize(size); });
  for (std::uint32_t i = 0; i < n->points; ++i) {
    const std::uint32_t at = n->first + i;
    p.place(at, desc.points[i]);
    p.start[at] = desc.points[i];
    p.velocity[at] = desc.velocities.empty() ? Vec3(0, 0, 0) : desc.velocities[i];
    p.mass[at] = p.inertia[at] = desc.masses[i];
    p.inv_mass[at] = 1 / desc.masses[i];
    p.radius[at] = desc.radius;
    p.net[at] = n->object;
    p.script_force[at] = Vec3::Zero();
    p.collider[at] = p.solver_slot[at] = kNone;
  }
  n->list_edges();
  m.nets.push_back(std::move(n));
  m.declare_surfaces();
  *m.structure_changed = true;
  return m.nets.back()->object;
}

void Springs::destroy_net(ObjectId id, std::string where) {
  const Command command(impl_->commands, "springs.destroy_net", id, where);
  Impl& m = *impl_;
  const std::uint32_t index = m.objects.index(id);
  const std::uint32_t first = m.nets[index]->first, count = m.nets[index]->points;
  for (std::uint32_t i = first; i < first + count; ++i)
    if (m.particles.collider[i] != kNone || m.particles.solver_slot[i] != kNone)
      m.removed.push_back({m.particles.collider[i], m.particles.solver_slot[i]});

  // later points, nets and attachments move down
  Particles::each_array(m.particles,
                        [&](auto& array) { array.erase(array.begin() + first, array.begin() + first + count); });
  std::erase_if(m.attachments, [&](const Attachment& a) { return a.net == id; });
  for (Attachment& a : m.attachments) {
    FEDER_ASSERT(a.point < first || a.point >= first + count);
    if (a.point > first) a.point -= count;
  }
  m.nets.erase(m.nets.begin() + index);
  for (std::uint32_t k = index; k < m.nets.size(); ++k) {
    m.nets[k]->first -= count;
    m.objects.set_index(m.nets[k]->object, k);
  }
  m.objects.remove(id, std::move(where));
  m.declare_surfaces();
  *m.structure_changed = true;
}

std::vector<Springs::Removed>& Springs::removed() { return impl_->removed; }
std::size_t Springs::point_count(ObjectId id) const { return impl_->net(id).points; }
std::size_t Springs::spring_count(ObjectId id) const { return impl_->net(id).springs.size(); }

Vec3 Springs::point(ObjectId id, std::size_t i) const { return impl_->particles.position[impl_->point(id, i)]; }
Vec3 Springs::velocity(ObjectId id, std::size_t i) const { return impl_->particles.velocity[impl_->point(id, i)]; }
Real Springs::point_mass(ObjectId id, std::size_t i) const { return impl_->particles.mass[impl_->point(id, i)]; }
bool Springs::pinned(ObjectId id, std::size_t i) const { return impl_->particles.inv_mass[impl_->point(id, i)] == 0; }

void Springs::set_point(ObjectId id, std::size_t i, const Vec3& x) {
  const Command command(impl_->commands, "springs.set_point", id, i, x);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(x, "set_point");
  impl_->particles.place(at, x);
}

void Springs::set_velocity(ObjectId id, std::size_t i, const Vec3& v) {
  const Command command(impl_->commands, "springs.set_velocity", id, i, v);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(v, "set_velocity");
  if (impl_->particles.inv_mass[at] != 0) impl_->particles.velocity[at] = v;
  impl_->net(id).squares = -1;
}

void Springs::apply_impulse(ObjectId id, std::size_t i, const Vec3& impulse) {
  const Command command(impl_->commands, "springs.apply_impulse", id, i, impulse);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(impulse, "apply_impulse");
  impl_->particles.velocity[at] += impl_->particles.inv_mass[at] * impulse;
  impl_->net(id).squares = -1;
}

void Springs::pin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "springs.pin", id, i);
  const std::uint32_t at = impl_->point(id, i);
  impl_->particles.inv_mass[at] = 0;
  impl_->particles.velocity[at] = Vec3::Zero();
  impl_->net(id).checked_step = 0;
  impl_->net(id).squares = -1;
}

void Springs::unpin(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "springs.unpin", id, i);
  const std::uint32_t at = impl_->point(id, i);
  Net& n = impl_->net(id);
  if (n.frozen) return;
  impl_->particles.inv_mass[at] = 1 / impl_->particles.mass[at];
  n.checked_step = 0;
}

std::size_t Springs::add_spring(ObjectId id, const SpringDesc& spring) {
  const Command command(impl_->commands, "springs.add_spring", id, spring);
  Net& n = impl_->net(id);
  const std::string owner = impl_->objects.describe(id);
  check_spring(spring, n.points, n.springs.size(), owner);
  const Array<Vec3>& x = impl_->particles.position;
  n.springs.add(spring, rest_length_of(spring, x[n.first + spring.i], x[n.first + spring.j], n.springs.size(), owner));
  n.can_break = n.can_break || spring.break_strain < kInfinity;
  n.has_power = n.has_power || spring.power != 1;
  ++n.version;
  n.checked_step = 0;
  return n.springs.size() - 1;
}

void Springs::remove_spring(ObjectId id, std::size_t k) {
  const Command command(impl_->commands, "springs.remove_spring", id, k);
  impl_->net(id).remove_spring(impl_->spring(id, k));
}

Real Springs::strain(ObjectId id, std::size_t k) const { return impl_->net(id).strain(impl_->spring(id, k)); }

SpringDesc Springs::spring(ObjectId id, std::size_t k) const {
  const SpringArrays& s = impl_->net(id).springs;
  const std::uint32_t at = impl_->spring(id, k);
  return {s.i[at],
          s.j[at],
          s.stiffness[at],
          s.damping[at],
          s.rest_length[at],
          s.break_strain[at],
          s.tension_only[at] != 0,
          s.power[at]};
}

SpringView Springs::springs(ObjectId id) const {
  const SpringArrays& s = impl_->net(id).springs;
  return {s.i, s.j, s.rest_length, s.alive};
}

void Springs::positions(ObjectId id, std::vector<Vec3>& out) const {
  const Net& n = impl_->net(id);
  const auto begin = impl_->particles.position.begin() + n.first;
  out.assign(begin, begin + n.points);
}

IntegratorStats Springs::stats(ObjectId id) const { return impl_->net(id).integrator->stats; }

Real Springs::max_frequency(ObjectId id) const {
  double frequency = 0, decay = 0;
  impl_->net(id).bounds(frequency, decay);
  return static_cast<Real>(frequency);
}

bool Springs::quarantined(ObjectId id) const { return impl_->net(id).frozen; }

std::size_t Springs::net_count() const { return impl_->nets.size(); }

Springs::NetInfo Springs::net_info(std::size_t k) const {
  FEDER_ASSERT(k < impl_->nets.size());
  const Net& n = *impl_->nets[k];
  const NetSettings& s = n.settings;
  return {n.object,
          n.first,
          n.points,
          s.friction,
          s.restitution,
          s.group,
          s.mask,
          n.integrator->info().implicit,
          {n.faces.data(), n.faces.size()}};
}

void Springs::attach(ObjectId id, std::size_t i, ObjectId body, const Vec3& local) {
  const Command command(impl_->commands, "springs.attach", id, i, body, local);
  const std::uint32_t at = impl_->point(id, i);
  if (!impl_->objects.alive(body) || impl_->objects.kind(body) != kBodyKind)
    throw SceneError("attach: expected a living body, got " + impl_->objects.describe(body));
  check_finite(local, "attach");
  detach(id, i);
  impl_->attachments.push_back({id, body, at, local});
  *impl_->structure_changed = true;
}

void Springs::attach_point(ObjectId id, std::size_t i, ObjectId other, std::size_t j) {
  const Command command(impl_->commands, "springs.attach_point", id, i, other, j);
  const std::uint32_t at = impl_->point(id, i);
  if (!(impl_->particles.radius[at] > 0))
    throw SceneError("attach: expected a net that collides (radius above 0), got " + impl_->objects.describe(id));
  hold_point(impl_->store, impl_->objects, id, i, other, j, Vec3(0, 0, 0));
  *impl_->structure_changed = true;
}

void Springs::detach(ObjectId id, std::size_t i) {
  const Command command(impl_->commands, "springs.detach", id, i);
  const std::uint32_t at = impl_->point(id, i);
  if (release_point(impl_->store, impl_->objects, id, i)) *impl_->structure_changed = true;
  if (std::erase_if(impl_->attachments, [&](const Attachment& a) { return a.point == at; }) > 0)
    *impl_->structure_changed = true;
}

const std::vector<Springs::Attachment>& Springs::attachments() const { return impl_->attachments; }

void Springs::set_script_force(ObjectId id, std::size_t i, const Vec3& force) {
  const Command command(impl_->commands, "springs.set_script_force", id, i, force);
  const std::uint32_t at = impl_->point(id, i);
  check_finite(force, "force");
  impl_->particles.script_force[at] = force;
}

void Springs::clear_script_forces() {
  const Command command(impl_->commands, "springs.clear_script_forces");
  for (Vec3& f : impl_->particles.script_force) f = Vec3::Zero();
}

}  // namespace feder
