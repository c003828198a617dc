// The passes of the rope system. A substep of the world is divided into solver substeps, each an implicit step of the
// whole rope (rope/chain.h), which is stable whatever its number is. The number is chosen for what implicit Euler damps
// (a swing of frequency w by the damping ratio w h/2) and for the travel of points between searches for contact; it
// follows from the state, so none is kept.
#include <algorithm>
#include <cmath>

#include "rope/impl.h"
#include "state/angular_momentum.h"

namespace feder {
namespace {
constexpr Real kSwing = Real(0.008);       // largest h sqrt(g/L): half of it is the damping ratio of a slow swing
constexpr Real kTravel = Real(0.5);        // of the thickness: travel of a point in a solver substep
constexpr int kMaxSubsteps = 16;           // that are chosen
constexpr Real kSleepSpeed = Real(0.025);  // m/s, root mean square
constexpr Real kSleepTime = 1;             // s
constexpr Real kMemory = Real(0.5);        // s, of the moving average: about a swing
constexpr double kMissed = 5e-2;           // of a segment: a correction that Newton's method leaves in silence
constexpr Real kSameSide = Real(0.7);      // cosine of a contact's normal to its force before
constexpr Real kNearShare = Real(0.1);     // of the radius: contacts that press together on a body
}  // namespace

int Rope::Impl::wanted_substeps(const Line& l, const StepContext& c, Real fastest) const {
  if (l.settings.substeps > 0) return l.settings.substeps;
  const Real g = length(c.gravity) * std::abs(l.settings.gravity_scale);
  const Real wanted =
      std::max(c.h * std::sqrt(g / l.full_length) / kSwing, c.h * fastest / (2 * kTravel * l.settings.radius));
  return static_cast<int>(std::ceil(clamp(wanted, 1, kMaxSubsteps)));
}

// The surfaces of the ropes in this step, at rest where they start.
void Rope::Impl::show(StepContext& c) {
  drain_wakes();
  if (gravity_known && gravity != c.gravity)
    for (auto& l : lines) wake(*l, WakeCause::force, {});
  gravity = c.gravity, gravity_known = true;
  solves = 0;
  const SurfaceLinks* links = store.find<SurfaceLinks>();
  for (auto& p : lines) {
    Line& l = *p;
    l.bad_point = kNone, l.touched = false, l.missed = 0;
    l.kinetic_before = l.kinetic_energy(), l.began = l.position;
    Surface s;
    s.object = l.object;
    s.first = surfaces.claim(l.size()), s.count = s.total = l.size();
    s.edges = {l.edges[0].data(), 2, static_cast<std::uint32_t>(l.edges.size())};
    s.rest = l.rest.data();
    s.thickness = 2 * l.settings.radius, s.friction = l.settings.friction, s.wakes = kRopeCause;
    s.group = l.settings.group, s.mask = l.settings.mask;
    s.self = l.settings.self_collision != 0, s.active = l.active();
    s.sleep_candidate = l.state.sleep_steps != 0, s.pinned = l.any_pin;
    if (l.active() && l.state.fresh) {
      l.state.fresh = 0;
      if (!l.any_pin && !(links && links->names(l.object))) l.set_flight(c.gravity * l.settings.gravity_scale);
    }
    Real fastest = 0;
    for (std::uint32_t i = 0; i < l.size(); ++i) {
      const Real w = l.active() ? l.inv_mass[i] : Real(0);
      const Vec3 v = w != 0 ? l.velocity[i] : Vec3(0, 0, 0);
      surfaces.position[s.first + i] = l.position[i], surfaces.mass[s.first + i] = l.mass[i];
      surfaces.delta_position[s.first + i] = {0, 0, 0, w};
      surfaces.velocity[s.first + i] = {v[0], v[1], v[2], w};
      fastest = std::max(fastest, dot(v, v));
    }
    s.fastest = std::sqrt(fastest);
    if (l.active()) l.state.substeps = wanted_substeps(l, c, s.fastest);
    s.steps = l.state.substeps;
    l.linked = links && links->names(l.object);
    l.surface = static_cast<std::uint32_t>(surfaces.list.size());
    surfaces.list.push_back(s);
  }
}

// Velocities of the method: half a solver substep behind in free fall.
void Rope::Impl::gather(StepContext&) {
  for (auto& l : lines) {
    if (!l->active()) continue;
    const Surface& s = surfaces.list[l->surface];
    const Vec3 lead = Real(0.5) * surfaces.groups[s.loop]->step * l->flight();
    for (std::uint32_t i = 0; i < s.count; ++i)
      if (l->inv_mass[i] != 0) surfaces.velocity[s.first + i].set(l->velocity[i] - lead);
  }
}

void Rope::Impl::remember_bodies(StepContext&) {
  const SolverBodies& bodies = store.get<SolverBodies>();
  body_start.resize(bodies.state.size());
  for (std::size_t i = 0; i < bodies.state.size(); ++i) body_start[i] = bodies.state[i].velocity;
}

// A body has gravity's push of the whole substep from its start, but what carries it answers at the end, so its
// velocity in between is that of a fall that may not be. It is taken to move on as it did; of the push as much is its
// own as the ropes have answered to.
Vec3 Rope::Impl::body_velocity(std::uint32_t i, const StepContext& c) const {
  const Vec3 now = surfaces.solver_bodies->state[i].velocity;
  if (i >= body_start.size() || i >= body_pushed.size()) return now;
  const Vec3 push = body_pushed[i] - body_start[i];
  const Real square = dot(push, push), past = static_cast<Real>(c.inner.index) / static_cast<Real>(c.inner.count);
  const Real answered = square > 0 ? clamp(-dot(Vec3(now - body_pushed[i]), push) / square, 0, past) : Real(0);
  return now - (1 - answered) * push;
}

void Rope::Impl::begin_substep(StepContext& c) {
  drain_wakes();
  if (const SolverBodies* bodies = surfaces.solver_bodies) {
    body_pushed.resize(bodies->state.size());
    for (std::size_t i = 0; i < bodies->state.size(); ++i) body_pushed[i] = bodies->state[i].velocity;
  }
  for (auto& l : lines)
    if (l->active()) add_forces(*l, c);
}

// The rows of this rope alone against a solver body, as the chain wants them.
void Rope::Impl::list_contacts(Line& l, SurfaceGroup& g, const StepContext& c) {
  const Surface& s = surfaces.list[l.surface];
  contacts.clear();
  const Real h = g.step;
  for (std::uint32_t k = 0; k < g.rows.size(); ++k) {
    const SurfaceRow& r = g.rows[k];
    if (r.vertex[0] < s.first || r.vertex[0] >= s.first + s.count) continue;
    ChainContact n;
    n.row = k, n.first = r.vertex[0] - s.first;
    n.weight[0] = double(r.weight[0]), n.weight[1] = double(r.weight[1]);
    FEDER_ASSERT(r.weight[1] == 0 || r.vertex[1] == r.vertex[0] + 1);
    Vec3 d = Vec3::Zero(), body = Vec3::Zero();
    for (int j = 0; j < 2; ++j) d += r.weight[j] * surfaces.delta_position[r.vertex[j]].vec();
    if (r.solver_index != 0) {
      const SolverBody& b = surfaces.solver_bodies->state[r.solver_index];
      body = body_velocity(r.solver_index, c) + cross(b.angular_velocity, r.arm);
      if (c.inner.index > 0) d -= surfaces.body_displacement(r.solver_index, r.arm);
      // responses along the normal and two directions across, shared between those that press
      const Vec3 a = normalized_or(cross(r.normal, std::abs(r.normal[0]) < Real(0.6) ? Vec3(1, 0, 0) : Vec3(0, 1, 0)),
                                   Vec3(1, 0, 0));
      const Vec3 axes[3] = {r.normal, a, cross(r.normal, a)};
      double response[3];
      for (int j = 0; j < 3; ++j) response[j] = double(surfaces.body_response(r.solver_index, r.arm, axes[j]));
      const double hh = double(h) * double(h);
      n.compliance[0] = hh * response[0], n.compliance[1] = hh * std::max(response[1], response[2]);
    }
    n.normal = wide(r.normal);
    n.start_gap = double(r.offset) + double(dot(r.normal, d));
    n.gap = n.start_gap - double(h) * double(dot(r.normal, body));
    n.shift = double(h) * (wide(body) + wide(r.slide));
    n.friction = double(r.friction);
    // the force of before goes to one row that looks its way
    Vec3& force = (n.weight[1] != 0 ? l.segment_force : l.point_force)[n.first];
    if (dot(force, r.normal) > kSameSide * length(force)) n.force = wide(force), force = Vec3::Zero();
    contacts.push_back(n);
  }
  std::fill(l.point_force.begin(), l.point_force.end(), Vec3(0, 0, 0));
  std::fill(l.segment_force.begin(), l.segment_force.end(), Vec3(0, 0, 0));
  // several contacts with one body share its response
  for (ChainContact& n : contacts) {
    const std::uint32_t body = g.rows[n.row].solver_index;
    if (body == 0) continue;
    double sharing = 0;
    for (const ChainContact& o : contacts)
      sharing += g.rows[o.row].solver_index == body && o.start_gap < double(kNearShare * s.thickness) ? 1.0 : 0.0;
    for (double& x : n.compliance) x *= std::max(sharing, 1.0);
  }
}

// Bodies that this rope is attached to: what cannot move holds the point, the others move with it by their masses
// there, shared where a body hangs from several points. Gravity's push of the substep comes bit by bit.
void Rope::Impl::list_loads(Line& l, SurfaceGroup& g, const StepContext& c) {
  loads.clear();
  const Surface& s = surfaces.list[l.surface];
  const Real h = g.step;
  for (std::uint32_t n = 0; n < g.attachments.size(); ++n) {
    const SurfaceAttachment& a = g.attachments[n];
    if (a.vertex < s.first || a.vertex >= s.first + s.count) continue;
    const std::uint32_t i = a.vertex - s.first, body = a.solver_index;
    if (!(masses[i] < double(kInfinity))) continue;
    Vec3 v = Vec3::Zero();
    Mat3 response = Mat3::Zero();
    if (body != 0) {
      const SolverBody& b = surfaces.solver_bodies->state[body];
      const SolverMass& m = surfaces.solver_bodies->mass[body];
      const Mat3 arm = skew(a.arm);
      response = -(arm * m.inv_inertia * arm);
      response.diagonal() += m.inv_mass_axes;
      v = b.velocity + cross(b.angular_velocity, a.arm);
      const Real rest = 1 - static_cast<Real>(c.inner.index + 1) / static_cast<Real>(c.inner.count);
      if (body < body_start.size() && body < body_pushed.size()) v -= rest * (body_pushed[body] - body_start[body]);
      Real share = 0;
      for (const SurfaceAttachment& o : g.attachments) share += o.solver_index == body ? Real(1) : Real(0);
      response *= share;
    }
    if (!(response.trace() > 0)) {
      masses[i] = double(kInfinity);
      chain.guess[i] = chain.start[i] + wide(Vec3(h * v));
      continue;
    }
    ChainLoad load;
    load.point = i, load.attachment = n;
    const Mat3 mass = inverse(response);
    if (!is_finite(Vec3(mass.diagonal()))) continue;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) load.mass.m[3 * row + column] = double(mass(row, column));
    load.shift = wide(Vec3(h * v));
    loads.push_back(load);
  }
}

// What the loads' own motion lacks to that of their points goes to the bodies, before those move.
void Rope::Impl::hand_over_loads(Line& l, SurfaceGroup& g) {
  const Surface& s = surfaces.list[l.surface];
  for (const ChainLoad& n : loads) {
    const SurfaceAttachment& a = g.attachments[n.attachment];
    const std::uint32_t i = s.first + n.point;
    const Double3 d = wide(surfaces.delta_position[i].vec()) - wide(surfaces.before[i].vec()) - n.shift;
    const double* m = n.mass.m;
    const double rate = 1 / double(g.step);
    const Vec3 impulse =
        narrow({rate * (m[0] * d.x + m[1] * d.y + m[2] * d.z), rate * (m[3] * d.x + m[4] * d.y + m[5] * d.z),
                rate * (m[6] * d.x + m[7] * d.y + m[8] * d.z)});
    SolverBody& body = surfaces.solver_bodies->state[a.solver_index];
    const SolverMass& mass = surfaces.solver_bodies->mass[a.solver_index];
    body.velocity += mass.inv_mass_axes.cwiseProduct(impulse);
    body.angular_velocity += mass.inv_inertia * cross(a.arm, impulse);
  }
}

// Impulses of the contacts to the rows and to the bodies, before those move in this solver substep.
void Rope::Impl::hand_over(Line& l, SurfaceGroup& g) {
  for (const ChainContact& n : contacts) {
    if (!(n.pressed > 0)) continue;
    l.touched = true;
    SurfaceRow& r = g.rows[n.row];
    const Vec3 force = narrow(n.force);
    Vec3& kept = (n.weight[1] != 0 ? l.segment_force : l.point_force)[n.first];
    if (dot(force, force) > dot(kept, kept)) kept = force;
    if (r.impulse == 0) r.approach = static_cast<Real>(std::max((n.start_gap - n.gap) / double(g.step), 0.0));
    r.impulse += g.step * static_cast<Real>(n.pressed);
    if (r.solver_index == 0) continue;
    SolverBody& body = surfaces.solver_bodies->state[r.solver_index];
    const SolverMass& mass = surfaces.solver_bodies->mass[r.solver_index];
    const Vec3 push = -g.step * force;
    body.velocity += mass.inv_mass_axes.cwiseProduct(push);
    body.angular_velocity += mass.inv_inertia * cross(r.arm, push);
  }
}

void Rope::Impl::advance_line(Line& l, SurfaceGroup& g, StepContext& c) {
  const Surface& s = surfaces.list[l.surface];
  const std::uint32_t n = l.size();
  const double h = double(g.step);
  chain.resize(n), masses.resize(n);
  const Double3 origin = wide(surfaces.position[s.first]);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Row4& d = surfaces.delta_position[s.first + i];
    surfaces.before[s.first + i] = {d.x, d.y, d.z, 0};
    masses[i] = d.w != 0 ? double(l.mass[i]) : double(kInfinity);
    chain.start[i] = wide(surfaces.position[s.first + i]) - origin + wide(d.vec());
    chain.guess[i] = chain.start[i] + h * wide(surfaces.velocity[s.first + i].vec());
    chain.target[i] = chain.guess[i] + (h * h) * wide(l.acceleration[i]);
  }
  list_contacts(l, g, c);
  list_loads(l, g, c);
  ChainStep step;
  step.h = h, step.count = n;
  step.stretch = double(l.settings.stretch), step.bend = double(l.settings.bend);
  step.damping = double(l.settings.damping);
  step.rest_length = l.rest_length.data(), step.mass = masses.data();
  for (int k = 0; k < 2; ++k) {
    step.clamped[k] = l.state.clamped[k] != 0;
    step.direction[k] = {double(l.state.direction[k][0]), double(l.state.direction[k][1]),
                         double(l.state.direction[k][2])};
  }
  const Array<Double3>& end = chain.solve(step, contacts, loads);
  solves += static_cast<std::uint64_t>(chain.iterations);
  l.missed = std::max(l.missed, chain.missed);
  // displacements, and what the forces inside gave of angular momentum
  Double3 gained{0, 0, 0};
  for (std::uint32_t i = 0; i < n; ++i) {
    if (surfaces.delta_position[s.first + i].w == 0) continue;
    const Double3 moved = end[i] - chain.start[i];
    gained = gained + double(l.mass[i]) * cross(chain.start[i], end[i] - chain.target[i]);
    Row4& d = surfaces.delta_position[s.first + i];
    d.set(narrow(wide(d.vec()) + moved));
  }
  l.gained_momentum += narrow((1 / h) * gained);
  hand_over(l, g);
  hand_over_loads(l, g);
}

void Rope::Impl::advance(StepContext& c) {
  SurfaceGroup& g = group(c);
  each_active(g, [&](Line& l) {
    surfaces.row_updates += l.rest_length.size();
    advance_line(l, g, c);
  });
}

// Forces act where the solver substep ends, which is a torque about where it began; what that gave is taken out of a
// rope that nothing holds, as a rotation of the whole about its centre of mass.
void Rope::Impl::remove_gained_momentum(Line& l) {
  const Vec3 gained = l.gained_momentum;
  l.gained_momentum = Vec3::Zero();
  if (l.any_pin || l.touched || l.linked) return;
  const Surface& s = surfaces.list[l.surface];
  const auto place = [&](std::uint32_t i) {
    return Vec3(surfaces.position[s.first + i] - surfaces.position[s.first] +
                surfaces.delta_position[s.first + i].vec());
  };
  constexpr Real kRound = Real(0.0001);  // a straight rope has no inertia about its axis
  take_out_spin(
      gained, l.size(), l.total_mass, kRound, [&](std::uint32_t i) { return l.mass[i]; }, place,
      [&](std::uint32_t i, const Vec3& change) { surfaces.velocity[s.first + i].add(change); });
}

void Rope::Impl::read_velocities(StepContext& c) {
  const SurfaceGroup& g = group(c);
  each_active(g, [&](Line& l) {
    const Surface& s = surfaces.list[l.surface];
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
      if (surfaces.delta_position[i].w != 0)
        surfaces.velocity[i].set((surfaces.delta_position[i].vec() - surfaces.before[i].vec()) / g.step);
    if (c.inner.last()) remove_gained_momentum(l);
  });
}

void Rope::Impl::drain_wakes() {
  const auto ours = [&](ObjectId id) { return objects.alive(id) && objects.kind(id) == kRopeKind; };
  for (const Surfaces::Wake& w : surfaces.wakes)
    if (ours(w.object)) wake(line(w.object), w.cause, w.other);
  std::erase_if(surfaces.wakes, [&](const Surfaces::Wake& w) { return !objects.alive(w.object) || ours(w.object); });
}

void Rope::Impl::wake_touched(StepContext&) { drain_wakes(); }

void Rope::Impl::commit(StepContext& c) {
  std::string message;
  ObjectId bad;
  for (auto& p : lines) {
    Line& l = *p;
    if (!l.active()) continue;
    const Surface& s = surfaces.list[l.surface];
    const Vec3 flight = l.any_pin || l.touched || l.linked ? Vec3(0, 0, 0) : Vec3(c.gravity * l.settings.gravity_scale);
    const Vec3 lead = Real(0.5) * surfaces.groups[s.loop]->step * flight;
    for (std::uint32_t i = 0; i < l.size() && l.bad_point == kNone; ++i)
      if (!is_finite(Vec3(l.position[i] + surfaces.delta_position[s.first + i].vec())) ||
          !is_finite(surfaces.velocity[s.first + i].vec()))
        l.bad_point = i;
    if (l.bad_point != kNone) {  // quarantine: held where the step began
      l.state.frozen = 1;
      l.velocity.assign(l.size(), Vec3::Zero());
      message += (message.empty() ? "" : "; ") + objects.describe(l.object) + " point " +
                 std::to_string(l.bad_point + 1) + " went non-finite: the rope is held where it was";
      if (!bad) bad = l.object;
      watched.suspects.push_back({kName, l.object, l.kinetic_before, NAN, 0, 0, false, kRopeCure});
      continue;
    }
    for (std::uint32_t i = 0; i < l.size(); ++i) {
      if (surfaces.delta_position[s.first + i].w == 0) continue;
      l.position[i] += surfaces.delta_position[s.first + i].vec();
      l.velocity[i] = surfaces.velocity[s.first + i].vec() + lead;
    }
    l.set_flight(flight);
    watch(l, c);
    const double shortest = double(*std::min_element(l.rest_length.begin(), l.rest_length.end()));
    if (l.missed > kMissed * shortest && !l.state.warned) {
      l.state.warned = 1;
      events.warn("unconverged",
                  objects.describe(l.object) + ": Newton's method left a correction of " + print_number(l.missed) +
                      " m: more substeps would do, or less stretch or bend",
                  l.object);
    }
    update_sleep(l, c);
  }
  if (!message.empty()) events.warn("non_finite", message, bad);
}

void Rope::Impl::wake(Line& l, WakeCause cause, ObjectId other) {
  l.state.sleep_steps = 0;
  l.state.sleep_energy = kSleepSpeed * kSleepSpeed * 25;
  const bool slept = l.state.asleep != 0;
  l.state.asleep = 0;
  if (l.surface < surfaces.list.size() && surfaces.list[l.surface].object == l.object)
    surfaces.list[l.surface].sleep_candidate = false;
  if (slept) events.add_pending({.kind = EventKind::wake, .cause = cause, .a = l.object, .b = other});
}

void Rope::Impl::put_to_sleep(Line& l) {
  if (l.state.asleep || l.state.frozen) return;
  l.state.asleep = 1;
  l.set_flight(Vec3(0, 0, 0));
  l.velocity.assign(l.size(), Vec3::Zero());
  events.add_pending({.kind = EventKind::sleep, .a = l.object, .b = {}});
}

// Asleep when the mean kinetic energy per mass stays below that of kSleepSpeed for kSleepTime, under steady forces.
void Rope::Impl::update_sleep(Line& l, StepContext& c) {
  if (!c.sleeping) return;
  const Surface& s = surfaces.list[l.surface];
  Real energy = 0;
  for (std::uint32_t i = 0; i < l.size(); ++i) {
    const Vec3 v = surfaces.velocity[s.first + i].vec();
    energy += l.mass[i] * dot(v, v);
  }
  energy = Real(0.5) * energy / l.total_mass;
  const Real cap = kSleepSpeed * kSleepSpeed * 25, keep = 1 / (1 + c.dt / kMemory);
  l.state.sleep_energy = std::min(energy + (std::min(l.state.sleep_energy, cap) - energy) * keep, cap);
  bool steady = true;  // generators on areas may gust
  each_force(l, [&](const ForceEntry& f) { steady = steady && !f.force->on_area(); });
  if (!steady || l.state.sleep_energy > Real(0.5) * kSleepSpeed * kSleepSpeed) {
    l.state.sleep_steps = 0;
    return;
  }
  if (static_cast<Real>(++l.state.sleep_steps) * c.dt > kSleepTime) put_to_sleep(l);
}

}  // namespace feder
