#include "view/hand.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "collide/collide.h"
#include "rigid/rigid.h"
#include "springs/springs.h"

namespace feder::view {
namespace {

constexpr double kPullHertz = 4;    // of the spring of a grip; softer where a step is too long for it
constexpr double kSpinDamping = 3;  // 1/s, of a held body

// 1 / mass of a body at a point and in a direction.
Real inv_mass_at(const Bodies& b, std::uint32_t i, const Vec3& arm, const Vec3& n) {
  const Vec3 turn = cross(arm, n);
  return b.inv_mass[i] + dot(turn, b.world_inv_inertia(i) * turn);
}

// Along `v`: v times the mass that is felt there, times `rate`.
Vec3 felt(const Bodies& b, std::uint32_t i, const Vec3& arm, const Vec3& v, Real rate) {
  const Vec3 n = normalized_or(v, Vec3::Zero());
  const Real w = inv_mass_at(b, i, arm, n);
  return w > 0 ? Vec3(v * (rate / w)) : Vec3(Vec3::Zero());
}

void nearest_net_point(World& world, const Ray& ray, Real slack, Real farthest, std::optional<Pick>& best) {
  Springs* springs = world.find<Springs>();
  if (!springs) return;
  Real best_angle = slack;
  world.objects().for_each(kNetKind, [&](ObjectId id) {
    const std::size_t count = springs->point_count(id);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 x = springs->point(id, i);
      const Vec3 to = x - ray.origin;
      const Real depth = dot(to, ray.direction);
      if (!(depth > 0) || depth > farthest + Real(0.02) * depth) continue;
      const Real angle = length(to - depth * ray.direction) / depth;
      if (angle >= best_angle) continue;
      best_angle = angle;
      best = Pick{id, static_cast<std::uint32_t>(i), x, depth, true};
    }
  });
}

}  // namespace

std::optional<Pick> pick(World& world, const Ray& ray, Real slack) {
  constexpr Real kFar = 10000;  // m
  std::optional<Pick> best;
  Real depth = kFar;
  if (Collide* collide = world.query<Collide>()) {
    RaycastHit hit;
    if (collide->raycast(ray.origin, ray.direction * kFar, {}, hit)) {
      depth = hit.fraction * kFar;
      Pick p{hit.object, kNone, hit.point, depth, false};
      Rigid* rigid = world.find<Rigid>();
      if (rigid && world.objects().kind(hit.object) == kBodyKind)
        p.movable = rigid->bodies().type[rigid->index(hit.object)] == BodyType::dynamic;
      if (world.objects().kind(hit.object) == kBodyKind) best = p;
    }
  }
  nearest_net_point(world, ray, slack, depth, best);
  return best;
}

Grip grip(World& world, const Pick& p) {
  Grip g{p.object, p.point, false, Vec3::Zero(), p.position};
  if (p.point != kNone)
    g.was_pinned = world.find<Springs>()->pinned(p.object, p.point);
  else
    g.local = to_local(world.find<Rigid>()->pose(p.object), p.position);
  return g;
}

bool alive(World& world, const Grip& g) {
  if (!world.objects().alive(g.object)) return false;
  return g.point == kNone || g.point < world.find<Springs>()->point_count(g.object);
}

Vec3 grip_position(World& world, const Grip& g) {
  if (g.point != kNone) return world.find<Springs>()->point(g.object, g.point);
  return to_world(world.find<Rigid>()->pose(g.object), g.local);
}

Command take_command(const Grip& g) {
  if (g.point == kNone) return [g](lua::Script& s) { s.world()->find<Rigid>()->wake(g.object); };
  return [g](lua::Script& s) { s.world()->find<Springs>()->pin(g.object, g.point); };
}

Command pull_command(World& world, const Grip& g) {
  const double dt = world.desc().dt;
  const Vec3 x = grip_position(world, g);
  Vec3 away = g.target - x;
  if (world.desc().dimension == 2) away[2] = 0;
  if (g.point != kNone) {
    // a held point follows at a bounded speed: nets are stiff, a force would have to be stiffer
    const Real share = static_cast<Real>(std::min(1.0, 15 * dt));
    const Vec3 next = x + away * share;
    const Vec3 v = away * static_cast<Real>(share / dt);
    return [g, next, v](lua::Script& s) {
      Springs& springs = *s.world()->find<Springs>();
      springs.set_point(g.object, g.point, next);
      springs.set_velocity(g.object, g.point, v);
    };
  }
  Rigid& rigid = *world.find<Rigid>();
  const Bodies& b = rigid.bodies();
  const std::uint32_t i = rigid.index(g.object);
  // critically damped; explicit, so its frequency times the step stays well below one
  const Real omega = static_cast<Real>(std::min(2 * 3.14159265 * kPullHertz, 0.4 / dt));
  const Vec3 arm = x - b.position[i];
  Vec3 force = felt(b, i, arm, away, omega * omega) - felt(b, i, arm, b.velocity_at(i, x), 2 * omega);
  force -= world.desc().gravity * (b.mass[i] * b.gravity_scale[i]);
  const Mat3 turn = to_matrix(b.rotation[i]);
  const Vec3 torque =
      turn * (b.inertia[i] * (turn.transpose() * b.angular_velocity[i])) * static_cast<Real>(-kSpinDamping);
  return [object = g.object, force, torque, x](lua::Script& s) {
    Rigid& r = *s.world()->find<Rigid>();
    if (!s.world()->objects().alive(object)) return;
    r.apply_force(object, force, &x);
    r.apply_torque(object, torque);
  };
}

Command release_command(World& world, const Grip& g, bool pin) {
  if (g.point == kNone) {
    if (!pin) return [](lua::Script&) {};
    return pin_command(world, Pick{g.object, kNone, g.target, 0, true});
  }
  if (pin || g.was_pinned) return [](lua::Script&) {};
  const Vec3 v = world.find<Springs>()->velocity(g.object, g.point);
  return [g, v](lua::Script& s) {
    Springs& springs = *s.world()->find<Springs>();
    springs.unpin(g.object, g.point);
    springs.set_velocity(g.object, g.point, v);
  };
}

bool is_pinned(World& world, const Pick& p) {
  if (p.point != kNone) return world.find<Springs>()->pinned(p.object, p.point);
  Rigid* rigid = world.find<Rigid>();
  return rigid && rigid->bodies().type[rigid->index(p.object)] == BodyType::fixed;
}

Command pin_command(World& world, const Pick& p) {
  const bool pinned = is_pinned(world, p);
  if (p.point != kNone)
    return [p, pinned](lua::Script& s) {
      Springs& springs = *s.world()->find<Springs>();
      pinned ? springs.unpin(p.object, p.point) : springs.pin(p.object, p.point);
    };
  if (world.objects().kind(p.object) != kBodyKind) return {};
  return [p, pinned](lua::Script& s) {
    s.world()->find<Rigid>()->set_type(p.object, pinned ? BodyType::dynamic : BodyType::fixed);
  };
}

std::string shot_text(const World& world, const Ray& ray, Real radius, Real speed, int number) {
  const bool planar = world.desc().dimension == 2;
  Vec3 from = ray.origin + ray.direction * (radius * 2), to = ray.direction;
  if (planar) {
    // the picture is seen from the front: the ball enters from the left at the height the ray points at
    const Real t = std::abs(ray.direction[2]) > Real(1e-6) ? -ray.origin[2] / ray.direction[2] : Real(0);
    from = ray.origin + ray.direction * t, from[2] = 0;
    to = Vec3(1, 0, 0);
  }
  const Vec3 v = to * speed;
  char text[400];
  std::snprintf(text, sizeof text,
                "world:body{ name = 'shot%d', shape = feder.%s(%.9g), density = 2000, bullet = true, "
                "position = { %.9g, %.9g, %.9g }, velocity = { %.9g, %.9g, %.9g } }",
                number, planar ? "circle" : "sphere", static_cast<double>(radius), static_cast<double>(from[0]),
                static_cast<double>(from[1]), static_cast<double>(from[2]), static_cast<double>(v[0]),
                static_cast<double>(v[1]), static_cast<double>(v[2]));
  return text;
}

}  // namespace feder::view
