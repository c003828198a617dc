// Ray casts, shape casts and overlaps.
#include <algorithm>
#include <cmath>

#include "lua/box_option.h"
#include "lua/rigid_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

constexpr double kFar = 1e5;  // m: how far a ray goes when nothing is said

// Queries see the world as it is now; a world without colliders has nothing to hit.
struct Query : QueryFilter {
  WorldRecord* record = nullptr;
  ShapePtr shape;
  Pose pose;
  Vec3 motion = Vec3::Zero();
};

void read_ignore(Options& o, const OptionRow&, Query& q) { object_option(o, "ignore", *q.record, q.ignore); }

constexpr Option<Query> kFilter[] = {
    field<&QueryFilter::group>("group", "", kBits),
    field<&QueryFilter::mask>("mask", "", kBits),
    field<&QueryFilter::sensors>("sensors"),
    special("ignore", "object", read_ignore),
};

void read_cast(Options& o, const OptionRow&, Query& q) {
  if (!shape_option(o, "shape", q.shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
  o.vector("position", q.pose.position);
  o.rotation("rotation", q.pose.rotation);
  if (!o.vector("motion", q.motion)) o.wrong("motion", "{x, y, z}");
}

constexpr Option<Query> kCast[] = {
    special("shape", "shape", read_cast),
    later<Query>("position", "vector", "m"),
    later<Query>("rotation", "rotation"),
    later<Query>("motion", "vector", "m"),
};

void read_volume(Options& o, const OptionRow&, Query& q) { box_or_shape(o, q.shape, q.pose.position, q.pose.rotation); }

constexpr Option<Query> kOverlap[] = {
    box_row(read_volume),
    later<Query>("shape", "shape"),
    later<Query>("position", "vector", "m"),
    later<Query>("rotation", "rotation"),
};

template <auto& Rows>
std::vector<OptionInfo> with_filter() {
  return join_rows(describe_rows(Rows), describe_rows(kFilter));
}

// What a convex shape asks: the rows of its kind, and the filter; in 2D of its section.
template <std::size_t N>
Query read_query(lua_State* L, WorldRecord& r, const Option<Query> (&rows)[N]) {
  Options o(L, 2, function_name(L), r.planar());
  Query q;
  q.record = &r;
  o.read_some(rows, q);
  o.read(kFilter, q);
  if (!q.shape->convex()) o.raise("shape", std::string("expected a convex shape, got a ") + q.shape->kind());
  if (r.planar()) q.shape = q.shape->section();
  return q;
}

struct RayArguments {
  Vec3 origin, direction;  // unit
  double reach = kFar;
  bool limited = false;
  Query filter;
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
    a.filter.record = &r;
    o.read(kFilter, a.filter);
  }
  return a;
}

int push_hit(lua_State* L, WorldRecord& r, const RaycastHit& hit, Real distance) {
  push_handle(L, r, hit.object);
  return 1 + push(L, hit.point, hit.normal, distance);
}

int world_raycast(lua_State* L) {
  WorldRecord& r = check_world(L);
  const RayArguments a = ray_arguments(L, r);
  Collide* collide = r.world->query<Collide>();
  RaycastHit hit;
  const Vec3 ray = a.direction * static_cast<Real>(a.reach);
  if (!collide || !collide->raycast(a.origin, ray, a.filter, hit)) return push(L, nullptr);
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
  if (Collide* collide = r.world->query<Collide>())
    collide->raycast_all(a.origin, a.direction * static_cast<Real>(a.reach), a.filter, hits);
  std::stable_sort(hits.begin(), hits.end(),
                   [](const RaycastHit& x, const RaycastHit& y) { return x.fraction < y.fraction; });
  push_list(L, hits, [&](const RaycastHit& hit) {
    lua_createtable(L, 0, 8);
    push_handle(L, r, hit.object);
    lua_setfield(L, -2, "object");
    set_point_and_normal(L, hit.point, hit.normal);
    set_field(L, "distance", hit.fraction * static_cast<Real>(a.reach));
  });
  return 1;
}

int world_shape_cast(lua_State* L) {
  WorldRecord& r = check_world(L);
  const Query q = read_query(L, r, kCast);
  Collide* collide = r.world->query<Collide>();
  RaycastHit hit;
  if (!collide || !collide->shape_cast(*q.shape, q.pose, q.motion, q, hit)) return push(L, nullptr);
  return push_hit(L, r, hit, hit.fraction * length(q.motion));
}

int world_overlap(lua_State* L) {
  WorldRecord& r = check_world(L);
  const Query q = read_query(L, r, kOverlap);
  std::vector<ObjectId> found;
  if (Collide* collide = r.world->query<Collide>()) collide->overlap(*q.shape, q.pose, q, found);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  push_list(L, found, [&](ObjectId id) { push_handle(L, r, id); });
  return 1;
}

const Method kQueryMethods[] = {
    {"raycast", guard<world_raycast>,
     "world:raycast(x, y, z, dx, dy, dz, [max], [filter]) -> object, x, y, z, nx, ny, nz, distance",
     "the nearest hit along the direction within max metres (100 km), or nil; filter = { group, mask, sensors, ignore "
     "}",
     rows_of<kFilter>},
    {"raycast_all", guard<world_raycast_all>,
     "world:raycast_all(x, y, z, dx, dy, dz, [max], [filter]) -> {{object, x, y, z, nx, ny, nz, distance}, ...}",
     "all hits within max metres (1 km), nearest first", rows_of<kFilter>},
    {"shape_cast", guard<world_shape_cast>,
     "world:shape_cast{ shape=, position=, rotation=, motion=, ... } -> object, x, y, z, nx, ny, nz, distance",
     "the first thing a convex shape meets along its motion, or nil", with_filter<kCast>},
    {"overlap", guard<world_overlap>, "world:overlap{ shape= | box=, position=, rotation=, ... } -> {object, ...}",
     "what a convex shape overlaps", with_filter<kOverlap>},
};

}  // namespace

std::span<const Method> query_methods() { return kQueryMethods; }

}  // namespace feder::lua
