// Time of impact by conservative advancement (Mirtich 1996): the distance divided by a bound of the closing speed, that
// of the centres along the normal plus what rotation adds at the farthest point, can always be travelled. First the
// core of a (kCoreScale): only what it meets is an obstacle. Then the shape itself against that obstacle, to find where
// to stop. Keeps nothing between calls. Weak spot: spins of many turns per step creep towards the surface; what has not
// arrived after kMaxAdvances goes on as a ball that is inside the core at any rotation. Parts of a shape outside its
// core may rotate through something thin.
#include "narrow/impact.h"

#include <algorithm>

#include "feder/error.h"
#include "geom/width.h"
#include "narrow/field_tools.h"
#include "narrow/gjk.h"

namespace feder {
namespace {

constexpr int kMaxAdvances = 48;
constexpr Real kArrived =
    Real(1) / 64;  // of the core's distance from the surface of the shape: as near as this is a hit

constexpr Real kAround = 8 * kEpsilon;  // what rounding may move a place by, of its distance from the origin

constexpr Real kBallScales[] = {Real(0.4), Real(0.02)};  // of the least half width: balls that are looked at instead

enum class Advance : std::uint8_t { hit, miss, unfinished };

// One side of a pair in motion.
struct Mover {
  const Sweep& sweep;
  Convex convex;
  Real reach;  // of the shape from its owner's centre of mass, m
};

Real reach_of(const Sweep& s) { return s.turn.isZero(0) ? Real(0) : s.extent; }

// Distance of a convex `a` from b at one time, and the normal from a to b: what advances differ in.
struct Apart {
  double distance;
  Vec3 normal, point;
};

struct ConvexApart {
  const Mover& a;
  const Mover& b;
  Apart operator()(Real t) const {
    const Pose pose_a = a.sweep.at(t), pose_b = b.sweep.at(t);
    const ConvexPair pair(a.convex, pose_a, b.convex, pose_b);
    Simplex simplex;
    Gap gap;
    const double radii = double(a.convex.radius) + b.convex.radius;
    if (!gjk_distance(pair, -pair.offset, std::numeric_limits<double>::infinity(), simplex, gap))
      return {-radii, Vec3::Zero(), Vec3::Zero()};
    const Vec3 n = rotate(pose_a.rotation, narrow(gap.normal));
    return {gap.distance - radii, n, to_world(pose_a, narrow(gap.b)) - n * b.convex.radius};
  }
};

struct PlaneApart {
  const Mover& a;
  const Sweep& b;
  Apart operator()(Real t) const {
    const Pose pose_a = a.sweep.at(t), pose_b = b.at(t);
    Vec3 n;
    Real distance = 0;
    b.shape->half_space(n, distance);
    n = rotate(pose_b.rotation, n);
    const Vec3 low = to_world(pose_a, a.convex.support(rotate_inverse(pose_a.rotation, -n))) - n * a.convex.radius;
    const Real height = dot(n, low - pose_b.position) - distance;
    return {double(height), -n, low - n * height};
  }
};

// A distance field: nearest from the middle of a, which may be not the nearest of all where the field is hollow.
struct FieldApart {
  const Mover& a;
  const Sweep& b;
  const FieldTools& tools;
  const Vec3& center;  // in a
  Apart operator()(Real t) const {
    const Pose pose_a = a.sweep.at(t), pose_b = b.at(t);
    const Pose place{to_local(pose_b, pose_a.position), conjugate(pose_b.rotation) * pose_a.rotation};
    Vec3 at, n;
    const Real d = tools.least(*b.shape, a.convex, place, to_world(place, center), at, n);
    return {double(d) - a.convex.radius, rotate(pose_b.rotation, -n), to_world(pose_b, Vec3(at - d * n))};
  }
};

// Goes on from `t` until the distance is `target`, or to `end`.
template <class F>
Advance advance(const Mover& a, const Mover& b, F&& apart, Real target, Real end, Real& t, Apart& last) {
  const double turning = double(length(a.sweep.turn)) * a.reach + double(length(b.sweep.turn)) * b.reach;
  const Vec3 shift = a.sweep.shift - b.sweep.shift;
  for (int i = 0; i < kMaxAdvances; ++i) {
    last = apart(t);
    if (last.distance <= target) return Advance::hit;
    const double closing = double(dot(shift, last.normal)) + turning;
    if (!(closing > 0)) return Advance::miss;
    t = Real(t + (last.distance - target / 2) / closing);
    if (!(t < end)) return Advance::miss;
  }
  return Advance::unfinished;
}

struct Pair {
  const Sweep& a;
  const Sweep& b;
  Real begin, target;
  Impact hit;                  // earliest so far; time = end of the search
  Vec3 center = Vec3::Zero();  // of the core
  bool found = false;

  // how far the core is inside the shape
  Real skin() const { return a.half_width * (1 - kCoreScale); }
  Mover core() const {
    Mover m{a, Convex(*a.shape), reach_of(a)};
    m.convex.scale = kCoreScale, m.convex.center = center, m.convex.radius *= kCoreScale;
    return m;
  }
};

// When the core meets b, given how far apart they are. Of what overlaps at the start, a ball inside the core.
template <class Make>
bool core_meets(Pair& p, const Mover& b, Make&& make, Real& t, Apart& last, bool& inside) {
  const Mover core = p.core();
  t = p.begin;
  const Real near = p.skin() * kArrived;
  Advance result = advance(core, b, make(core), near, p.hit.time, t, last);
  inside = result == Advance::hit && t == p.begin;
  for (const Real scale : kBallScales) {
    if (result == Advance::miss || (result == Advance::hit && t > p.begin)) break;
    Sweep rigid = p.a;
    rigid.turn = Vec3::Zero();
    Mover ball{rigid, Convex(&p.center, 1), 0};
    ball.convex.radius = p.a.half_width * scale;
    result = advance(ball, b, make(ball), ball.convex.radius * kArrived, p.hit.time, t, last);
  }
  return result == Advance::hit && t > p.begin && !last.normal.isZero(0);
}

template <class Make>
void meet(Pair& p, const Mover& b, Make&& make) {
  Real t = 0;
  Apart at{};
  bool inside = false;
  if (!core_meets(p, b, make, t, at, inside)) return;
  // the shape itself, which is there earlier
  const Mover whole{p.a, Convex(*p.a.shape), reach_of(p.a)};
  Real stop = p.begin;
  Apart near = make(whole)(stop);
  if (near.distance > p.target && advance(whole, b, make(whole), p.target, t, stop, near) != Advance::miss) {
    t = stop;
    at = near;
  }
  p.hit = {t, at.normal, at.point, inside};
  p.found = true;
}

void meet_convex(Pair& p, const Convex& convex, Real reach) {
  const Mover b{p.b, convex, reach};
  meet(p, b, [&b](const Mover& a) { return ConvexApart{a, b}; });
}

// The way of a's core in the frame of a mesh b.
struct CoreWay {
  Mover core;
  Pose begin, end;
  Vec3 center;     // at the beginning
  Real bulge = 0;  // how far a point may leave the straight line between its ends
  Aabb box;
};

CoreWay way_of_core(const Pair& p) {
  const Real end = p.hit.time, time = end - p.begin;
  const auto pose_at = [&p](Real t) {
    const Pose at = p.a.at(t), frame = p.b.at(t);
    return Pose{to_local(frame, at.position), conjugate(frame.rotation) * at.rotation};
  };
  CoreWay w{p.core(), pose_at(p.begin), pose_at(end), {}, 0, {}};
  w.center = to_world(w.begin, p.center);
  // at constant rates of motion and turning |x(t) - chord| <= |x''| time^2 / 8; a mesh that turns: no more than the way
  const Real angle = length(p.a.turn) * time, turn = length(p.b.turn) * time;
  const Real way = length(p.a.shift - p.b.shift) * time;
  w.bulge = w.core.reach * angle * angle / 8;
  if (turn > 0) w.bulge = way + w.core.reach * angle + turn * (length(w.center) + w.core.reach + way);
  for (const Pose& pose : {w.begin, w.end}) {
    const Aabb whole = p.a.shape->bounds(pose);
    const Vec3 c = to_world(pose, p.center);
    w.box.include(c + kCoreScale * (whole.lo - c));
    w.box.include(c + kCoreScale * (whole.hi - c));
  }
  w.box.grow(w.bulge);
  return w;
}

// Does the core stay on its side of the triangle's plane?
bool stays_off(const CoreWay& w, const Triangle& t) {
  Vec3 n = normalized_or(cross(t.b - t.a, t.c - t.a), Vec3::Zero());
  if (dot(n, w.center - t.a) < 0) n = -n;
  for (const Pose& pose : {w.begin, w.end}) {
    const Vec3 low = to_world(pose, w.core.convex.support(rotate_inverse(pose.rotation, -n)));
    if (!(dot(n, low - t.a) > w.core.convex.radius + w.bulge)) return false;
  }
  return true;
}

// A few triangles of a mesh, or the word that there are more.
struct FewTriangles {
  static constexpr int kMost = 24;
  int count = 0;
  std::uint32_t index[kMost];

  static void add(void* list, std::uint32_t i) {
    FewTriangles& few = *static_cast<FewTriangles*>(list);
    if (few.count < kMost) few.index[few.count] = i;
    ++few.count;
  }
};

// The triangles of a mesh at rest where the shape may be at any rotation: mostly none.
FewTriangles triangles_around(const Pair& p) {
  const Pose mesh = p.b.at(0);
  Aabb box;
  for (const Real t : {p.begin, p.hit.time}) box.include(to_local(mesh, p.a.from.position + t * p.a.shift));
  box.grow(p.a.extent + kAround * (length(box.lo) + length(box.hi)));
  FewTriangles few;
  p.b.shape->triangles_in(box, FewTriangles::add, &few);
  return few;
}

void meet_mesh(Pair& p) {
  FewTriangles near;
  near.count = FewTriangles::kMost + 1;
  if (p.b.turn.isZero(0) && p.b.shift.isZero(0)) near = triangles_around(p);
  if (near.count == 0) return;
  p.center = inner_point(*p.a.shape);
  struct Visit {
    Pair& p;
    CoreWay way;
    Real reach;
  } visit{p, way_of_core(p), reach_of(p.b)};
  const auto each = [](void* context, std::uint32_t index) {
    Visit& v = *static_cast<Visit*>(context);
    const Triangle& t = v.p.b.shape->triangle(index);
    Aabb box;
    for (const Vec3& corner : {t.a, t.b, t.c}) box.include(corner);
    if (!overlaps(box, v.way.box) || stays_off(v.way, t)) return;
    const Vec3 corners[3] = {t.a, t.b, t.c};
    meet_convex(v.p, Convex(corners, 3), v.reach);
  };
  if (near.count > FewTriangles::kMost) return p.b.shape->triangles_in(visit.way.box, each, &visit);
  for (int k = 0; k < near.count; ++k) each(&visit, near.index[k]);
}

}  // namespace

// The earliest of the balls in the field that is a.
static Impact balls_meet(const FieldTools& tools, const Sweep& a, const Sweep& b, Real begin, Real end, Real target) {
  Impact first;
  for (const CompoundPart& ball : tools.balls(*a.shape)) {
    Sweep s = a;
    s.shape = ball.shape.get();
    s.local = a.local * ball.pose;
    s.extent = length(s.local.position) + ball.shape->radius();
    s.half_width = ball.shape->radius();
    const Impact hit = time_of_impact(s, b, begin, end, target);
    if (hit.time < first.time) first = hit, end = std::min(end, hit.time);
  }
  return first;
}

Impact time_of_impact(const Sweep& a, const Sweep& b, Real begin, Real end, Real target) {
  const FieldTools* tools = field_tools();
  if (!a.shape->convex() && tools) return balls_meet(*tools, a, b, begin, end, target);
  FEDER_ASSERT(a.shape->convex() && begin >= 0 && begin <= end);
  Pair p{.a = a, .b = b, .begin = begin, .target = target, .hit = {.time = end}};
  Vec3 normal;
  Real distance;
  const bool half_space = b.shape->half_space(normal, distance);
  const bool field = tools && tools->is_field(*b.shape);
  if (b.shape->convex() || half_space || field) p.center = inner_point(*a.shape);
  if (b.shape->convex())
    meet_convex(p, Convex(*b.shape), reach_of(b));
  else if (half_space)
    meet(p, Mover{b, Convex(nullptr, 0), 0}, [&b](const Mover& m) { return PlaneApart{m, b}; });
  else if (field)
    meet(p, Mover{b, Convex(nullptr, 0), reach_of(b)}, [&](const Mover& m) {
      return FieldApart{m, b, *tools, p.center};
    });
  else
    meet_mesh(p);
  return p.found ? p.hit : Impact{};
}

}  // namespace feder
