// Ray casts, shape casts and overlaps.
#include <algorithm>
#include <cmath>

#include "lua/rigid_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

constexpr double kFar = 1e5;  // m: how far a ray goes when nothing is said

// Queries see the world as it is now; a world without colliders has nothing to hit.
Collide* collide_of(WorldRecord& r) { return r.world->query<Collide>(); }

void filter_options(Options& o, WorldRecord& r, QueryFilter& f) {
  std::int64_t bits = 0;
  if (o.integer("group", bits, 0, 0xffffffffll)) f.group = static_cast<std::uint32_t>(bits);
  if (o.integer("mask", bits, 0, 0xffffffffll)) f.mask = static_cast<std::uint32_t>(bits);
  o.flag("sensors", f.sensors);
  object_option(o, "ignore", r, f.ignore);
}

struct RayArguments {
  Vec3 origin, direction;  // unit
  double reach = kFar;
  bool limited = false;
  QueryFilter filter;
};

RayArguments ray_arguments(lua_State* L, WorldRecord& r) {
  RayArguments a;
  int next = 0;
  a.origin = vector_argument(L, 2, r.planar(), &next);
  const Vec3 d = vector_argument(L, next, r.planar(), &next);
  // scaled first, so that squares of very short and very long directions stay finite
  const Real largest = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
  if (!(largest > 0)) fail_here(L, "expected a direction, got 0, 0, 0");
  const Vec3 scaled = d / largest;
  a.direction = scaled / length(scaled);
  if (lua_type(L, next) == LUA_TNUMBER || (lua_type(L, next) != LUA_TTABLE && !lua_isnoneornil(L, next))) {
    a.reach = check_number(L, next++, std::string(function_name(L)) + ".max", Range{0, 1e9, true});
    a.limited = true;
  } else if (lua_isnil(L, next)) {
    ++next;
  }
  if (lua_type(L, next) == LUA_TTABLE) {
    Options o(L, next, function_name(L));
    filter_options(o, r, a.filter);
    o.finish();
  }
  return a;
}

int push_hit(lua_State* L, WorldRecord& r, const RaycastHit& hit, Real distance) {
  push_handle(L, r, hit.object);
  push_vector(L, hit.point);
  push_vector(L, hit.normal);
  lua_pushnumber(L, distance);
  return 8;
}

int world_raycast(lua_State* L) {
  WorldRecord& r = check_world(L);
  const RayArguments a = ray_arguments(L, r);
  Collide* collide = collide_of(r);
  RaycastHit hit;
  const Vec3 ray = a.direction * static_cast<Real>(a.reach);
  if (!collide || !collide->raycast(a.origin, ray, a.filter, hit)) {
    lua_pushnil(L);
    return 1;
  }
  // a fraction of a very long ray is coarse: ask again with a ray that ends just behind the hit
  Real distance = hit.fraction * static_cast<Real>(a.reach);
  const Real near = distance * Real(1.01) + Real(0.01);
  RaycastHit finer;
  if (near < Real(0.5) * static_cast<Real>(a.reach) && collide->raycast(a.origin, a.direction * near, a.filter, finer))
    hit = finer, distance = finer.fraction * near;
  return push_hit(L, r, hit, distance);
}

int world_raycast_all(lua_State* L) {
  WorldRecord& r = check_world(L);
  RayArguments a = ray_arguments(L, r);
  if (!a.limited) a.reach = 1000;
  std::vector<RaycastHit> hits;
  if (Collide* collide = collide_of(r))
    collide->raycast_all(a.origin, a.direction * static_cast<Real>(a.reach), a.filter, hits);
  std::stable_sort(hits.begin(), hits.end(),
                   [](const RaycastHit& x, const RaycastHit& y) { return x.fraction < y.fraction; });
  lua_newtable(L);
  lua_Integer n = 0;
  for (const RaycastHit& hit : hits) {
    lua_createtable(L, 0, 8);
    push_handle(L, r, hit.object);
    lua_setfield(L, -2, "object");
    static const char* const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int k = 0; k < 3; ++k) {
      lua_pushnumber(L, hit.point[k]);
      lua_setfield(L, -2, names[k]);
      lua_pushnumber(L, hit.normal[k]);
      lua_setfield(L, -2, names[k + 3]);
    }
    lua_pushnumber(L, hit.fraction * static_cast<Real>(a.reach));
    lua_setfield(L, -2, "distance");
    lua_rawseti(L, -2, ++n);
  }
  return 1;
}

ShapePtr convex_shape(Options& o, const WorldRecord& r, ShapePtr shape) {
  if (!shape->convex()) o.raise("shape", std::string("expected a convex shape, got a ") + shape->kind());
  return r.planar() ? shape->section() : shape;
}

int world_shape_cast(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  ShapePtr shape;
  Pose pose;
  Vec3 motion = Vec3::Zero();
  QueryFilter filter;
  if (!shape_option(o, "shape", shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
  o.vector("position", pose.position);
  o.rotation("rotation", pose.rotation);
  if (!o.vector("motion", motion)) o.wrong("motion", "{x, y, z}");
  filter_options(o, r, filter);
  o.finish();
  shape = convex_shape(o, r, shape);
  Collide* collide = collide_of(r);
  RaycastHit hit;
  if (!collide || !collide->shape_cast(*shape, pose, motion, filter, hit)) {
    lua_pushnil(L);
    return 1;
  }
  return push_hit(L, r, hit, hit.fraction * length(motion));
}

int world_overlap(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  ShapePtr shape;
  Pose pose;
  QueryFilter filter;
  const bool has_box = box_option(o, shape, pose.position);
  if (!has_box && !shape_option(o, "shape", shape))
    o.raise(nullptr, "expected box = {min, max} or shape =, got neither");
  if (!has_box) o.vector("position", pose.position);
  o.rotation("rotation", pose.rotation);
  filter_options(o, r, filter);
  o.finish();
  shape = convex_shape(o, r, shape);
  std::vector<ObjectId> found;
  if (Collide* collide = collide_of(r)) collide->overlap(*shape, pose, filter, found);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  lua_newtable(L);
  lua_Integer n = 0;
  for (ObjectId id : found) {
    push_handle(L, r, id);
    lua_rawseti(L, -2, ++n);
  }
  return 1;
}

const Method kQueryMethods[] = {
    {"raycast", guard<world_raycast>,
     "world:raycast(x, y, z, dx, dy, dz, [max], [filter]) -> object, x, y, z, nx, ny, nz, distance",
     "the nearest hit along the direction within max metres (100 km), or nil; filter = { group, mask, sensors, ignore "
     "}"},
    {"raycast_all", guard<world_raycast_all>,
     "world:raycast_all(x, y, z, dx, dy, dz, [max], [filter]) -> {{object, x, y, z, nx, ny, nz, distance}, ...}",
     "all hits within max metres (1 km), nearest first"},
    {"shape_cast", guard<world_shape_cast>,
     "world:shape_cast{ shape=, position=, rotation=, motion=, ... } -> object, x, y, z, nx, ny, nz, distance",
     "the first thing a convex shape meets along its motion, or nil"},
    {"overlap", guard<world_overlap>, "world:overlap{ shape= | box=, position=, rotation=, ... } -> {object, ...}",
     "what a convex shape overlaps"},
};

}  // namespace

std::span<const Method> query_methods() { return kQueryMethods; }

}  // namespace feder::lua
