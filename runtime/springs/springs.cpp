// The springs system: owner of nets. Each substep every net's integrator pulls the net's forces; nets are
// independent, so they run in parallel and everything that leaves a net (events, warnings) is done after, in order.
#include "springs/springs.h"

#include <cmath>

#include "base/assert.h"
#include "springs/impl.h"

namespace feder {
namespace {

constexpr std::size_t kMaxPoints = 1u << 28;

std::string number(double x) {
  std::string s = std::to_string(x);
  return s;
}

void need(bool ok, const std::string& what, const char* expected, double got) {
  if (!ok) throw SceneError("net: " + what + ": expected " + expected + ", got " + number(got));
}

// Messages count from 1, as scripts do.
void check_spring(const SpringDesc& s, std::size_t points, std::size_t k) {
  const std::string what = "springs[" + std::to_string(k + 1) + "]";
  need(s.i < points, what, "point numbers from 1 to the number of points", static_cast<double>(s.i) + 1);
  need(s.j < points, what, "point numbers from 1 to the number of points", static_cast<double>(s.j) + 1);
  need(s.i != s.j, what, "two different points", static_cast<double>(s.i) + 1);
  need(s.stiffness >= 0 && is_finite(s.stiffness), what + ".stiffness", "a finite number, 0 or more", s.stiffness);
  need(s.damping >= 0 && is_finite(s.damping), what + ".damping", "a finite number, 0 or more", s.damping);
  need(is_finite(s.rest_length), what + ".rest_length", "a finite number", s.rest_length);
  need(s.break_strain > 0, what + ".break_strain", "a number above 0", s.break_strain);
}

Real rest_length_of(const SpringDesc& s, const Vec3& a, const Vec3& b, std::size_t k) {
  const Real rest = s.rest_length < 0 ? length(b - a) : s.rest_length;
  need(rest > 0 || std::isinf(s.break_strain), "springs[" + std::to_string(k + 1) + "].rest_length",
       "a length above 0 where break_strain is given", rest);
  return rest;
}

void check_net(const NetDesc& d) {
  const std::size_t n = d.points.size();
  need(n > 0 && n <= kMaxPoints, "points", "at least one point", static_cast<double>(n));
  need(d.masses.size() == n, "masses", "one mass per point", static_cast<double>(d.masses.size()));
  need(d.velocities.empty() || d.velocities.size() == n, "velocities", "one per point",
       static_cast<double>(d.velocities.size()));
  for (std::size_t i = 0; i < n; ++i) {
    const std::string at = "[" + std::to_string(i + 1) + "]";
    for (int k = 0; k < 3; ++k) {
      need(is_finite(d.points[i][k]), "points" + at, "finite numbers", d.points[i][k]);
      if (!d.velocities.empty())
        need(is_finite(d.velocities[i][k]), "velocities" + at, "finite numbers", d.velocities[i][k]);
    }
    need(d.masses[i] > 0 && is_finite(1 / d.masses[i]) && is_finite(d.masses[i]), "masses" + at,
         "a finite number above 0", d.masses[i]);
  }
  for (std::size_t k = 0; k < d.springs.size(); ++k) check_spring(d.springs[k], n, k);
  need(d.damping >= 0 && is_finite(d.damping), "damping", "a finite number, 0 or more", d.damping);
  need(d.radius >= 0 && is_finite(d.radius), "radius", "a finite number, 0 or more", d.radius);
  need(d.friction >= 0 && is_finite(d.friction), "friction", "a finite number, 0 or more", d.friction);
  need(d.restitution >= 0 && d.restitution <= 1, "restitution", "a number from 0 to 1", d.restitution);
  need(is_finite(d.gravity_scale), "gravity_scale", "a finite number", d.gravity_scale);
}

}  // namespace

const SystemDescriptor& Springs::descriptor() {
  static const SystemDescriptor d = {kName, {}, {}, [](SystemSetup& setup) -> std::unique_ptr<System> {
                                       return std::make_unique<Springs>(setup);
                                     }};
  return d;
}

Springs::Springs(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Springs::~Springs() = default;

void Springs::add_rows(StepPlan& plan) {
  if (impl_->nets.empty()) return;
  plan.add<&Impl::remember>(Stage::advance, When::before_substeps, 10, "remember", kName, impl_.get());
  plan.add<&Impl::integrate>(Stage::advance, When::each_substep, 20, "integrate", kName, impl_.get());
  plan.add<&Impl::finish>(Stage::finish, When::each_substep, 20, "check nets", kName, impl_.get());
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

void Springs::Impl::attach_integrator(Net& n, const std::string& name, const Params& options) {
  n.integrator = find_variant(integrators(), name, "integrator").make(arena, options);
  options.check_all_read(name);
  n.integrator_name = name;
  n.integrator_options = options;
}

ObjectId Springs::add_net(const NetDesc& desc) {
  check_net(desc);
  Impl& m = *impl_;
  auto n = std::make_unique<Net>(m.arena, m.particles);
  m.attach_integrator(*n, desc.integrator, desc.integrator_options);
  n->settings = {desc.damping, desc.gravity_scale, desc.friction, desc.restitution, desc.group, desc.mask};
  for (std::size_t k = 0; k < desc.springs.size(); ++k) {
    const SpringDesc& s = desc.springs[k];
    n->springs.add(s, rest_length_of(s, desc.points[s.i], desc.points[s.j], k));
    n->can_break = n->can_break || s.break_strain < kInfinity;
  }

  // nothing can fail any more
  Particles& p = m.particles;
  n->first = p.size();
  n->points = static_cast<std::uint32_t>(desc.points.size());
  n->object = m.objects.add(ObjectKind::net, static_cast<std::uint32_t>(m.nets.size()), desc.name, desc.tags);
  const std::size_t size = n->first + n->points;
  Particles::each_array(p, [&](auto& array) { array.resize(size); });
  for (std::uint32_t i = 0; i < n->points; ++i) {
    const std::uint32_t at = n->first + i;
    p.position[at] = p.start[at] = desc.points[i];
    p.velocity[at] = desc.velocities.empty() ? Vec3(0, 0, 0) : desc.velocities[i];
    p.mass[at] = p.inertia[at] = desc.masses[i];
    p.inv_mass[at] = 1 / desc.masses[i];
    p.radius[at] = desc.radius;
    p.net[at] = n->object;
    p.script_force[at] = Vec3::Zero();
    p.collider[at] = p.mover[at] = kNone;
  }
  m.nets.push_back(std::move(n));
  *m.structure_changed = true;
  return m.nets.back()->object;
}

void Springs::destroy_net(ObjectId id, std::string where) {
  Impl& m = *impl_;
  const std::uint32_t place = m.objects.index(id);
  const std::uint32_t first = m.nets[place]->first, count = m.nets[place]->points;
  if (on_remove) on_remove(on_remove_self, first, count);

  // later points, nets and attachments move down
  Particles::each_array(m.particles, [&](auto& array) {
    array.erase(array.begin() + first, array.begin() + first + count);
  });
  std::erase_if(m.attachments, [&](const Attachment& a) { return a.net == id; });
  for (Attachment& a : m.attachments)
    if (a.point > first) a.point -= count;
  m.nets.erase(m.nets.begin() + place);
  for (std::uint32_t k = place; k < m.nets.size(); ++k) {
    m.nets[k]->first -= count;
    m.objects.set_index(m.nets[k]->object, k);
  }
  m.objects.remove(id, std::move(where));
  *m.structure_changed = true;
}

std::size_t Springs::point_count(ObjectId id) const { return impl_->net(id).points; }
std::size_t Springs::spring_count(ObjectId id) const { return impl_->net(id).springs.size(); }

Vec3 Springs::point(ObjectId id, std::size_t i) const { return impl_->particles.position[impl_->point(id, i)]; }
Vec3 Springs::velocity(ObjectId id, std::size_t i) const { return impl_->particles.velocity[impl_->point(id, i)]; }
Real Springs::point_mass(ObjectId id, std::size_t i) const { return impl_->particles.mass[impl_->point(id, i)]; }
bool Springs::pinned(ObjectId id, std::size_t i) const { return impl_->particles.inv_mass[impl_->point(id, i)] == 0; }

void Springs::set_point(ObjectId id, std::size_t i, const Vec3& x) {
  const std::uint32_t at = impl_->point(id, i);
  if (!is_finite(x)) throw SceneError("set_point: expected three finite numbers");
  impl_->particles.position[at] = x;
}

void Springs::set_velocity(ObjectId id, std::size_t i, const Vec3& v) {
  const std::uint32_t at = impl_->point(id, i);
  if (!is_finite(v)) throw SceneError("set_velocity: expected three finite numbers");
  if (impl_->particles.inv_mass[at] != 0) impl_->particles.velocity[at] = v;
}

void Springs::apply_impulse(ObjectId id, std::size_t i, const Vec3& impulse) {
  const std::uint32_t at = impl_->point(id, i);
  if (!is_finite(impulse)) throw SceneError("apply_impulse: expected three finite numbers");
  impl_->particles.velocity[at] += impl_->particles.inv_mass[at] * impulse;
}

void Springs::pin(ObjectId id, std::size_t i) {
  const std::uint32_t at = impl_->point(id, i);
  impl_->particles.inv_mass[at] = 0;
  impl_->particles.velocity[at] = Vec3::Zero();
  impl_->net(id).checked_step = 0;
}

void Springs::unpin(ObjectId id, std::size_t i) {
  const std::uint32_t at = impl_->point(id, i);
  Net& n = impl_->net(id);
  if (n.frozen) return;
  impl_->particles.inv_mass[at] = 1 / impl_->particles.mass[at];
  n.checked_step = 0;
}

std::size_t Springs::add_spring(ObjectId id, const SpringDesc& spring) {
  Net& n = impl_->net(id);
  check_spring(spring, n.points, n.springs.size());
  const Array<Vec3>& x = impl_->particles.position;
  n.springs.add(spring, rest_length_of(spring, x[n.first + spring.i], x[n.first + spring.j], n.springs.size()));
  n.can_break = n.can_break || spring.break_strain < kInfinity;
  ++n.version;
  n.checked_step = 0;
  return n.springs.size() - 1;
}

void Springs::remove_spring(ObjectId id, std::size_t k) {
  impl_->net(id).springs.remove(impl_->spring(id, k));
  impl_->net(id).checked_step = 0;
}

Real Springs::strain(ObjectId id, std::size_t k) const { return impl_->net(id).strain(impl_->spring(id, k)); }

SpringDesc Springs::spring(ObjectId id, std::size_t k) const {
  const SpringArrays& s = impl_->net(id).springs;
  const std::uint32_t at = impl_->spring(id, k);
  return {s.i[at], s.j[at], s.stiffness[at], s.damping[at], s.rest_length[at], s.break_strain[at]};
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
  const Net& n = *impl_->nets[k];
  const NetSettings& s = n.settings;
  return {n.object, n.first, n.points, s.friction, s.restitution, s.group, s.mask, n.integrator->info().implicit};
}

void Springs::attach(ObjectId id, std::size_t i, ObjectId body, const Vec3& local) {
  const std::uint32_t at = impl_->point(id, i);
  if (!impl_->objects.alive(body) || impl_->objects.kind(body) != ObjectKind::body)
    throw SceneError("attach: expected a living body, got " + impl_->objects.describe(body));
  if (!is_finite(local)) throw SceneError("attach: expected three finite numbers");
  detach(id, i);
  impl_->attachments.push_back({id, body, at, local});
  *impl_->structure_changed = true;
}

void Springs::detach(ObjectId id, std::size_t i) {
  const std::uint32_t at = impl_->point(id, i);
  if (std::erase_if(impl_->attachments, [&](const Attachment& a) { return a.point == at; }) > 0)
    *impl_->structure_changed = true;
}

const std::vector<Springs::Attachment>& Springs::attachments() const { return impl_->attachments; }

void Springs::set_script_force(ObjectId id, std::size_t i, const Vec3& force) {
  const std::uint32_t at = impl_->point(id, i);
  if (!is_finite(force)) throw SceneError("force: expected three finite numbers");
  impl_->particles.script_force[at] = force;
}

void Springs::clear_script_forces() {
  for (Vec3& f : impl_->particles.script_force) f = Vec3::Zero();
}

}  // namespace feder
