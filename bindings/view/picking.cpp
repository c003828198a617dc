#include "view/picking.h"

#include <cmath>
#include <cstdio>

namespace feder::view {

using Row = const ObjectView*;
#include "live_declare.inc"

std::span<const ObjectView* const> object_views() {
  static const std::initializer_list<const ObjectView*> table = {
#include "live_rows.inc"
  };
  return {table.begin(), table.size()};
}

const ObjectView* view_of(const World& world, ObjectId object) {
  if (!world.objects().alive(object)) return nullptr;
  for (const ObjectView* view : object_views())
    if (world.objects().kind(object) == view->kind()) return view;
  return nullptr;
}

Vec3 ObjectView::away(World& world, const Grip& grip) const {
  Vec3 to = grip.target - position(world, grip.object, grip.point, grip.local);
  if (world.desc().dimension == 2) to[2] = 0;
  return to;
}

std::optional<Pick> pick(World& world, const Ray& ray, Real slack) {
  std::optional<Pick> best;
  Real depth = kInfinity;
  for (const ObjectView* view : object_views()) view->pick(world, ray, slack, depth, best);
  return best;
}

bool alive(World& world, const Grip& g) {
  const ObjectView* view = view_of(world, g.object);
  return view && (g.point == kNone || view->has_point(world, g.object, g.point));
}

Grip grip(World& world, const Pick& p) { return view_of(world, p.object)->grip(world, p); }

Vec3 grip_position(World& world, const Grip& g) {
  return view_of(world, g.object)->position(world, g.object, g.point, g.local);
}

bool is_pinned(World& world, const Pick& p) {
  const ObjectView* view = view_of(world, p.object);
  return view && view->is_pinned(world, p);
}

Command pin_command(World& world, const Pick& p) {
  const ObjectView* view = view_of(world, p.object);
  return view ? view->set_pinned(p, !view->is_pinned(world, p)) : Command();
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
                "world:body{ name = 'shot%d', shape = feder.sphere(%.9g), density = 2000, bullet = true, "
                "position = { %.9g, %.9g, %.9g }, velocity = { %.9g, %.9g, %.9g } }",
                number, static_cast<double>(radius), static_cast<double>(from[0]), static_cast<double>(from[1]),
                static_cast<double>(from[2]), static_cast<double>(v[0]), static_cast<double>(v[1]),
                static_cast<double>(v[2]));
  return text;
}

}  // namespace feder::view
