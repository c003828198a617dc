// Shapes: makers by the rows of the runtime, userdata that share a shape, and lists of points.
#include "lua/shapes.h"

#include <cmath>
#include <deque>

#include "lua/buffer.h"
#include "lua/method.h"
#include "lua/sdf.h"
#include "lua/shape_surfaces.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxPoints = 10000000;

double size_argument(lua_State* L, int index, const char* name) {
  const double x = lua_type(L, index) == LUA_TNUMBER ? lua_tonumber(L, index) : -1;
  if (x > 1e-30 && x < 1e9) return x;  // the common case makes no strings
  return check_number(L, index, std::string(function_name(L)) + "." + name, Range{0, 1e9, true});
}

int shape_collected(lua_State* L) {
  static_cast<ShapePtr*>(lua_touserdata(L, 1))->~shared_ptr();
  return 0;
}

std::string shape_tostring(lua_State* L) {
  const auto* shape = static_cast<const ShapePtr*>(test_class(L, 1, Class::shape));
  return shape ? std::string("shape ") + (*shape)->kind() : "?";
}

// feder.<kind>(...), by the arguments of the kind's row.
int feder_shape(lua_State* L) {
  const std::string name = function_name(L);
  // the kind whose maker runs, by its name
  const ShapeKind& kind = shape_kinds()[static_cast<std::size_t>(shape_kind_id(name.c_str() + name.rfind('.') + 1))];
  const bool three_sizes = kind.arguments.size() == 3 && kind.arguments[2].type == ShapeArgumentType::size;
  if (three_sizes && lua_gettop(L) == 1 && lua_type(L, 1) == LUA_TTABLE) {  // as one vector
    const Vec3 size = check_vector(L, 1, name);
    lua_settop(L, 0);
    push(L, size);
  }
  int most = 0;
  for (const ShapeArgument& a : kind.arguments) most += a.type == ShapeArgumentType::direction ? 3 : 1;
  if (lua_gettop(L) > most)
    fail_here(L, "expected at most " + std::to_string(most) + " arguments, got " + std::to_string(lua_gettop(L)));
  ShapeInput in;
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;
  std::vector<CompoundPart> parts;
  std::vector<ShapeSurface> surfaces;
  std::vector<SurfaceNumber> triangle_surfaces;
  int at = 1, triangles_at = 0;
  for (const ShapeArgument& a : kind.arguments) {
    const int index = at++;
    const bool absent = !std::isnan(a.fallback) && lua_isnoneornil(L, index);
    switch (a.type) {
      case ShapeArgumentType::size: in.sizes.push_back(absent ? a.fallback : size_argument(L, index, a.name)); break;
      case ShapeArgumentType::number:
        in.sizes.push_back(absent ? a.fallback : check_number(L, index, name + "." + a.name, Range{-1e9, 1e9}));
        break;
      case ShapeArgumentType::direction:
        if (!absent || !lua_isnone(L, index)) in.direction = vector_argument(L, index, false, &at);
        break;
      case ShapeArgumentType::points:
      case ShapeArgumentType::points_2d:
        points = check_points(L, index, name + "." + a.name, a.type == ShapeArgumentType::points_2d);
        break;
      case ShapeArgumentType::triangles: triangles_at = index; break;
      case ShapeArgumentType::parts: parts = check_parts(L, index, surfaces); break;
      case ShapeArgumentType::surfaces: {
        MeshOptions options = check_mesh_options(L, index);
        surfaces = std::move(options.surfaces), in.mesh_index = options;
        break;
      }
    }
  }
  if (triangles_at > 0)  // which name points and surfaces
    triangles = check_triangles(L, triangles_at, points.size(), surfaces.size(), triangle_surfaces);
  in.points = points, in.triangles = triangles, in.parts = parts;
  in.surfaces = surfaces, in.triangle_surfaces = triangle_surfaces;
  push_userdata(L, Class::shape, kind.make(in));
  return 1;
}

int feder_left_out_shape(lua_State* L) { fail_here(L, "this build has no such shape"); }

const char* shape_kind(lua_State* L) {
  const auto* shape = static_cast<const ShapePtr*>(self_block(L));
  if (!shape) wrong_self(L, "shape");
  return (*shape)->kind();
}

const Method kShapeMethods[] = {
    {"kind", method<shape_kind>, "shape:kind() -> string", "\"box\", \"sphere\" ..."},
};

}  // namespace

// Those of this build, then those that it has not.
std::span<const Method> shape_functions() {
  static const std::vector<Method> all = [] {
    static std::deque<std::string> texts;  // that the rows point at
    std::vector<Method> rows;
    for (const ShapeKind& kind : shape_kinds()) {
      texts.push_back(std::string("feder.") + kind.name + kind.usage + " -> shape");
      if (kind.fields)
        rows.push_back({kind.name, guard<feder_sdf>, texts.back().c_str(), kind.summary, sdf_rows});
      else
        rows.push_back({kind.name, guard<feder_shape>, texts.back().c_str(), kind.summary, shape_rows(kind)});
    }
    const std::span<const Method> fields = sdf_functions();
    rows.insert(rows.end(), fields.begin(), fields.end());
    std::string absent = FEDER_WITHOUT ",geom.heightfield,";  // the last: to come
    for (std::size_t from = 0, end; (end = absent.find(',', from)) != std::string::npos; from = end + 1) {
      const std::string name = absent.substr(from, end - from);
      if (name.rfind("geom.", 0) != 0) continue;
      const std::string& usage = texts.emplace_back("feder." + name.substr(5) + "()");
      texts.push_back(name.substr(5));
      rows.push_back({texts.back().c_str(), guard<feder_left_out_shape>, usage.c_str(), "not in this build"});
    }
    return rows;
  }();
  return all;
}
std::span<const Method> shape_methods() { return kShapeMethods; }

bool shape_option(Options& o, const char* key, ShapePtr& out) {
  if (!o.push_any(key)) return false;
  const auto* shape = static_cast<const ShapePtr*>(test_class(o.L(), -1, Class::shape));
  if (!shape) o.wrong(key, "a shape (feder.box(1, 1, 1) ...)");
  out = *shape;
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
  each_entry(L, index,
             [&](lua_Integer i) { out.push_back(check_vector(L, -1, what + "[" + std::to_string(i) + "]", planar)); });
  return out;
}

bool points_option(Options& o, const char* key, std::vector<Vec3>& out) {
  if (!o.push_any(key)) return false;
  out = check_points(o.L(), -1, o.path(key), o.planar());
  lua_pop(o.L(), 1);
  return true;
}

void open_shapes(lua_State* L) {
  set_metamethods(L, Class::shape, {{"__tostring", method<shape_tostring>}, {"__gc", shape_collected}});
}

}  // namespace feder::lua
