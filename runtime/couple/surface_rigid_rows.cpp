// Contact rows of a substep. A point is a ball of half the thickness, a triangle three points rounded by it, the edge
// of a surface without triangles two; all are tested against a collider by the narrow phase that bodies use. Triangles
// give rows only where a shape meets them between their corners (a ball, an edge, a tip), because corners have rows of
// their own; segments likewise. Speculative contacts: a pair within its motion of the substep gets a row before it is
// in contact. One that would pass more than part of the body's size is cast along its relative motion instead
// (conservative advancement): the normal is then that of the time of impact, so nothing tunnels, and nothing beside the
// path collides. A row acts at the cloth's point on both sides, so linear and angular momentum are passed on exactly. A
// pin within half the thickness of a shape, or inside it, cannot be pushed out: triangles at it may be as deep as the
// line from its depth to that of corners outside, and a point that is all but pinned gives no row. Kept between calls:
// nothing. Weak spot: normals are frozen until rows are made again (refresh_rows).
#include <algorithm>
#include <cmath>

#include "base/checks.h"
#include "couple/surface_rigid.h"
#include "couple/surface_triangle.h"
#include "narrow/narrow_phase.h"

namespace feder {
namespace {

constexpr Real kCastShare = Real(0.25);                   // of the body's half size: faster passes are cast
constexpr Real kSpeculativeDistance = 1;                  // thicknesses, as strained cloth snaps back by as much
constexpr Real kSpeculativeDistanceCoasting = Real(0.1);  // the same for surfaces that coast
constexpr Real kCorner = Real(0.95);     // barycentric weight above which a point is that of the corner
constexpr Real kFreeShare = Real(0.05);  // weight of free corners below which a point is that of the pinned ones

// Weights of the point of the triangle 0, b, c nearest to p.
void nearest_weights(const Vec3& p, const Vec3& b, const Vec3& c, Real (&w)[3]) {
  const Vec3 n = cross(b, c), q = closest_on_triangle(p, Vec3(0, 0, 0), b, c);
  const Real nn = dot(n, n);
  if (!(nn > 0)) return void((w[0] = 1, w[1] = w[2] = 0));
  w[1] = clamp(dot(n, cross(q, c)) / nn, 0, 1);
  w[2] = clamp(dot(n, cross(b, q)) / nn, 0, 1 - w[1]);
  w[0] = 1 - w[1] - w[2];
  FEDER_ASSERT(!(w[0] < Real(-1e-6)));
}

}  // namespace

void SurfaceRigid::make_rows(StepContext& c) {
  surfaces_.clear_rows();
  refreshing_ = kNone;
  speculative_time_ = c.h;
  cfl_number_.assign(surfaces_.group_count, 0);
  fill_rows(c);
}

// Where the CFL number of a group is above 1, rows are made anew several times in a substep: cloth wraps round a fast
// body.
void SurfaceRigid::refresh_rows(StepContext& c) {
  const int done = c.inner.index, count = c.inner.count;
  const std::size_t group = static_cast<std::size_t>(c.inner.group);
  if (done == 0 || cfl_number_.size() != surfaces_.group_count || !(cfl_number_[group] > 1)) return;
  // bounded before it becomes an int: the velocities of a cloth that diverges have no bound
  const int wanted = static_cast<int>(std::min(static_cast<Real>(count), 2 * cfl_number_[group]));
  FEDER_ASSERT(done > 0 && done < count);
  const int refreshes = std::min(count, wanted + 1), every = count / refreshes;
  if (done % every != 0) return;
  collect_group(group, c);
  Array<SurfaceRow>& rows = surfaces_.groups[group]->rows;
  std::erase_if(rows, [](const SurfaceRow& r) { return r.contact_state != kNone; });  // rows of fluids stay
  refreshing_ = static_cast<std::uint32_t>(group);
  speculative_time_ = c.h * static_cast<Real>(every) / static_cast<Real>(count);
  fill_rows(c);
  refreshing_ = kNone;
}

void SurfaceRigid::fill_rows(StepContext& c) {
  std::uint32_t collider = kNone, surface = kNone;
  bool wanted = true;
  BodyPose at;
  pin_depth_.assign(surfaces_.size(), 0);
  deep_pins_.clear();
  for (const Candidate& k : candidates_) {
    if (k.collider != collider || k.surface != surface) {
      FEDER_ASSERT(colliders_.meets(k.collider, surfaces_.list[k.surface].group, surfaces_.list[k.surface].mask));
      collider = k.collider, surface = k.surface;
      const std::size_t group = surfaces_.group_of(surface);
      wanted = !refreshing() || refreshing_ == group;
      if (wanted) at = body_pose(collider), at.box = colliders_.shape[collider]->bounds(at.pose);
      if (!refreshing()) surfaces_.groups[group]->use_body(at.solver_index);
      for (const std::uint32_t v : deep_pins_) pin_depth_[v] = 0;
      deep_pins_.clear();
    }
    if (!wanted) continue;
    k.corners == 1 ? point_rows(k, at, c) : k.corners == 2 ? segment_rows(k, at, c) : triangle_rows(k, at, c);
  }
}

// Depth of a pin in a collider that is not dynamic, half the thickness included. Its triangles come after it in the
// list.
void SurfaceRigid::measure_pin(const Candidate& k, const BodyPose& at, Real radius) {
  Vec3 normal;
  const Vec3 x = to_local(at.pose, current_position(k.index));
  const Real depth = radius - colliders_.shape[k.collider]->distance(x, radius, normal);
  if (!(depth > 0)) return;
  FEDER_ASSERT(pin_depth_[k.index] == 0);  // once for a collider
  pin_depth_[k.index] = depth;
  deep_pins_.push_back(k.index);
}

// `normal`: from the body to the cloth; `gap`: present distance beyond the thickness; `point`: on the cloth.
void SurfaceRigid::add_row(const Candidate& k, const BodyPose& at, const std::uint32_t (&v)[3], const Real (&weight)[3],
                           const Vec3& normal, Real gap, const Vec3& point) {
  const Surface& info = surfaces_.list[k.surface];
  FEDER_ASSERT(info.active);  // sleepers are woken instead
  FEDER_ASSERT(is_direction(normal) && sums_to(weight, 1));
  // vertices and weights; depths of pins are allowed for
  SurfaceRow r;
  Vec3 d = Vec3::Zero();
  Real free = 0;
  for (int i = 0; i < 3; ++i) {
    FEDER_ASSERT(v[i] - info.first < info.count);
    const Row4& x = surfaces_.delta_position[v[i]];
    r.vertex[i] = v[i], r.weight[i] = weight[i];
    d += weight[i] * x.vec();
    if (x.w != 0) free += weight[i];
    if (k.corners > 1) gap += weight[i] * pin_depth_[v[i]];
  }
  // all but pinned: only the body moves
  if (free < kFreeShare) {
    if (at.solver_index == 0) return;  // nothing here can move
    for (int i = 0; i < 3; ++i)
      if (surfaces_.delta_position[v[i]].w != 0) r.weight[i] = 0;
  }
  r.vertex[3] = v[0];
  r.normal = normal;
  r.solver_index = at.solver_index;
  r.arm = point - at.center;
  if (refreshing() && at.solver_index)
    d -= surfaces_.body_delta_position[at.solver_index] + cross(surfaces_.body_delta_rotation[at.solver_index], r.arm);
  // C = gap along the normal, linear in displacements since the start of the step
  r.offset = gap - dot(normal, d);
  r.friction = std::sqrt(info.friction * colliders_.friction_dynamic[k.collider]);
  const Vec3 slide = colliders_.surface_velocity[k.collider];
  if (!slide.isZero(0))
    r.slide = rotate(at.pose.rotation, rotate_inverse(colliders_.local[k.collider].rotation, slide));
  r.relaxation = info.relaxation;
  r.contact_state = state_of(info, colliders_.object[k.collider]);
  surfaces_.groups[surfaces_.group_of(k.surface)]->rows.push_back(r);
}

void SurfaceRigid::point_rows(const Candidate& k, const BodyPose& at, StepContext& c) {
  Surface& info = surfaces_.list[k.surface];
  const Real radius = Real(0.5) * info.thickness;
  const Shape& ball = *point_shapes_[k.surface];
  FEDER_ASSERT(ball.radius() == radius);
  const Vec3 x = current_position(k.index);
  if (info.active && surfaces_.delta_position[k.index].w == 0 &&
      colliders_.motion[k.collider] != ColliderMotion::dynamic)
    return measure_pin(k, at, radius);
  // relative motion of the time that the row is made for, and the CFL number of the group
  const Vec3 u = surfaces_.velocity[k.index].vec() - at.velocity - cross(at.angular_velocity, x - at.center);
  const Vec3 travel = speculative_time_ * u + (speculative_time_ * speculative_time_) * c.gravity;
  const Real travel_length = length(travel);
  const Real cast_travel = radius + kCastShare * smallest_[k.collider];  // m, from which on it is cast
  if (!refreshing()) {
    Real& cfl_number = cfl_number_[surfaces_.group_of(k.surface)];
    cfl_number = std::max(cfl_number, travel_length / cast_travel);
  }
  const std::uint32_t v[3] = {k.index, k.index, k.index};
  const Real weight[3] = {1, 0, 0};
  const Shape& shape = *colliders_.shape[k.collider];
  // fast: the row of the time of impact
  if (travel_length > cast_travel) {
    CastHit hit;
    if (shape_cast(ball, {x, Quat{}}, travel, shape, at.pose, hit) && hit.fraction > 0) {
      const Real closing = -dot(hit.normal, travel);
      if (!(closing > 0)) return;
      if (!info.active) return wake(info, colliders_.object[k.collider]);
      return add_row(k, at, v, weight, hit.normal, hit.fraction * closing, x);
    }
  }
  // speculative contact within the motion
  Manifold m[kMaxManifolds];
  PairCache cache;
  const Real margin = std::min(travel_length, cast_travel) + kSpeculativeDistance * info.thickness;
  Aabb near{x, x};
  near.grow(radius + margin);
  if (!overlaps(near, at.box)) return;
  const int count = collide_.narrow().collide(ball, {x, Quat{}}, shape, at.pose, margin, cache, m);
  for (int i = 0; i < count; ++i) {
    if (m[i].count == 0) continue;
    if (!info.active) {
      // a moving body wakes a sleeper
      if (m[i].points[0].separation < Real(0.1) * info.thickness && travel_length > Real(0.05) * speculative_time_)
        wake(info, colliders_.object[k.collider]);
      return;
    }
    add_row(k, at, v, weight, -m[i].normal, m[i].points[0].separation, x);
  }
}

// Where a part of a surface at `a` meets the body: fast, at the time of impact, else in the speculative contacts.
// add(normal, gap, nearest, between): nearest point of the part; between its corners, which have rows of their own.
template <class F>
void SurfaceRigid::meet(const Candidate& k, const BodyPose& at, const Shape& shape, const Vec3& a, const Travel& way,
                        F&& add) {
  const Surface& info = surfaces_.list[k.surface];
  const Real radius = Real(0.5) * info.thickness;
  const Shape& body = *colliders_.shape[k.collider];
  if (way.least > radius + kCastShare * smallest_[k.collider]) {
    CastHit hit;
    if (shape_cast(shape, {a, Quat{}}, way.mean, body, at.pose, hit) && hit.fraction > 0) {
      const Real closing = -dot(hit.normal, way.mean);
      if (closing > 0)
        add(hit.normal, hit.fraction * closing, hit.point + radius * hit.normal - hit.fraction * way.mean, false);
      return;
    }
  }
  Manifold m[kMaxManifolds];
  PairCache cache;
  const Real speculative_distance = info.coasts ? kSpeculativeDistanceCoasting : kSpeculativeDistance;
  const Real margin = std::min(way.most, radius + smallest_[k.collider]) + speculative_distance * info.thickness;
  Aabb near = shape.bounds({a, Quat{}});
  near.grow(margin);
  if (!overlaps(near, at.box)) return;
  const int count = collide_.narrow().collide(shape, {a, Quat{}}, body, at.pose, margin, cache, m);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < m[i].count; ++j) {
      // from midway between the surfaces to the part: a push beside the normal would spin a ball
      const ManifoldPoint& p = m[i].points[j];
      add(-m[i].normal, p.separation, p.position - (radius + p.separation / 2) * m[i].normal, true);
    }
}

void SurfaceRigid::triangle_rows(const Candidate& k, const BodyPose& at, StepContext& c) {
  const Surface& info = surfaces_.list[k.surface];
  FEDER_ASSERT(3 * k.index + 2 < info.triangles.size());
  const std::uint32_t* q = &info.triangles[3 * k.index];
  const std::uint32_t v[3] = {info.first + q[0], info.first + q[1], info.first + q[2]};
  const Vec3 a = current_position(v[0]), b = current_position(v[1]) - a, e = current_position(v[2]) - a;
  const Vec3 middle = a + (b + e) / 3;
  const Vec3 body_velocity = at.velocity + cross(at.angular_velocity, middle - at.center),
             fall = (speculative_time_ * speculative_time_) * c.gravity;
  Vec3 travel = fall;
  // relative motion of the corners: one that moves with the body is near it now, so only a triangle that approaches
  // with all of them is cast
  Real least_travel = kInfinity, most_travel = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 u = surfaces_.velocity[v[i]].vec() - body_velocity;
    travel += speculative_time_ / 3 * u;
    const Real far = length(Vec3(speculative_time_ * u + fall));
    least_travel = std::min(least_travel, far), most_travel = std::max(most_travel, far);
  }
  const SurfaceTriangle shape(b, e, Real(0.5) * info.thickness);
  meet(k, at, shape, a, {travel, least_travel, most_travel},
       [&](const Vec3& normal, Real gap, const Vec3& nearest, bool between) {
         Real weight[3];
         nearest_weights(nearest - a, b, e, weight);
         if (between && std::max({weight[0], weight[1], weight[2]}) > kCorner) return;
         add_row(k, at, v, weight, normal, gap, a + weight[1] * b + weight[2] * e);
       });
}

// A segment gives rows where a shape meets it between its ends, which have rows of their own.
void SurfaceRigid::segment_rows(const Candidate& k, const BodyPose& at, StepContext& c) {
  const Surface& info = surfaces_.list[k.surface];
  FEDER_ASSERT(k.index < info.edges.count);
  const std::uint32_t* ends = info.edges.ends + std::size_t(k.index) * info.edges.stride;
  const std::uint32_t v[3] = {info.first + ends[0], info.first + ends[1], info.first + ends[1]};
  const Vec3 a = current_position(v[0]), b = current_position(v[1]) - a;
  const Real bb = dot(b, b);
  if (!(bb > 0)) return;
  const Vec3 body_velocity = at.velocity + cross(at.angular_velocity, a + b / 2 - at.center),
             fall = (speculative_time_ * speculative_time_) * c.gravity;
  // relative motion of the ends: only a segment that approaches with both of them is cast
  const Vec3 travels[2] = {speculative_time_ * (surfaces_.velocity[v[0]].vec() - body_velocity) + fall,
                           speculative_time_ * (surfaces_.velocity[v[1]].vec() - body_velocity) + fall};
  const Real far[2] = {length(travels[0]), length(travels[1])};
  const Vec3 travel = (travels[0] + travels[1]) / 2;
  const SurfaceSegment shape(b, Real(0.5) * info.thickness);
  meet(k, at, shape, a, {travel, std::min(far[0], far[1]), std::max(far[0], far[1])},
       [&](const Vec3& normal, Real gap, const Vec3& nearest, bool between) {
         const Real share = clamp(dot(nearest - a, b) / bb, 0, 1);
         if (between && std::max(share, 1 - share) > kCorner) return;
         const Real weight[3] = {1 - share, share, 0};
         add_row(k, at, v, weight, normal, gap, a + share * b);
       });
}

}  // namespace feder
