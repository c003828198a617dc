// Distance fields from scripts. A function is asked for every corner within one call that has a budget of its own: so
// many instructions per corner, whatever the rest of the script may take.
#include "lua/sdf.h"

#include <cmath>
#include <utility>

#include "feder/sdf.h"
#include "lua/buffer.h"
#include "lua/method.h"
#include "lua/shape_surfaces.h"
#include "lua/shapes.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

constexpr std::uint64_t kInstructionsPerCorner = 2000;
constexpr double kDefaultCells = 65;  // corners along a side, when no spacing is given

struct SdfReading {
  SdfDesc desc = {};
  std::vector<Vec3> vertices = {};
  std::vector<std::uint32_t> triangles = {};
  std::vector<double> values = {};
  int function = 0;  // on the stack
};

void take_mesh(SdfReading& r, const Shape& mesh) {
  ShapeArguments of = mesh.arguments();
  r.vertices = std::move(of.points), r.triangles = std::move(of.triangles);
}

// One that has triangles and no inside.
bool is_mesh(const Shape& s) { return !(s.mass(1).mass > 0) && !s.arguments().triangles.empty(); }

void read_mesh(Options& o, const OptionRow& row, SdfReading& r) {
  if (!o.push_any(row.name)) return;
  lua_State* L = o.L();
  if (const auto* shape = static_cast<const ShapePtr*>(test_class(L, -1, Class::shape))) {
    if (!is_mesh(**shape)) o.wrong(row.name, "a mesh (feder.mesh(vertices, triangles)) or { vertices, triangles }");
    take_mesh(r, **shape);
    return lua_pop(L, 1);
  }
  if (lua_type(L, -1) != LUA_TTABLE) o.wrong(row.name, "{ vertices, triangles }");
  const int table = lua_gettop(L);
  const auto part = [&](int number, const char* name) {
    if (lua_getfield(L, table, name) == LUA_TNIL) lua_pop(L, 1), lua_rawgeti(L, table, number);
  };
  part(1, "vertices");
  r.vertices = check_points(L, -1, o.path(row.name) + ".vertices");
  part(2, "triangles");
  std::vector<SurfaceNumber> none;
  r.triangles = check_triangles(L, -1, r.vertices.size(), 0, none);
  lua_pop(L, 3);
  if (r.triangles.empty()) o.raise(row.name, "expected triangles, got none");
}

void read_shape(Options& o, const OptionRow& row, SdfReading& r) {
  if (!shape_option(o, row.name, r.desc.shape) || !is_mesh(*r.desc.shape)) return;
  take_mesh(r, *r.desc.shape);
  r.desc.shape = nullptr;
}

void read_function(Options& o, const OptionRow& row, SdfReading& r) {
  if (o.push(row.name, LUA_TFUNCTION, "a function of x, y, z that returns a distance")) r.function = lua_gettop(o.L());
}

void read_buffer(Options& o, const OptionRow& row, SdfReading& r) {
  if (!o.push_any(row.name)) return;
  lua_State* L = o.L();
  if (const auto numbers = test_buffer(L, -1); numbers.data())
    r.values.assign(numbers.begin(), numbers.end());
  else if (lua_type(L, -1) == LUA_TTABLE)
    each_entry(L, -1, [&](lua_Integer i) {
      r.values.push_back(check_number(L, -1, o.path(row.name) + "[" + std::to_string(i) + "]"));
    });
  else
    o.wrong(row.name, "a buffer of distances");
  lua_pop(L, 1);
  if (r.values.empty()) o.raise(row.name, "expected distances, got none");
}

void read_size(Options& o, const OptionRow& row, SdfReading& r) {
  if (!o.push_any(row.name)) return;
  const bool number = lua_type(o.L(), -1) == LUA_TNUMBER;
  lua_pop(o.L(), 1);
  if (!number) {
    o.vector(row.name, r.desc.size);
  } else {
    Real side = 0;
    o.real(row.name, side, kPositive);
    r.desc.size = Vec3::Constant(side);
  }
}

void read_spacing(Options& o, const OptionRow& row, SdfReading& r) { o.real(row.name, r.desc.spacing, kPositive); }
void read_adaptive(Options& o, const OptionRow& row, SdfReading& r) { o.flag(row.name, r.desc.adaptive); }
void read_tolerance(Options& o, const OptionRow& row, SdfReading& r) {
  o.real(row.name, r.desc.tolerance, kNotNegative);
}
void read_acquire(Options& o, const OptionRow& row, SdfReading& r) { o.choice(row.name, row.choices, r.desc.acquire); }

constexpr Option<SdfReading> kSdf[] = {
    special("mesh", "{vertices, triangles} or mesh", read_mesh),
    special("shape", "shape", read_shape),
    special("fn", "function(x, y, z) -> distance", read_function),
    special("buffer", "buffer of distances, x fastest", read_buffer),
    special("size", "vector or number", read_size, "m"),
    {{.name = "spacing", .unit = "m", .range = kPositive}, "number", read_spacing},
    {{.name = "adaptive"}, "boolean", read_adaptive},
    {{.name = "tolerance", .unit = "m", .range = kNotNegative}, "number", read_tolerance},
    {{.name = "acquire", .choices = "exact, rasterise, rays"}, "string", read_acquire},
};

ShapePtr make_field(lua_State* L, const SdfDesc& desc) {
  const MakeSdf& host = state(L).options.make_field;
  return host ? host(desc) : make_sdf(desc);
}

// The call with the budget: the reading as a light userdata, then the function. Returns the shape.
int make_from_function(lua_State* L) {
  auto& r = *static_cast<SdfReading*>(lua_touserdata(L, 1));
  double corners = 1;
  for (int k = 0; k < 3; ++k) {
    const double n = r.desc.spacing > 0 ? double(r.desc.size[k]) / double(r.desc.spacing) + 1 : kDefaultCells;
    corners *= std::min(std::max(n, 1.0), 1e6);
  }
  const double most = std::min(corners, double(kMostSdfCorners));
  State& s = state(L);
  s.budget = static_cast<std::uint64_t>(most + 10000) * kInstructionsPerCorner;
  r.desc.function = [L](double x, double y, double z) {
    lua_pushvalue(L, 2);
    lua_pushnumber(L, x), lua_pushnumber(L, y), lua_pushnumber(L, z);
    lua_call(L, 3, 1);
    if (lua_type(L, -1) != LUA_TNUMBER)
      throw SceneError("sdf.fn: expected a number, got " + describe(L, -1) + " at (" + print_number(x) + ", " +
                       print_number(y) + ", " + print_number(z) + ")");
    const double d = lua_tonumber(L, -1);
    lua_pop(L, 1);
    return d;
  };
  ShapePtr made = make_field(L, r.desc);
  r.desc.function = {};
  push_userdata(L, Class::shape, std::move(made));
  return 1;
}

int push_from_function(lua_State* L, SdfReading& r) {
  State& s = state(L);
  lua_pushcfunction(L, guard<make_from_function>);
  lua_pushlightuserdata(L, &r);
  lua_pushvalue(L, r.function);
  const int depth = std::exchange(s.depth, 0);
  const std::uint64_t left = s.budget;
  const double start = s.lua_start;
  Failure failure;
  const bool good = s.call(L, 2, 1, failure);
  s.depth = depth;
  if (depth > 0) s.budget = left, s.lua_start = start;
  r.desc.function = {};
  if (good) return 1;
  if (failure.limit == Limit::instructions)
    failure.message = "fn: more than " + std::to_string(kInstructionsPerCorner) +
                      " instructions for each corner of the grid; ask less of it, or give a buffer";
  const bool elsewhere = !failure.where.empty() && failure.where != location(L, 1);
  relay(L, failure.message + (elsewhere ? " (" + failure.where + ")" : ""));
}

const Shape& check_solid(lua_State* L, int index) {
  const auto* shape = static_cast<const ShapePtr*>(test_class(L, index, Class::shape));
  if (!shape) fail_here(L, "expected a shape as argument " + std::to_string(index) + ", got " + describe(L, index));
  return **shape;
}

void read_position(Options& o, const OptionRow& row, Pose& p) { o.vector(row.name, p.position); }
void read_rotation(Options& o, const OptionRow& row, Pose& p) { o.rotation(row.name, p.rotation); }

constexpr Option<Pose> kPlace[] = {
    special("position", "vector", read_position, "m"),
    special("rotation", "rotation", read_rotation),
};

Pose check_place(lua_State* L, int index) {
  Pose place;
  if (!lua_isnoneornil(L, index)) Options(L, index, function_name(L)).read(kPlace, place);
  return place;
}

template <ShapePtr (*Combine)(const Shape&, const Shape&, const Pose&)>
int sdf_combine(lua_State* L) {
  const Shape &a = check_solid(L, 1), &b = check_solid(L, 2);
  const Pose place = check_place(L, 3);
  ShapePtr made;
  state(L).outside_lua([&] { made = Combine(a, b, place); });
  push_userdata(L, Class::shape, std::move(made));
  return 1;
}

int sdf_grow(lua_State* L) {
  const Shape& a = check_solid(L, 1);
  const double by = check_number(L, 2, std::string(function_name(L)) + ".distance", Range{-1e6, 1e6});
  push_userdata(L, Class::shape, sdf_offset(a, static_cast<Real>(by)));
  return 1;
}

}  // namespace

int feder_sdf(lua_State* L) {
  if (lua_gettop(L) != 1 || lua_type(L, 1) != LUA_TTABLE)
    fail_here(L, "expected a table { mesh = | shape = | fn = | buffer =, ... }, got " + describe(L, 1));
  SdfReading r;
  Options(L, 1, function_name(L)).read(kSdf, r);
  r.desc.vertices = r.vertices, r.desc.triangles = r.triangles, r.desc.values = r.values;
  if (r.function > 0) {
    if (r.desc.shape || !r.triangles.empty() || !r.values.empty())
      fail_here(L, "expected one of mesh, shape, fn and buffer, got more");
    return push_from_function(L, r);
  }
  ShapePtr made;
  State& s = state(L);
  s.outside_lua([&] { made = make_field(L, r.desc); });
  push_userdata(L, Class::shape, std::move(made));
  return 1;
}

std::vector<OptionInfo> sdf_rows() { return describe_rows(kSdf); }

std::span<const Method> sdf_functions() {
  static const Method all[] = {
      {"sdf_union", guard<sdf_combine<sdf_union>>,
       "feder.sdf_union(shape, other_shape, [{ position =, rotation = }]) -> shape",
       "both as one field; the other lies at that place in the frame of the first", rows_of<kPlace>},
      {"sdf_subtract", guard<sdf_combine<sdf_subtract>>,
       "feder.sdf_subtract(shape, other_shape, [{ position =, rotation = }]) -> shape",
       "the first without the other, which lies at that place in its frame", rows_of<kPlace>},
      {"sdf_intersect", guard<sdf_combine<sdf_intersect>>,
       "feder.sdf_intersect(shape, other_shape, [{ position =, rotation = }]) -> shape",
       "what both have in common; the other lies at that place in the frame of the first", rows_of<kPlace>},
      {"sdf_offset", guard<sdf_grow>, "feder.sdf_offset(shape, distance) -> shape",
       "a field grown by the distance in m; shrunk when below 0"},
  };
  for (const ShapeKind& kind : shape_kinds())
    if (kind.fields) return all;
  return {};
}

}  // namespace feder::lua
