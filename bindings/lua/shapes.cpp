#include "lua/shapes.h"

#include "lua/buffer.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxPoints = 10000000;

double size_argument(lua_State* L, int index, const char* name) {
  const double x = lua_type(L, index) == LUA_TNUMBER ? lua_tonumber(L, index) : -1;
  if (x > 1e-30 && x < 1e9) return x;  // the common case makes no strings
  return check_number(L, index, std::string(function_name(L)) + "." + name, Range{0, 1e9, true});
}

Real real_argument(lua_State* L, int index, const char* name) {
  return static_cast<Real>(size_argument(L, index, name));
}

void no_more(lua_State* L, int count) {
  if (lua_gettop(L) > count)
    fail_here(L, "expected at most " + std::to_string(count) + " arguments, got " + std::to_string(lua_gettop(L)));
}

int shape_collected(lua_State* L) {
  static_cast<ShapePtr*>(lua_touserdata(L, 1))->~shared_ptr();
  return 0;
}

int shape_tostring(lua_State* L) {
  const auto* shape = static_cast<const ShapePtr*>(test_class(L, 1, Class::shape));
  lua_pushstring(L, shape ? (std::string("shape ") + (*shape)->kind()).c_str() : "?");
  return 1;
}

int feder_sphere(lua_State* L) {
  no_more(L, 1);
  push_shape(L, make_sphere(real_argument(L, 1, "radius")));
  return 1;
}

int feder_circle(lua_State* L) {
  no_more(L, 1);
  push_shape(L, make_circle(real_argument(L, 1, "radius")));
  return 1;
}

int feder_box(lua_State* L) {
  if (lua_gettop(L) == 1 && lua_type(L, 1) == LUA_TTABLE) {
    const Vec3 size = check_vector(L, 1, function_name(L));
    lua_settop(L, 0);
    for (int i = 0; i < 3; ++i) lua_pushnumber(L, size[i]);
  }
  no_more(L, 3);
  if (lua_gettop(L) == 2) lua_pushnumber(L, 1);  // 2D: a box of two sizes
  push_shape(L, make_box(real_argument(L, 1, "width"), real_argument(L, 2, "height"), real_argument(L, 3, "depth")));
  return 1;
}

template <ShapePtr (*Make)(Real, Real)>
int feder_round(lua_State* L) {
  no_more(L, 2);
  push_shape(L, Make(real_argument(L, 1, "radius"), real_argument(L, 2, "height")));
  return 1;
}

int feder_hull(lua_State* L) {
  no_more(L, 1);
  push_shape(L, make_hull(check_points(L, 1, function_name(L))));
  return 1;
}

int feder_polygon(lua_State* L) {
  no_more(L, 2);
  std::vector<Vec2> points;
  for (const Vec3& p : check_points(L, 1, function_name(L), true)) points.emplace_back(p[0], p[1]);
  push_shape(L, make_polygon(points, lua_isnoneornil(L, 2) ? Real(0) : real_argument(L, 2, "radius")));
  return 1;
}

int feder_plane(lua_State* L) {
  no_more(L, 4);
  if (lua_gettop(L) == 0) {
    push_shape(L, make_plane(Vec3(0, 1, 0), 0));
    return 1;
  }
  int next = 4;
  const Vec3 n = vector_argument(L, 1, false, &next);
  const double d =
      lua_isnoneornil(L, next) ? 0 : check_number(L, next, std::string(function_name(L)) + ".d", Range{-1e9, 1e9});
  const Real size = length(n);
  if (!(size > Real(1e-12) && size < Real(1e12)))
    fail_here(L, "expected a normal of a direction, got one of length " + print_number(size));
  push_shape(L, make_plane(n / size, static_cast<Real>(d / static_cast<double>(size))));
  return 1;
}

// Triangles as {i, j, k} tables counting from 1.
std::vector<std::uint32_t> check_triangles(lua_State* L, int index, std::size_t vertex_count) {
  const std::string name = std::string(function_name(L)) + ".triangles";
  if (lua_type(L, index) != LUA_TTABLE) fail(L, name + ": expected a list of {i, j, k}, got " + describe(L, index));
  const auto count = lua_rawlen(L, index);
  if (count > kMaxPoints)
    fail(L, name + ": expected at most " + std::to_string(kMaxPoints) + " triangles, got " + std::to_string(count));
  std::vector<std::uint32_t> out;
  for (std::size_t t = 1; t <= count; ++t) {
    lua_rawgeti(L, index, static_cast<lua_Integer>(t));
    const std::string at = name + "[" + std::to_string(t) + "]";
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != 3)
      fail(L, at + ": expected {i, j, k}, got " + describe(L, -1));
    for (int k = 1; k <= 3; ++k) {
      lua_rawgeti(L, -1, k);
      out.push_back(
          static_cast<std::uint32_t>(check_integer(L, -1, at, 1, static_cast<std::int64_t>(vertex_count)) - 1));
      lua_pop(L, 1);
    }
    lua_pop(L, 1);
  }
  return out;
}

int feder_mesh(lua_State* L) {
  no_more(L, 2);
  const std::vector<Vec3> vertices = check_points(L, 1, std::string(function_name(L)) + ".vertices");
  push_shape(L, make_mesh(vertices, check_triangles(L, 2, vertices.size())));
  return 1;
}

void read_part(Options& o, const OptionRow&, CompoundPart& p) {
  if (!shape_option(o, "shape", p.shape)) o.wrong("shape", "a shape (feder.box(1, 1, 1) ...)");
  o.vector("position", p.pose.position);
  o.rotation("rotation", p.pose.rotation);
}

constexpr Option<CompoundPart> kPart[] = {
    special("shape", "shape", read_part),
    later<CompoundPart>("position", "vector", "m"),
    later<CompoundPart>("rotation", "rotation"),
};

int feder_compound(lua_State* L) {
  no_more(L, 1);
  const std::string name = function_name(L);
  if (lua_type(L, 1) != LUA_TTABLE)
    fail_here(L, "expected a list of { shape =, position =, rotation = }, got " + describe(L, 1));
  const auto count = lua_rawlen(L, 1);
  if (count == 0 || count > 4096) fail_here(L, "expected 1 to 4096 parts, got " + std::to_string(count));
  std::vector<CompoundPart> parts;
  for (std::size_t i = 1; i <= count; ++i) {
    lua_rawgeti(L, 1, static_cast<lua_Integer>(i));
    Options o(L, -1, name + "[" + std::to_string(i) + "]", true);
    CompoundPart part;
    o.read(kPart, part);
    parts.push_back(std::move(part));
    lua_pop(L, 1);
  }
  push_shape(L, make_compound(std::move(parts)));
  return 1;
}

int feder_left_out_shape(lua_State* L) { fail_here(L, "this build has no such shape yet"); }

int shape_kind(lua_State* L) {
  const auto* shape = static_cast<const ShapePtr*>(self_block(L));
  if (!shape) wrong_self(L, "shape");
  lua_pushstring(L, (*shape)->kind());
  return 1;
}

const Method kShapeFunctions[] = {
    {"sphere", guard<feder_sphere>, "feder.sphere(radius) -> shape", "a ball"},
    {"box", guard<feder_box>, "feder.box(width, height, depth) -> shape",
     "a box of full sizes; depth may be left out in 2D"},
    {"capsule", guard<feder_round<make_capsule>>, "feder.capsule(radius, height) -> shape",
     "along y, whole height with its caps"},
    {"cylinder", guard<feder_round<make_cylinder>>, "feder.cylinder(radius, height) -> shape", "along y"},
    {"cone", guard<feder_round<make_cone>>, "feder.cone(radius, height) -> shape",
     "along y, tip up, origin at half its height"},
    {"hull", guard<feder_hull>, "feder.hull(points) -> shape", "the convex hull of a list of {x, y, z} or a buffer"},
    {"mesh", guard<feder_mesh>, "feder.mesh(vertices, triangles) -> shape",
     "static triangles {i, j, k}, counting from 1"},
    {"plane", guard<feder_plane>, "feder.plane([nx, ny, nz, [d]]) -> shape",
     "the half-space n.x >= d is free; y >= 0 when left out"},
    {"compound", guard<feder_compound>, "feder.compound{ {shape=, position=, rotation=}, ... } -> shape",
     "several shapes in one"},
    {"circle", guard<feder_circle>, "feder.circle(radius) -> shape", "for worlds with dimension = 2"},
    {"polygon", guard<feder_polygon>, "feder.polygon(points, [radius]) -> shape",
     "2D: the convex hull of a list of {x, y}"},
    {"heightfield", guard<feder_left_out_shape>, "feder.heightfield{}", "not in this build"},
    {"sdf", guard<feder_left_out_shape>, "feder.sdf{}", "not in this build"},
};
const Method kShapeMethods[] = {
    {"kind", guard<shape_kind>, "shape:kind() -> string", "\"box\", \"sphere\" ..."},
};

// {min, max} corners as a shape and its centre.
bool box_option(Options& o, ShapePtr& shape, Vec3& center) {
  if (!o.push("box", LUA_TTABLE, "{ {x, y, z}, {x, y, z} }")) return false;
  lua_State* L = o.L();
  if (lua_rawlen(L, -1) != 2)
    o.raise("box", "expected two corners { {x, y, z}, {x, y, z} }, got a table of " +
                       std::to_string(lua_rawlen(L, -1)) + " values");
  lua_rawgeti(L, -1, 1), lua_rawgeti(L, -2, 2);
  const Vec3 lo = check_vector(L, -2, o.path("box") + "[1]", o.planar()),
             hi = check_vector(L, -1, o.path("box") + "[2]", o.planar());
  lua_pop(L, 3);
  for (int k = 0; k < (o.planar() ? 2 : 3); ++k)
    if (!(hi[k] > lo[k]))
      o.raise("box", std::string("expected the second corner above the first, got ") + print_number(lo[k]) + " and " +
                         print_number(hi[k]) + " along " + "xyz"[k]);
  const Real depth = hi[2] > lo[2] ? hi[2] - lo[2] : Real(1);
  shape = make_box(hi[0] - lo[0], hi[1] - lo[1], depth);
  center = (lo + hi) * Real(0.5);
  return true;
}

}  // namespace

std::span<const Method> shape_functions() { return kShapeFunctions; }
std::span<const Method> shape_methods() { return kShapeMethods; }

void push_shape(lua_State* L, ShapePtr shape) {
  void* block = lua_newuserdatauv(L, sizeof(ShapePtr), 0);
  new (block) ShapePtr(std::move(shape));
  push_class(L, Class::shape);
  lua_setmetatable(L, -2);
}

ShapePtr check_shape(lua_State* L, int index, const std::string& what) {
  const auto* shape = static_cast<const ShapePtr*>(test_class(L, index, Class::shape));
  if (!shape) fail(L, what + ": expected a shape (feder.box(1, 1, 1) ...), got " + describe(L, index));
  return *shape;
}

bool shape_option(Options& o, const char* key, ShapePtr& out) {
  if (!o.push_any(key)) return false;
  if (!test_class(o.L(), -1, Class::shape)) o.wrong(key, "a shape (feder.box(1, 1, 1) ...)");
  out = check_shape(o.L(), -1, o.path(key));
  lua_pop(o.L(), 1);
  return true;
}

std::vector<Vec3> check_points(lua_State* L, int index, const std::string& what, bool planar) {
  index = lua_absindex(L, index);
  std::vector<Vec3> out;
  if (const auto numbers = test_buffer(L, index); numbers.data()) {
    if (numbers.size() % 3) fail(L, what + ": expected a buffer of 3 n numbers, got " + std::to_string(numbers.size()));
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      for (std::size_t k = 0; k < 3; ++k)
        if (!(numbers[i + k] >= -kHuge && numbers[i + k] <= kHuge))
          fail(L, what + "[" + std::to_string(i + k + 1) + "]: expected a finite number, got " +
                      print_number(numbers[i + k]));
      out.emplace_back(static_cast<Real>(numbers[i]), static_cast<Real>(numbers[i + 1]),
                       static_cast<Real>(numbers[i + 2]));
    }
    return out;
  }
  if (lua_type(L, index) != LUA_TTABLE) fail(L, what + ": expected a list of points, got " + describe(L, index));
  const auto count = lua_rawlen(L, index);
  if (count > kMaxPoints)
    fail(L, what + ": expected at most " + std::to_string(kMaxPoints) + " points, got " + std::to_string(count));
  out.reserve(count);
  charge(L, count);
  for (std::size_t i = 1; i <= count; ++i) {
    lua_rawgeti(L, index, static_cast<lua_Integer>(i));
    out.push_back(check_vector(L, -1, what + "[" + std::to_string(i) + "]", planar));
    lua_pop(L, 1);
  }
  return out;
}

void open_shapes(lua_State* L) {
  push_class(L, Class::shape);
  lua_pushcfunction(L, shape_tostring);
  lua_setfield(L, -2, "__tostring");
  lua_pushcfunction(L, shape_collected);
  lua_setfield(L, -2, "__gc");
  lua_pop(L, 1);
}

bool has_volume(Options& o) { return o.has("box") || o.has("shape") || o.has("position") || o.has("rotation"); }

void box_or_shape(Options& o, ShapePtr& shape, Vec3& position, Quat& rotation) {
  const bool has_box = box_option(o, shape, position);
  if (!has_box && !shape_option(o, "shape", shape))
    o.raise(nullptr, "expected box = {min, max} or shape =, got neither");
  if (has_box && (o.has("shape") || o.has("position"))) o.raise("box", "expected box or shape and position, got both");
  o.vector("position", position);
  o.rotation("rotation", rotation);
}

}  // namespace feder::lua
