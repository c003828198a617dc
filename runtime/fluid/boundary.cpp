// Contacts of particles with the boundary: tangent planes through the nearest points, found where the substep starts.
// While the particles move, distances are read from the planes, which follow their bodies. A convex solid lies wholly
// behind each of its planes, so a particle that stays in front of them cannot have passed it; where one comes behind a
// plane, the exact distance and a ray along its displacement decide (project_out).
// Kept between calls: nothing. Weak spot: a particle pressed between two solids that come nearer than twice the
// clearance cannot satisfy both; it stays out of the one that the fluid does not move, or of the last one.
#include <algorithm>
#include <cmath>
#include <utility>

#include "fluid/block_sums.h"

namespace feder {
namespace {

constexpr int kMaxShapes = 64;         // listed near a run of particles, before all are visited
constexpr int kProjectionRounds = 4;   // for corners of several solids, before one of those that do not give way
constexpr Real kSameFace = Real(0.7);  // cosine between normals of one surface, which turns on the way

struct NearShapes {
  std::uint32_t list[kMaxShapes];
  int count = 0;
  bool all = false;
};

// A mesh has no inside: whether a particle passed it follows from a ray along its displacement.
bool crosses(const BoundaryShape& w, const Vec3& from, const Vec3& to, RayHit& hit) {
  return w.shape->raycast(from, to - from, hit) && hit.fraction < 1;
}

}  // namespace

Real largest_motion(const Shape& shape, const Pose& a, const Pose& b) {
  // the chord of the difference of rotations, which are the same with either sign
  const Quat &p = a.rotation, &q = b.rotation;
  const Real side = dot(p.vec(), q.vec()) + p.w * q.w < 0 ? Real(-1) : Real(1), w = p.w - side * q.w;
  const Vec3 v = p.vec() - side * q.vec();
  const Real turn = 2 * std::sqrt(dot(v, v) + w * w);
  return length(Vec3(b.position - a.position)) + (turn > 0 ? turn * shape.extent(Vec3::Zero()) : Real(0));
}

void Boundary::start() {
  away = false;
  for (BoundaryShape& w : shapes) w.start = w.pose, w.away = false;
  for (BoundaryBody& b : bodies) b.start = b.center;
}

void Boundary::move_to(Real seconds) {
  if (seconds == 0 && !away) return;
  away = seconds != 0;
  for (BoundaryShape& w : shapes) {
    FEDER_ASSERT(w.body < bodies.size());
    const BoundaryBody& b = bodies[w.body];
    const bool rests = b.velocity.isZero(0) && b.angular_velocity.isZero(0);
    if (rests && !w.away) continue;
    w.away = !rests;
    const Quat rotation = integrate_rotation(Quat::identity(), seconds * b.angular_velocity);
    w.pose.position = b.start + rotate(rotation, Vec3(w.start.position - b.start)) + seconds * b.velocity;
    w.pose.rotation = integrate_rotation(w.start.rotation, seconds * b.angular_velocity);
    w.box = w.shape->bounds(w.pose);
  }
  for (BoundaryBody& b : bodies) b.center = b.start + seconds * b.velocity;
}

void FluidPool::find_contacts(JobPool& jobs, const Boundary& boundary, Real speculative_time, const Vec3& gravity,
                              bool push_out) {
  FEDER_ASSERT(speculative_time >= 0 && contact_first.size() > count);
  const Real fall = length(gravity) * speculative_time * speculative_time;
  const auto swept_bounds = [&](std::uint32_t i, const BoundaryBody& b) {
    return support + fall + speculative_time * length(Vec3(v[i].vec() - b.velocity_at(start[i].vec())));
  };
  // broad phase: shapes that a run of neighbouring particles may meet
  const auto near_shapes = [&](std::uint32_t first, std::uint32_t last, NearShapes& near) {
    Aabb box;
    Real speed2 = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      box.include(start[i].vec());
      speed2 = std::max(speed2, dot(v[i].vec(), v[i].vec()));
    }
    const Real speed = std::sqrt(speed2);
    for (std::uint32_t w = 0; w < boundary.shapes.size(); ++w) {
      const BoundaryShape& solid = boundary.shapes[w];
      const BoundaryBody& b = boundary.bodies[solid.body];
      if (!meets(solid)) continue;
      Aabb wide = solid.box;
      wide.grow(support + fall + speculative_time * (speed + length(b.velocity) + solid.rim_speed(b)));
      if (!overlaps(wide, box)) continue;
      if (near.count == kMaxShapes) {
        near.all = true;
        return;
      }
      near.list[near.count++] = w;
    }
  };
  // narrow phase: f(shape, distance, position and normal in its frame) for those near particle i
  const auto visit = [&](std::uint32_t i, const NearShapes& near, auto&& f) {
    const int n = near.all ? static_cast<int>(boundary.shapes.size()) : near.count;
    for (int k = 0; k < n; ++k) {
      const std::uint32_t w = near.all ? static_cast<std::uint32_t>(k) : near.list[k];
      const BoundaryShape& solid = boundary.shapes[w];
      if (!meets(solid)) continue;
      const Real margin = swept_bounds(i, boundary.bodies[solid.body]);
      const Vec3 at = start[i].vec();
      if (is_mixture() && !fluid_of(i).meets(solid)) continue;
      Aabb box{at, at};
      box.grow(margin);
      if (!overlaps(box, solid.box)) continue;
      Vec3 n_local;
      const Vec3 local = to_local(solid.pose, at);
      const Real d = solid.shape->distance(local, margin, n_local);
      if (d < margin) f(w, d, local, n_local);
    }
  };
  constexpr JobGrain kRun{64, 3'000};  // particles that share a list of shapes
  found_pose.clear();
  fast_shapes.reserve(boundary.shapes.size());
  for (const BoundaryShape& w : boundary.shapes) found_pose.push_back(w.pose);

  // count the contacts of each particle; then the first index of each run
  block_first.resize(count / kRun.items + (count % kRun.items != 0));
  jobs.for_blocks(count, kRun, [&](std::uint32_t first, std::uint32_t last, int) {
    NearShapes near;
    near_shapes(first, last, near);
    std::uint32_t all = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      std::uint32_t n = 0;
      if (near.count > 0) visit(i, near, [&](std::uint32_t, Real, const Vec3&, const Vec3&) { ++n; });
      contact_first[i] = n;
      all += n;
    }
    block_first[first / kRun.items] = all;
  });
  std::uint32_t total = 0;
  for (std::uint32_t& n : block_first) total += std::exchange(n, total);
  contact_first[count] = total;
  if (contacts.size() < total) contacts.resize(total + total / 4);

  // fill them; with push_out, particles inside a solid leave it
  jobs.for_blocks(count, kRun, [&](std::uint32_t first, std::uint32_t last, int) {
    std::uint32_t at = block_first[first / kRun.items];
    const std::uint32_t next = last == count ? total : block_first[last / kRun.items];
    if (at == next) {
      std::fill(contact_first.begin() + first, contact_first.begin() + last, at);
      return;
    }
    NearShapes near;
    near_shapes(first, last, near);
    for (std::uint32_t i = first; i < last; ++i) {
      const std::uint32_t end = at + std::exchange(contact_first[i], at);
      if (at == end) continue;
      Vec3 out = Vec3::Zero();
      visit(i, near, [&](std::uint32_t w, Real d, const Vec3& local, const Vec3& n_local) {
        const BoundaryShape& solid = boundary.shapes[w];
        BoundaryContact& c = contacts[at++];
        c.shape = w, c.particle = i;
        FEDER_ASSERT(at <= end && is_direction(n_local));
        c.normal = rotate(solid.pose.rotation, n_local);
        c.offset = dot(c.normal, start[i].vec()) - d;
        c.local_normal = n_local;
        c.local_offset = dot(n_local, local) - d;
        c.from = d < clearance ? Vec3(local + (clearance - d) * n_local) : local;
        c.impulse = 0;
        if (d < clearance) out += (clearance - d) * c.normal;
      });
      FEDER_ASSERT(at == end);  // as many as were counted
      if (!push_out || out.isZero(0)) continue;
      // a solid has moved over it: the particle is moved, but not accelerated
      start[i].set(start[i].vec() + out);
      x[i].set(x[i].vec() + out);
    }
  });
  dynamic_contacts.clear();
  if (std::any_of(boundary.bodies.begin(), boundary.bodies.end(), [](const BoundaryBody& b) { return b.dynamic; }))
    for (std::uint32_t k = 0; k < total; ++k)
      if (boundary.body_of(contacts[k]).dynamic) dynamic_contacts.push_back(k);
  record_contact_states(boundary);
}

// Particles nearer than 0.75 spacings are in contact: at rest they lie half a spacing from the boundary.
void FluidPool::record_contact_states(const Boundary& boundary) {
  const std::uint32_t total = contact_first[count];
  const Real near = Real(0.75) * desc.spacing;
  const auto clear = [&](FluidPool& p) {
    if (p.contact_states.size() < boundary.bodies.size()) p.contact_states.resize(boundary.bodies.size());
    for (FluidContactState& t : p.contact_states) t.count = 0, t.point = t.normal = Vec3::Zero();
  };
  if (!is_mixture()) clear(*this);
  for (FluidPool* p : phases)
    if (p->mixed) clear(*p);
  for (std::uint32_t k = 0; k < total; ++k) {
    const BoundaryContact& c = contacts[k];
    const Vec3 position = x[c.particle].vec();
    if (dot(c.normal, position) - c.offset > near) continue;
    FEDER_ASSERT(c.particle < count && c.shape < boundary.shapes.size());
    FluidPool& own = is_mixture() ? *phases[phase[c.particle]] : *this;
    if (is_mixture() && !own.mixed) continue;  // queries only look
    FluidContactState& t = own.contact_states[boundary.shapes[c.shape].body];
    t.body = boundary.body_of(c).object;
    ++t.count;
    t.point += position, t.normal += c.normal;
    const Real closing = dot(c.normal, Vec3(boundary.body_of(c).velocity_at(position) - v[c.particle].vec()));
    t.speed = std::max(t.speed, closing);
  }
}

void FluidPool::weigh_fixed(Boundary& boundary, const StepContext& c) const {
  weigh_blocks(count, boundary, c, [&](std::uint32_t i, Vec3* impulses) {
    for (const BoundaryContact& k : contacts_of(i)) impulses[boundary.shapes[k.shape].body] -= k.impulse * k.normal;
  });
}

void FluidPool::share_bodies(Boundary& boundary) {
  for (const std::uint32_t k : dynamic_contacts) {
    FEDER_ASSERT(k < contact_first[count]);
    const BoundaryContact& c = contacts[k];
    const Real d = c.distance(x[c.particle].vec());
    boundary.body_of(c).contact_weight += table->at(d / support).slope / support;
    FEDER_ASSERT(!(boundary.body_of(c).contact_weight < 0));
  }
}

namespace {

// Whether a particle at `at` is nearer to the solid of its contact, where that is now, than the clearance: by the
// distance d along n.
bool falls_short(const FluidPool& p, const BoundaryShape& w, const BoundaryContact& c, const Vec3& at, Vec3& n,
                 Real& d) {
  const Vec3 plane = rotate(w.pose.rotation, c.local_normal);
  d = dot(plane, at - w.pose.position) - c.local_offset;
  const bool one_sided = w.shape->convex() || w.shape->extent(Vec3::Zero()) == kInfinity;
  if (d >= p.clearance && one_sided) return false;
  n = plane;
  // behind it: exact distance and the ray from where the contact was made
  const Vec3 local = to_local(w.pose, at);
  Vec3 exact;
  const Real near = w.shape->distance(local, p.support, exact);
  RayHit hit;
  if (crosses(w, c.from, local, hit)) {
    if (!one_sided) {
      Vec3 side = rotate(w.pose.rotation, hit.normal);
      if (dot(hit.normal, Vec3(local - c.from)) > 0) side = -side;
      n = side;
      d = dot(side, at - to_world(w.pose, Vec3(c.from + hit.fraction * (local - c.from))));
    }
  } else {
    if (near >= p.clearance) return false;
    const Vec3 now = rotate(w.pose.rotation, exact);
    if (dot(now, plane) > kSameFace) n = normalized_or(Vec3(plane + now), plane), d = near;
    // a convex solid pushes it back through the plane it came from: the nearest face may be another by now, with
    // another solid behind it
    else if (!one_sided)
      n = now, d = near;
  }
  return d < p.clearance;
}

}  // namespace

// Contacts are made for velocities that particles and bodies have before the fluid is solved, and bodies before they
// strike each other. Who has moved by more than half a support since then may meet what it has no contact with.
Real FluidPool::safe_travel() const { return (support - clearance) / 2; }

void FluidPool::find_fast_shapes(const Boundary& boundary) {
  swept_shape.clear(), fast_shapes.clear();
  if (found_pose.size() != boundary.shapes.size()) found_pose.clear();  // no contacts were ever found
  for (std::uint32_t w = 0; w < found_pose.size(); ++w) {
    const BoundaryShape& solid = boundary.shapes[w];
    Aabb box = solid.box;
    if (largest_motion(*solid.shape, found_pose[w], solid.pose) > safe_travel()) {
      box.include(solid.shape->bounds(found_pose[w]));
      box.grow(support);  // on its arc
      fast_shapes.push_back(w);
    } else {
      box.grow(safe_travel());
    }
    swept_shape.push_back(box);
  }
}

// f(contact) for the contacts that particle i would have if they had been found for its motion and that of the solids.
template <class F>
void FluidPool::each_missed(std::uint32_t i, const Boundary& boundary, F&& f) const {
  const Vec3 from = start[i].vec(), to = x[i].vec(), travel = to - from;
  const bool fast = dot(travel, travel) > safe_travel() * safe_travel();
  if (!fast && fast_shapes.empty()) return;
  const std::uint32_t n = static_cast<std::uint32_t>(fast ? swept_shape.size() : fast_shapes.size());
  Aabb path{from.cwiseMin(to), from.cwiseMax(to)};
  path.grow(clearance);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t w = fast ? k : fast_shapes[k];
    const BoundaryShape& solid = boundary.shapes[w];
    if (!overlaps(path, swept_shape[w]) || !fluid_of(i).meets(solid)) continue;
    const std::span<const BoundaryContact> own = contacts_of(i);
    if (std::any_of(own.begin(), own.end(), [&](const BoundaryContact& c) { return c.shape == w; })) continue;
    const Vec3 local = to_local(found_pose[w], from);
    const Real limit = length(Vec3(to_local(solid.pose, to) - local)) + 2 * clearance;
    BoundaryContact c;
    const Real d = solid.shape->distance(local, limit, c.local_normal);
    if (d >= limit) continue;
    c.shape = w, c.particle = i;
    c.local_offset = dot(c.local_normal, local) - d;
    c.from = d < clearance ? Vec3(local + (clearance - d) * c.local_normal) : local;
    f(c);
  }
}

void FluidPool::project_out(Boundary& boundary, JobPool& jobs, bool velocities) {
  find_fast_shapes(boundary);
  // whom the boundary has to move follows from positions and poses alone; those few are moved in order, as each changes
  // the velocities of the bodies that the next one meets
  jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      // solids may be turned out of the plane by a rounding error, which particles would make more of
      if (dimension == 2) x[i].z = v[i].z = 0;
      inside[i] = 0;
      Vec3 n;
      Real d;
      const auto short_of = [&](const BoundaryContact& c) {
        inside[i] = inside[i] || falls_short(*this, boundary.shapes[c.shape], c, x[i].vec(), n, d);
      };
      for (const BoundaryContact& c : contacts_of(i)) {
        short_of(c);
        if (inside[i]) break;
      }
      if (!inside[i]) each_missed(i, boundary, short_of);
    }
  });
  const auto end = inside.begin() + count;
  for (auto at = std::find(inside.begin(), end, 1); at != end; at = std::find(at + 1, end, 1))
    move_out(static_cast<std::uint32_t>(at - inside.begin()), boundary, velocities);
}

void FluidPool::move_out(std::uint32_t i, Boundary& boundary, bool velocities) {
  bool moved = true;
  for (int round = 0; round <= kProjectionRounds && moved; ++round) {
    moved = false;
    const bool last = round == kProjectionRounds;  // what does not give way has the last word
    const auto leave = [&](const BoundaryContact& c) {
      if (last && boundary.body_of(c).dynamic) return;
      FEDER_ASSERT(c.particle == i && c.shape < boundary.shapes.size());
      const BoundaryShape& w = boundary.shapes[c.shape];
      const Vec3 at = x[i].vec();
      Vec3 n;
      Real d;
      if (!falls_short(*this, w, c, at, n, d)) return;
      // position, then the closing velocity
      x[i].set(at + (clearance - d) * n);
      moved = true;
      BoundaryBody& b = boundary.bodies[w.body];
      const Real closing = dot(n, v[i].vec() - b.velocity_at(x[i].vec()));
      if (closing >= 0 || !velocities) return;
      // fully plastic, by the masses of the pair: the body gains the momentum that the particle loses
      const Real own = mass_of(i);
      const Real taken = 1 / (1 + (b.dynamic ? own * b.response(x[i].vec(), n) : Real(0)));
      FEDER_ASSERT(!(taken < 0 || taken > Real(1.01)));
      const Vec3 p = (-closing * taken * own) * n;
      v[i].set(v[i].vec() + p / own);
      if (b.dynamic)
        b.push(x[i].vec(), -p);
      else
        b.impulse -= p;
    };
    for (const BoundaryContact& c : contacts_of(i)) leave(c);
    each_missed(i, boundary, leave);
  }
}

}  // namespace feder
