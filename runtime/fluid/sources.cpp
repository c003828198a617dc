// Emitters and drains. An emitter adds particles one after another at the sites of a lattice over its nozzle, each at
// the exact time it is due: a particle that leaves the nozzle within a substep starts as far behind it as it would have
// been at the substep's start. A full jet adds a layer per spacing along the velocity, in two halves like the colours
// of a chessboard, the second half a spacing behind: so layers interlock. Flat ones would stay plates that drift apart
// where the jet gets faster; layers that are jittered at random are too dense in places, and the jet bursts. What rides
// on a body moves with it, and does not push back. Kept between steps: the clock of each emitter and how many particles
// it has made. Weak spot: within a substep a nozzle turns with its body only at the start.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "feder/body.h"
#include "fluid/impl.h"

namespace feder {
namespace {

constexpr double kRoomAhead = 0.25;  // s, of emission for which there is room
// The axes of a nozzle's lattice.
void nozzle_axes(const FluidEmitter& e, const FluidPool& p, Vec3& a, Vec3& b) {
  FEDER_ASSERT(is_direction(e.direction));
  if (p.dimension == 2)
    a = vec3(-e.direction[1], e.direction[0], 0), b = Vec3::Zero();
  else
    tangent_frame(e.direction, a, b);
}

}  // namespace

template <class F>
void Fluid::Impl::each_site(const FluidEmitter& e, const FluidPool& p, F&& f) {
  const Real d = p.desc.spacing;
  const int n = static_cast<int>(e.radius / d), depth = p.dimension == 2 ? 0 : n;
  Vec3 a, b;
  nozzle_axes(e, p, a, b);
  for (const bool late : {false, true})
    for (int i = -n; i <= n; ++i)
      for (int k = -depth; k <= depth; ++k)
        if ((i + k) % 2 != 0 ? late : !late)
          if (static_cast<Real>(i * i + k * k) * d * d <= e.radius * e.radius)
            if (!f(Vec3(static_cast<Real>(i) * d * a + static_cast<Real>(k) * d * b), late)) return;
}

std::uint64_t Fluid::Impl::site_count(const FluidEmitter& e, const FluidPool& p) {
  std::uint64_t count = 0;
  each_site(e, p, [&](const Vec3&, bool) { return ++count > 0; });
  return count;
}

double Fluid::Impl::full_rate(const FluidEmitter& e, const FluidPool& p) const {
  return static_cast<double>(site_count(e, p)) * static_cast<double>(e.speed) / static_cast<double>(p.desc.spacing);
}

void Fluid::Impl::make_room() {
  for (const FluidEmitter& e : emitters) {
    if (!e.running) continue;
    FluidPool& p = pool(e.fluid);
    const double rate = full_rate(e, p);
    double more = std::ceil(kRoomAhead * (e.rate > 0 ? std::min(rate, static_cast<double>(e.rate)) : rate)) + 64;
    FEDER_ASSERT(e.limit == 0 || e.made <= e.limit);
    if (e.limit > 0) more = std::min(more, static_cast<double>(e.limit - e.made));
    const double wanted = std::min(static_cast<double>(p.desc.max_particles), static_cast<double>(p.count) + more);
    p.grow(static_cast<std::uint32_t>(wanted));
  }
}

ObjectId Fluid::add_emitter(ObjectId fluid, const EmitterDesc& d) {
  const Command command(impl_->commands, "fluid.add_emitter", fluid, d);
  Impl& m = *impl_;
  const Need need{"emitter"};
  need(d.speed > 0 && is_finite(d.speed), "speed", "a finite number above 0", d.speed);
  need(d.radius >= 0 && is_finite(d.radius), "radius", "a finite number, 0 or more", d.radius);
  need(d.rate >= 0 && is_finite(d.rate), "rate", "a finite number, 0 or more", d.rate);
  need(is_finite(d.position) && is_finite(d.direction), "position", "finite numbers", 0);
  need(length(d.direction) > 0, "direction", "a vector that is not zero", 0);
  if (d.body) m.objects.index(d.body, kBodyKind);  // throws
  FluidEmitter e;
  e.fluid = fluid, e.body = d.body;
  e.position = e.local_position = d.position;
  e.direction = e.local_direction = normalized_or(d.direction, vec3(0, -1, 0));
  e.speed = d.speed, e.radius = d.radius, e.rate = d.rate, e.limit = d.limit;
  const FluidPool& p = m.pool(fluid);
  // the lattice of the nozzle is enumerated below, so its size is checked first
  const double across = static_cast<double>(d.radius) / static_cast<double>(p.desc.spacing);
  const double about = p.dimension == 2 ? 2 * across + 1 : 3.14159265 * across * across + 1;
  const std::string limit =
      "a nozzle of at most max_particles = " + std::to_string(p.desc.max_particles) + " particles";
  need(about <= 1.1 * static_cast<double>(p.desc.max_particles) + 10, "radius", limit, static_cast<double>(d.radius));
  need(Impl::site_count(e, p) <= p.desc.max_particles, "radius", limit, static_cast<double>(d.radius));
  if (static_cast<double>(d.rate) > m.full_rate(e, p) * 1.0001)
    throw SceneError("emitter: rate: expected at most " + std::to_string(m.full_rate(e, p)) +
                     " particles per second, what a jet of this speed and radius holds, got " + std::to_string(d.rate));
  e.object = m.objects.add(kEmitterKind, static_cast<std::uint32_t>(m.emitters.size()), d.name, d.tags);
  m.emitters.push_back(e);
  *m.structure_changed = true;
  return e.object;
}

ObjectId Fluid::add_drain(ObjectId fluid, std::string name, TagMask tags, ShapePtr shape, const Pose& pose,
                          ObjectId body) {
  const Command command(impl_->commands, "fluid.add_drain", fluid, name, tags, shape, pose, body);
  if (!shape) throw SceneError("drain: expected a shape");
  check_pose(pose, "drain");
  Impl& m = *impl_;
  if (body) m.objects.index(body, kBodyKind);  // throws
  FluidDrain d;
  d.fluid = fluid, d.body = body, d.local = pose;
  d.shape = static_cast<std::uint32_t>(m.shapes.size());
  d.pose = pose;
  d.object = m.objects.add(kDrainKind, static_cast<std::uint32_t>(m.drains.size()), std::move(name), tags);
  m.shapes.push_back(std::move(shape));
  m.drains.push_back(d);
  *m.structure_changed = true;
  return d.object;
}

void Fluid::destroy_emitter(ObjectId id, std::string where) {
  const Command command(impl_->commands, "fluid.destroy_emitter", id, where);
  impl_->destroy(impl_->emitters, id, std::move(where));
}

void Fluid::destroy_drain(ObjectId id, std::string where) {
  const Command command(impl_->commands, "fluid.destroy_drain", id, where);
  impl_->destroy(impl_->drains, id, std::move(where));
}

void Fluid::set_running(ObjectId id, bool running) {
  const Command command(impl_->commands, "fluid.set_running", id, running);
  FluidEmitter& e = impl_->emitter(id);
  e.running = running && !e.done;
  *impl_->structure_changed = true;
}

bool Fluid::running(ObjectId id) const { return impl_->emitter(id).running != 0; }

std::uint64_t Fluid::passed(ObjectId id) const {
  const std::uint32_t index = impl_->objects.index(id);
  return impl_->objects.kind(id) == kEmitterKind ? impl_->emitters[index].made : impl_->drains[index].taken;
}

ObjectId Fluid::fluid_of(ObjectId id) const {
  const std::uint32_t index = impl_->objects.index(id);
  return impl_->objects.kind(id) == kEmitterKind ? impl_->emitters[index].fluid : impl_->drains[index].fluid;
}

void Fluid::aim(ObjectId id, const Vec3& position, const Vec3& direction) {
  const Command command(impl_->commands, "fluid.aim", id, position, direction);
  if (!is_finite(position) || !is_finite(direction) || !(length(direction) > 0))
    throw SceneError("emitter: expected a finite position, and a direction that is not zero");
  FluidEmitter& e = impl_->emitter(id);
  e.position = e.local_position = position;
  e.direction = e.local_direction = normalized_or(direction, vec3(0, -1, 0));
}

void Fluid::list_carriers(Array<FluidCarrier>& out) const {
  const auto list = [&](ObjectId body) {
    const auto same = [&](const FluidCarrier& c) { return c.body == body; };
    if (body && impl_->objects.alive(body) && std::none_of(out.begin(), out.end(), same))
      out.push_back({.body = body, .pose = {}});
  };
  for (const FluidEmitter& e : impl_->emitters) list(e.body);
  for (const FluidDrain& d : impl_->drains) list(d.body);
}

void Fluid::carry(std::span<const FluidCarrier> carriers) {
  for (const FluidCarrier& c : carriers) {
    for (FluidEmitter& e : impl_->emitters) {
      if (e.body != c.body) continue;
      e.position = to_world(c.pose, e.local_position);
      e.direction = normalized_or(rotate(c.pose.rotation, e.local_direction), e.direction);
      e.angular_velocity = c.angular_velocity;
      e.velocity = c.velocity + cross(c.angular_velocity, Vec3(e.position - c.center));
    }
    for (FluidDrain& d : impl_->drains)
      if (d.body == c.body) d.pose = c.pose * d.local;
  }
}

void Fluid::Impl::stop_lost_sources(StepContext& c) {
  std::string message;
  ObjectId first;
  const auto stops = [&](ObjectId source, ObjectId& body) {
    if (!body || objects.alive(body)) return false;
    const std::string& where = objects.destroyed_at(body);
    message += (message.empty() ? "" : "; ") + objects.describe(source) + " stops: " + objects.describe(body) +
               ", which it rode on, was destroyed" + (where.empty() ? "" : " at " + where);
    if (!first) first = source;
    body = {};
    return true;
  };
  for (FluidEmitter& e : emitters)
    if (stops(e.object, e.body)) e.running = 0, e.done = 1;
  for (FluidDrain& d : drains)
    if (stops(d.object, d.body)) d.stopped = 1;
  if (!message.empty()) c.events->warn("source_lost", message + "; destroy it as well, or make another one", first);
}

void Fluid::Impl::emit(StepContext& c) {
  for (FluidEmitter& e : emitters)
    if (e.running) run_emitter(e, c);
}

void Fluid::Impl::run_emitter(FluidEmitter& e, StepContext& c) {
  FluidPool& p = pool(e.fluid);
  const Real d = p.desc.spacing;
  // sites are enumerated each time: no memory of their own
  const std::uint64_t count = site_count(e, p);
  FEDER_ASSERT(count > 0);  // the middle of the nozzle is one
  std::uint64_t early = 0;  // in the first half of a layer
  each_site(e, p, [&](const Vec3&, bool late) {
    early += !late;
    return !late;
  });
  // order of sites: steps of about the golden ratio of their number, made coprime to it, spread them evenly
  std::uint64_t stride = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(0.618 * static_cast<double>(count)));
  while (std::gcd(stride, count) != 1) ++stride;
  const auto site = [&](std::uint64_t number) {
    Vec3 found = Vec3::Zero();
    each_site(e, p, [&](const Vec3& offset, bool) {
      found = offset;
      return number-- > 0;
    });
    return found;
  };
  const double layer = static_cast<double>(d) / static_cast<double>(e.speed);
  const auto due = [&](std::uint64_t k) {
    if (e.rate > 0) return static_cast<double>(k) / static_cast<double>(e.rate);
    return (static_cast<double>(k / count) + (k % count < early ? 0 : 0.5)) * layer;
  };
  // particles due in this substep, while there is room
  const double until = e.clock + static_cast<double>(c.h);
  while (due(e.made) < until && (e.limit == 0 || e.made < e.limit)) {
    if (p.count == p.capacity()) {
      *structure_changed = true;  // arrays grow before the next step
      if (p.count < p.desc.max_particles) break;
      if (!p.warned_full)
        c.events->warn("fluid_full",
                       objects.describe(p.object) + " has max_particles = " + std::to_string(p.desc.max_particles) +
                           ": its emitters wait",
                       p.object);
      p.warned_full = true;
      return;  // the clock stands
    }
    const std::uint64_t number = e.rate > 0 ? e.made % count * stride % count : e.made % count;
    FEDER_ASSERT(number < count);
    const Real behind = static_cast<Real>((due(e.made) - e.clock) * static_cast<double>(e.speed));
    const Vec3 aside = site(number);
    p.add(e.position + aside - behind * e.direction,
          e.speed * e.direction + e.velocity + cross(e.angular_velocity, aside));
    ++e.made;
  }
  e.clock = until;
  if (p.capacity() - p.count < count + 64 && p.capacity() < p.desc.max_particles) *structure_changed = true;
  if (e.limit == 0 || e.made < e.limit) return;
  // its limit is reached
  e.running = 0, e.done = 1;
  const auto made = static_cast<std::uint32_t>(e.made);
  c.events->add({.kind = kEmitterDone, .a = e.object, .b = e.fluid, .index = made});
}

}  // namespace feder
