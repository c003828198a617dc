// The passes of the system of soft bodies. A substep of the world is divided into as many solver substeps as the solver
// needs to resolve the stiffness of the material, up to a cap: beyond it the body acts softer, and a warning says by
// how much. Kept between steps: the number chosen.
#include <algorithm>
#include <cmath>

#include "soft/impl.h"

namespace feder {
namespace {

// Of a body of at least so many tetrahedra solver substeps are dear; a smaller one may have more of them.
constexpr double kLarge = 5000, kUsual = 64, kMost = 1000;
constexpr double kWay = 0.75;     // of the girth: a fast body comes no farther in a solver substep, and is seen within
constexpr Real kMostDrag = 1000;  // of mass over the substep: more stops a point as well
constexpr Real kFaster = Real(0.1), kLeastFaster = Real(0.01);  // of the velocity, and m/s: the step of differences
constexpr double kNoticed = 0.99;                               // of the stiffness: less is a warning

int soft_cap(const SoftBody& b) {
  if (b.settings.max_substeps > 0) return b.settings.max_substeps;
  const double size = std::fmin(1, double(b.mesh.tetrahedra.size()) / kLarge);
  return static_cast<int>(std::fmin(kUsual / size, kMost));
}

Vec3 difference(const Vec3& v) {
  const Real speed = length(v);
  return speed > kLeastFaster / kFaster ? Vec3(kFaster * v) : Vec3(kLeastFaster, 0, 0);
}

}  // namespace

SoftView Soft::Impl::view(SoftBody& b) {
  SoftView v;
  v.mesh = &b.mesh;
  v.points = b.size();
  v.version = b.version, v.shape = b.shape;
  v.material = b.material, v.law = b.law, v.density = double(b.settings.density), v.damping = b.settings.damping;
  if (b.surface >= surfaces.list.size()) return v;
  const std::uint32_t first = surfaces.list[b.surface].first;
  v.position = surfaces.position.data() + first;
  v.delta_position = surfaces.delta_position.data() + first;
  v.before = surfaces.before.data() + first;
  v.velocity = surfaces.velocity.data() + first;
  v.acceleration = b.acceleration.data(), v.steady_contact = b.steady_contact.data();
  return v;
}

void Soft::Impl::warn_of_cap(SoftBody& b, double wanted, int cap) {
  wanted = std::ceil(wanted);
  const bool softer = b.share < kNoticed;
  if (b.state.warned || !(softer || (b.settings.substeps == 0 && wanted > cap))) return;
  b.state.warned = 1;
  const std::string cure = wanted <= 10000 ? "max_substeps = " + std::to_string(static_cast<int>(wanted)) +
                                                 " would do, or less young, or larger tetrahedra"
                                           : "less young or larger tetrahedra would do";
  events.warn("substep_cap",
              objects.describe(b.object) + " would need " + print_number(wanted) +
                  " solver substeps per substep, it has " + std::to_string(cap) + ": " +
                  (softer ? "it acts as if young were " + print_number(b.share * double(b.settings.young)) + " Pa"
                          : "contacts may push it in, and a fixed number of sweeps lags") +
                  ": " + cure,
              b.object);
}

void Soft::Impl::choose_substeps(SoftBody& b, StepContext& c) {
  if (b.settings.substeps > 0) {
    b.state.substeps = b.settings.substeps;
    return;
  }
  const double wanted = b.solver->wanted_substeps(view(b), c.h);
  b.state.substeps = static_cast<std::int32_t>(std::fmin(std::fmax(std::ceil(wanted), 1), soft_cap(b)));
}

// The surfaces of the bodies in this step, at rest where they start.
void Soft::Impl::show(StepContext& c) {
  drain_wakes();
  if (gravity_known && gravity != c.gravity)
    for (auto& b : bodies) wake(*b, WakeCause::force, {});
  gravity = c.gravity, gravity_known = true;
  const SurfaceLinks* links = store.find<SurfaceLinks>();
  for (auto& p : bodies) {
    SoftBody& b = *p;
    b.bad_point = kNone, b.touched = b.prepared = false;
    b.kinetic_before = b.kinetic_energy(), b.began = b.position;
    b.linked = links && links->names(b.object);
    if (b.active() && b.state.fresh) {
      b.state.fresh = 0;
      if (!b.any_pin && !b.linked) b.set_flight(c.gravity * b.settings.gravity_scale);
    }
    Surface s;
    s.object = b.object;
    // those that no face of the skin has are hidden, and the last is the spare point of empty lanes
    s.total = b.size() + 1, s.count = b.mesh.visible, s.inner = b.size() - s.count;
    s.first = surfaces.claim(s.total);
    s.triangles = {b.mesh.skin.data(), b.mesh.skin.size()};
    s.edges = {b.mesh.edges[0].data(), 2, static_cast<std::uint32_t>(b.mesh.edges.size())};
    s.version = b.version;
    s.rest = b.mesh.rest.data();
    s.thickness = b.settings.thickness, s.friction = b.settings.friction, s.wakes = kSoftCause;
    s.group = b.settings.group, s.mask = b.settings.mask;
    s.solid = true;
    s.self = b.settings.self_collision != 0, s.active = b.active(), s.search = b.search;
    s.sleep_candidate = b.state.sleep_steps != 0, s.pinned = b.any_pin;
    Real fastest = 0;
    for (std::uint32_t i = 0; i < b.size(); ++i) {
      const Real w = b.active() ? b.inv_mass[i] : Real(0);
      const Vec3 v = w != 0 ? b.velocity[i] : Vec3(0, 0, 0);
      surfaces.position[s.first + i] = b.position[i], surfaces.mass[s.first + i] = b.mass[i];
      surfaces.delta_position[s.first + i] = {0, 0, 0, w};
      surfaces.before[s.first + i] = {};
      surfaces.velocity[s.first + i] = {v[0], v[1], v[2], w};
      fastest = std::max(fastest, dot(v, v));
    }
    const std::uint32_t spare = s.first + b.size();
    surfaces.position[spare] = b.position[0], surfaces.mass[spare] = 0;
    surfaces.delta_position[spare] = surfaces.before[spare] = surfaces.velocity[spare] = {};
    s.fastest = std::sqrt(fastest);
    if (b.active()) choose_substeps(b, c);
    s.steps = b.state.substeps;
    if (b.settings.substeps == 0) s.most_steps = soft_cap(b), s.way = static_cast<Real>(kWay * b.mesh.girth);
    b.surface = static_cast<std::uint32_t>(surfaces.list.size());
    surfaces.list.push_back(s);
  }
}

// Velocities of the method, which lead or lag in free fall; and the solvers, for the step of their groups.
void Soft::Impl::gather(StepContext& c) {
  for (auto& p : bodies) {
    SoftBody& b = *p;
    if (!b.active()) continue;
    const Surface& s = surfaces.list[b.surface];
    const Real h = surfaces.groups[s.loop]->step;
    if (!(h > 0)) continue;
    const Vec3 lead = b.solver->lead() * h * b.flight();
    for (std::uint32_t i = 0; i < b.size(); ++i)
      if (b.inv_mass[i] != 0) surfaces.velocity[s.first + i].set(b.velocity[i] - lead);
    b.share = b.solver->prepare(view(b), h, c).share;
    b.prepared = true;
    warn_of_limits(b);
    warn_of_cap(b, b.solver->wanted_substeps(view(b), c.h), surfaces.groups[s.loop]->steps);
  }
}

MassPoint Soft::Impl::mass_point(const SoftBody& b, std::uint32_t i) const {
  const double volume = double(b.mass[i]) / double(b.settings.density);
  const double radius = std::cbrt(volume * 3 / (4 * double(kPi)));
  return {b.position[i], b.velocity[i], b.mass[i], static_cast<Real>(double(kPi) * radius * radius),
          static_cast<Real>(volume)};
}

// Generators are asked once per substep. What they say against the velocity changes within it, as the points swing in
// their solver substeps: held, it would lag and feed the swing. So it is linearised, F(v) = F(v0) - k (v - v0), and
// taken implicitly in each solver substep.
void Soft::Impl::add_forces(SoftBody& b, StepContext& c) {
  const Surface& s = surfaces.list[b.surface];
  const double time = c.time + static_cast<double>(c.substep) * static_cast<double>(c.h);
  const Vec3 g = c.gravity * b.settings.gravity_scale;
  forces.assign(b.script_force.begin(), b.script_force.end());
  points.clear(), b.kept.clear();
  each_force(b, [&](const ForceEntry& f) {
    if (f.force->on_area()) return add_wind(b, *f.force, time, c.h);
    const Real most = kMostDrag * store.get<Forces>().drag_share() / c.h;
    if (points.empty())
      for (std::uint32_t i = 0; i < b.size(); ++i) {
        MassPoint p = mass_point(b, i);
        p.position = surfaces.position[s.first + i] + surfaces.delta_position[s.first + i].vec();
        points.push_back(p);
      }
    for (std::uint32_t i = 0; i < b.size(); ++i)
      points[i].velocity = surfaces.velocity[s.first + i].vec(), points[i].most_drag = most * b.mass[i];
    f.force->add(points.data(), b.size(), time, forces.data());
    if (f.force->depends_on_velocity()) add_resistance(b, *f.force, time);
  });
  const Real h = surfaces.groups[s.loop]->step;
  for (std::uint32_t i = 0; i < b.size(); ++i) b.acceleration[i] = g + forces[i] * b.inv_mass[i];
  for (std::uint32_t i = 0; i < b.kept.size(); ++i) {
    const Real rate = b.kept[i] * b.inv_mass[i];  // 1/s
    b.kept[i] = 1 / (1 + h * rate);
    b.acceleration[i] = b.kept[i] * (b.acceleration[i] + rate * surfaces.velocity[s.first + i].vec());
  }
}

// Adds how the force grows against the velocity, from a difference, to `kept`, kg/s.
void Soft::Impl::add_resistance(SoftBody& b, const Force& force, double time) {
  b.kept.resize(b.size(), Real(0));
  as_is.assign(b.size(), Vec3(0, 0, 0)), faster.assign(b.size(), Vec3(0, 0, 0));
  force.add(points.data(), b.size(), time, as_is.data());
  for (MassPoint& p : points) p.velocity += difference(p.velocity);
  force.add(points.data(), b.size(), time, faster.data());
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    const Vec3 d = points[i].velocity - surfaces.velocity[surfaces.list[b.surface].first + i].vec();
    const Real along = -dot(Vec3(faster[i] - as_is[i]), d) / dot(d, d);
    if (along > 0) b.kept[i] += along;
  }
}

void Soft::Impl::begin_substep(StepContext& c) {
  drain_wakes();
  for (auto& b : bodies)
    if (b->active()) add_forces(*b, c);
}

void Soft::Impl::advance(StepContext& c) {
  const SurfaceGroup& g = group(c);
  each_active(g, [&](SoftBody& b) {
    surfaces.row_updates += b.mesh.tetrahedra.size();
    const std::uint32_t first = surfaces.list[b.surface].first;
    for (std::uint32_t i = 0; i < b.kept.size(); ++i)
      surfaces.velocity[first + i].set(b.kept[i] * surfaces.velocity[first + i].vec());
    b.solver->advance(view(b), g.step, c);
  });
}

// What contacts and attachments moved becomes velocity.
void Soft::Impl::read_velocities(StepContext& c) {
  const SurfaceGroup& g = group(c);
  each_active(g, [&](SoftBody& b) {
    const std::uint32_t first = surfaces.list[b.surface].first;
    for (std::uint32_t k = 0; k < b.size(); ++k) {
      const std::uint32_t i = first + k;
      if (surfaces.delta_position[i].w == 0) continue;
      const Vec3 u = (surfaces.delta_position[i].vec() - surfaces.before[i].vec()) / g.step;
      if (surfaces.before[i].w == 0) {  // what of it came by contact is not known
        surfaces.velocity[i].set(u);
        b.contact[k] = b.steady_contact[k] = Vec3::Zero();
        continue;
      }
      if (!u.isZero(0)) surfaces.velocity[i].add(u), b.touched = true;
      const Vec3 last = b.contact[k], now = u / g.step;
      // none where something hangs from it, which answers to the damping a step late
      const bool steady = !b.linked && dot(now, last) > 0;
      b.steady_contact[k] = steady ? (dot(now, now) < dot(last, last) ? now : last) : Vec3(0, 0, 0);
      b.contact[k] = now;
    }
    if (c.inner.last()) b.solver->damp(view(b), c.h, c);
  });
}

void Soft::Impl::check_shortfall(SoftBody& b) {
  if (b.state.warned_shortfall) return;
  const std::string what = b.solver->shortfall();
  if (what.empty()) return;
  b.state.warned_shortfall = 1;
  events.warn("unconverged", objects.describe(b.object) + ": " + b.solver_name + " " + what, b.object);
}

void Soft::Impl::warn_of_limits(SoftBody& b) {
  if (b.state.warned_limits) return;
  b.state.warned_limits = 1;
  const std::string what = b.solver->limits(view(b));
  if (!what.empty())
    events.warn("solver_limit", objects.describe(b.object) + ": " + b.solver_name + " " + what, b.object);
}

void Soft::Impl::check_inverted(SoftBody& b) {
  if (b.law->turns_back || b.state.warned_inverted) return;
  std::size_t count = 0;
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) count += tetrahedron_volume(b.corners(k)) <= 0;
  if (count == 0) return;
  b.state.warned_inverted = 1;
  events.warn("inverted",
              objects.describe(b.object) + ": " + std::to_string(count) + " of " +
                  std::to_string(b.mesh.tetrahedra.size()) + " tetrahedra are turned inside out, where " + b.law->name +
                  " is at rest too: they may stay so; elasticity = \"neo_hookean\" turns them back",
              b.object);
}

void Soft::Impl::commit(StepContext& c) {
  std::string message;
  ObjectId bad;
  for (auto& p : bodies) {
    SoftBody& b = *p;
    if (!b.active() || !b.prepared) continue;
    const Surface& s = surfaces.list[b.surface];
    const Vec3 flight = b.any_pin || b.touched || b.linked ? Vec3(0, 0, 0) : Vec3(c.gravity * b.settings.gravity_scale);
    const Vec3 lead = b.solver->lead() * surfaces.groups[s.loop]->step * flight;
    for (std::uint32_t i = 0; i < b.size() && b.bad_point == kNone; ++i)
      if (!is_finite(Vec3(b.position[i] + surfaces.delta_position[s.first + i].vec())) ||
          !is_finite(surfaces.velocity[s.first + i].vec()))
        b.bad_point = i;
    if (b.bad_point != kNone) {  // quarantine: held where the step began
      b.state.frozen = 1;
      for (auto* a : {&b.velocity, &b.contact, &b.steady_contact}) a->assign(b.size(), Vec3::Zero());
      message += (message.empty() ? "" : "; ") + objects.describe(b.object) + " point " +
                 std::to_string(b.bad_point + 1) + " went non-finite: the body is held where it was";
      if (!bad) bad = b.object;
      watched.suspects.push_back({kName, b.object, b.kinetic_before, NAN, 0, 0, false, kSoftCure});
      continue;
    }
    for (std::uint32_t i = 0; i < b.size(); ++i) {
      if (surfaces.delta_position[s.first + i].w == 0) continue;
      b.position[i] += surfaces.delta_position[s.first + i].vec();
      b.velocity[i] = surfaces.velocity[s.first + i].vec() + lead;
    }
    b.set_flight(flight);
    check_shortfall(b), check_inverted(b);
    watch(b, c);
    if (b.settings.flows()) flow(b, c);
    if (b.settings.fractures()) fracture(b);
    update_sleep(b, c);
  }
  if (!message.empty()) events.warn("non_finite", message, bad);
}

}  // namespace feder
