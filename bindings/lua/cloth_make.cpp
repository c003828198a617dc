// world:cloth{ ... }: a sheet or a mesh, its stiffness, pins, and what it does with bodies and itself.
#include <algorithm>

#include "cloth/solver.h"
#include "lua/buffer.h"
#include "lua/cloth_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxTriangles = 40000000;

// A list of {i, j, k}, or a buffer of 3 n vertex numbers.
void read_triangles(Options& o, ClothDesc& desc) {
  lua_State* L = o.L();
  if (!o.push_any("triangles")) o.wrong("triangles", "a list of {i, j, k} or a buffer");
  const std::size_t count = desc.vertices.size();
  if (const auto numbers = test_buffer(L, -1); numbers.data()) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double x = numbers[i];
      if (!(x >= 1 && x <= static_cast<double>(count)) || x != static_cast<double>(static_cast<std::uint32_t>(x)))
        o.raise("triangles", "expected whole numbers from 1 to " + std::to_string(count) + ", got " + print_number(x) +
                                 " at place " + std::to_string(i + 1));
      desc.triangles.push_back(static_cast<std::uint32_t>(x) - 1);
    }
    lua_pop(L, 1);
    return;
  }
  if (lua_type(L, -1) != LUA_TTABLE) o.wrong("triangles", "a list of {i, j, k} or a buffer");
  const auto size = lua_rawlen(L, -1);
  if (size > kMaxTriangles) o.raise("triangles", "expected at most " + std::to_string(kMaxTriangles));
  charge(L, size);
  for (std::size_t t = 1; t <= size; ++t) {
    lua_rawgeti(L, -1, static_cast<lua_Integer>(t));
    const std::string what = o.path("triangles") + "[" + std::to_string(t) + "]";
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != 3)
      fail(L, what + ": expected three vertex numbers, got " + describe(L, -1));
    for (int k = 1; k <= 3; ++k) {
      lua_rawgeti(L, -1, k);
      desc.triangles.push_back(
          static_cast<std::uint32_t>(check_integer(L, -1, what, 1, static_cast<std::int64_t>(count)) - 1));
      lua_pop(L, 1);
    }
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

void read_geometry(Options& o, ClothDesc& desc) {
  lua_State* L = o.L();
  if (o.has("vertices")) {
    for (const char* key : {"size", "resolution"})
      if (o.has(key)) o.raise(key, "goes with a sheet; vertices and triangles make a mesh");
    o.push_any("vertices");
    desc.vertices = check_points(L, -1, o.path("vertices"));
    lua_pop(L, 1);
    read_triangles(o, desc);
    return;
  }
  if (o.has("triangles")) o.raise("triangles", "expected vertices too");
  const auto pair = [&](const char* key, double(&out)[2], const Range& range, bool whole) {
    if (!o.push(key, LUA_TTABLE, "two numbers")) return;
    if (lua_rawlen(L, -1) != 2) o.wrong(key, "two numbers");
    for (int k = 0; k < 2; ++k) {
      lua_rawgeti(L, -1, k + 1);
      const std::string what = o.path(key) + "[" + std::to_string(k + 1) + "]";
      out[k] = whole ? static_cast<double>(check_integer(L, -1, what, static_cast<std::int64_t>(range.lo), 4096))
                     : check_number(L, -1, what, range);
      lua_pop(L, 1);
    }
    lua_pop(L, 1);
  };
  double size[2] = {1, 1}, resolution[2] = {20, 20};
  pair("size", size, kPositive, false);
  pair("resolution", resolution, Range{2, 4096}, true);
  for (int k = 0; k < 2; ++k) desc.size[k] = static_cast<Real>(size[k]);
  desc.nx = static_cast<std::uint32_t>(resolution[0]), desc.ny = static_cast<std::uint32_t>(resolution[1]);
}

void read_pins(Options& o, ClothDesc& desc) {
  if (!o.push_any("pins")) return;
  lua_State* L = o.L();
  const auto one = [&](int index, const std::string& what) {
    const std::size_t count = desc.nx ? std::size_t(desc.nx) * desc.ny : desc.vertices.size();
    if (lua_type(L, index) == LUA_TSTRING)
      desc.pin_names.emplace_back(lua_tostring(L, index));
    else if (lua_type(L, index) == LUA_TNUMBER)
      desc.pins.push_back(
          static_cast<std::uint32_t>(check_integer(L, index, what, 1, static_cast<std::int64_t>(count)) - 1));
    else
      fail(L, what + ": expected a vertex number or a name, got " + describe(L, index));
  };
  if (lua_type(L, -1) == LUA_TTABLE) {
    const auto count = lua_rawlen(L, -1);
    for (std::size_t k = 1; k <= count; ++k) {
      lua_rawgeti(L, -1, static_cast<lua_Integer>(k));
      one(-1, o.path("pins") + "[" + std::to_string(k) + "]");
      lua_pop(L, 1);
    }
  } else {
    one(-1, o.path("pins"));
  }
  lua_pop(L, 1);
}

// wind = true | false | { drag =, lift = }
void read_wind(Options& o, ClothDesc& desc) {
  if (!o.push_any("wind")) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) == LUA_TBOOLEAN) {
    desc.wind = lua_toboolean(L, -1) != 0;
  } else if (lua_type(L, -1) == LUA_TTABLE) {
    Options inner(L, -1, o.path("wind"));
    inner.real("drag", desc.drag, kNotNegative);
    inner.real("lift", desc.lift, kNotNegative);
    inner.finish();
  } else {
    o.wrong("wind", "true, false or { drag =, lift = }");
  }
  lua_pop(L, 1);
}

// max_strain = a number | false
void read_max_strain(Options& o, ClothDesc& desc) {
  if (!o.push_any("max_strain")) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) == LUA_TBOOLEAN && !lua_toboolean(L, -1))
    desc.max_strain = kInfinity;
  else if (lua_type(L, -1) == LUA_TNUMBER)
    o.real("max_strain", desc.max_strain, kPositive);
  else
    o.wrong("max_strain", "a number above 0 or false");
  lua_pop(L, 1);
}

void read_cloth(Options& o, ClothDesc& desc) {
  lua_State* L = o.L();
  o.text("name", desc.name);
  read_geometry(o, desc);
  o.vector("position", desc.pose.position);
  o.rotation("rotation", desc.pose.rotation);
  o.vector("velocity", desc.velocity);
  o.real("area_density", desc.area_density, kPositive);
  o.real("stretch", desc.stretch, kPositive);
  o.real("shear", desc.shear, kNotNegative);
  o.real("bend", desc.bend, kNotNegative);
  o.real("damping", desc.damping, kNotNegative);
  o.real("thickness", desc.thickness, kPositive);
  o.real("friction", desc.friction, kNotNegative);
  o.flag("self_collision", desc.self_collision);
  read_wind(o, desc);
  o.real("tear_strain", desc.tear_strain, kPositive);
  read_max_strain(o, desc);
  o.real("gravity_scale", desc.gravity_scale);
  std::int64_t n = 0;
  if (o.integer("group", n, 0, 0xffffffffll)) desc.group = static_cast<std::uint32_t>(n);
  if (o.integer("mask", n, 0, 0xffffffffll)) desc.mask = static_cast<std::uint32_t>(n);
  if (o.integer("substeps", n, 1, 10000)) desc.substeps = static_cast<int>(n);
  if (o.integer("max_substeps", n, 1, 10000)) desc.max_substeps = static_cast<int>(n);
  o.real("stretch_error", desc.stretch_error, kPositive);
  if (o.text("solver", desc.solver)) find_variant(cloth_solvers(), desc.solver, "cloth solver");
  std::string integrator;
  if (o.text("integrator", integrator)) desc.solver_options.set("integrator", integrator);
  if (o.push("solver_options", LUA_TTABLE, "a table of options")) {
    Options inner(L, -1, o.path("solver_options"));
    inner.rest(desc.solver_options);
    lua_pop(L, 1);
  }
  read_pins(o, desc);
}

}  // namespace

int world_cloth(lua_State* L) {
  WorldRecord& r = check_world(L);
  if (r.planar()) fail_here(L, "expected a world of dimension 3: cloth has no 2D section; take a net");
  Options o(L, 2, function_name(L));
  ClothDesc desc;
  read_cloth(o, desc);
  o.has("tags");
  std::uint32_t color = 0;
  const bool colored = o.color("color", color);
  o.finish();
  desc.tags = tag_option(o, r);
  const ObjectId id = r.world->need<Cloth>().add_cloth(desc);
  if (colored) r.look.colors[id] = color;
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
