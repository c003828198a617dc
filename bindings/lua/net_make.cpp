// world:net{ ... }: points, masses, springs, pins, and what the net does with bodies.
#include <algorithm>

#include "lua/buffer.h"
#include "lua/shapes.h"
#include "lua/springs_part.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxSprings = 20000000;

// One number for all, a list, or a buffer.
void read_masses(Options& o, NetDesc& desc) {
  const std::size_t count = desc.points.size();
  desc.masses.assign(count, Real(1));
  if (!o.push_any("masses")) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) == LUA_TNUMBER) {
    Real m = 1;
    o.real("masses", m, kPositive);
    desc.masses.assign(count, m);
  } else {
    const auto numbers = test_buffer(L, -1);
    if (!numbers.data() && lua_type(L, -1) != LUA_TTABLE) o.wrong("masses", "a number above 0, or one per point");
    const std::size_t given = numbers.data() ? numbers.size() : lua_rawlen(L, -1);
    if (given != count)
      o.raise("masses", "expected " + std::to_string(count) + " numbers, one per point, got " + std::to_string(given));
    for (std::size_t i = 0; i < count; ++i) {
      if (numbers.data())
        lua_pushnumber(L, numbers[i]);
      else
        lua_rawgeti(L, -1, static_cast<lua_Integer>(i) + 1);
      desc.masses[i] =
          static_cast<Real>(check_number(L, -1, o.path("masses") + "[" + std::to_string(i + 1) + "]", kPositive));
      lua_pop(L, 1);
    }
  }
  lua_pop(L, 1);
}

// {i, j, stiffness =, ...}: the two numbers may also be called i and j.
SpringDesc read_spring_row(lua_State* L, int index, const std::string& what, std::size_t count,
                           const SpringDesc& defaults) {
  index = lua_absindex(L, index);
  if (lua_type(L, index) != LUA_TTABLE)
    fail(L, what + ": expected {i, j, stiffness =, ...}, got " + describe(L, index));
  SpringDesc s = defaults;
  const auto last = static_cast<std::int64_t>(count);
  const auto field = [&](int k, const char* name) {
    if (lua_rawgeti(L, index, k) == LUA_TNIL) {
      lua_pop(L, 1);
      lua_pushstring(L, name);
      lua_rawget(L, index);
    }
    const auto i = static_cast<std::uint32_t>(check_integer(L, -1, what + "." + name, 1, last) - 1);
    lua_pop(L, 1);
    return i;
  };
  s.i = field(1, "i"), s.j = field(2, "j");
  if (s.i == s.j) fail(L, what + ": expected two different points, got " + std::to_string(s.i + 1) + " twice");
  for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
    if (lua_isinteger(L, -2) && (lua_tointeger(L, -2) == 1 || lua_tointeger(L, -2) == 2)) continue;
    const std::string key = lua_type(L, -2) == LUA_TSTRING ? lua_tostring(L, -2) : "";
    if (key == "i" || key == "j") continue;
    if (key == "stiffness")
      s.stiffness = static_cast<Real>(check_number(L, -1, what + "." + key, kNotNegative));
    else if (key == "damping")
      s.damping = static_cast<Real>(check_number(L, -1, what + "." + key, kNotNegative));
    else if (key == "rest_length")
      s.rest_length = static_cast<Real>(check_number(L, -1, what + "." + key, kNotNegative));
    else if (key == "break_strain")
      s.break_strain = static_cast<Real>(check_number(L, -1, what + "." + key, kPositive));
    else if (key == "power")
      s.power = static_cast<int>(check_integer(L, -1, what + "." + key, 1, 9));
    else if (key == "tension_only") {
      if (lua_type(L, -1) != LUA_TBOOLEAN)
        fail(L, what + "." + key + ": expected true or false, got " + describe(L, -1));
      s.tension_only = lua_toboolean(L, -1) != 0;
    } else {
      const std::string near =
          nearest_name(key, {"i", "j", "stiffness", "damping", "rest_length", "break_strain", "tension_only", "power"});
      fail(L, what + ": unknown option " + describe(L, -2) + (near.empty() ? "" : "; did you mean '" + near + "'?"));
    }
  }
  return s;
}

void read_springs(Options& o, NetDesc& desc) {
  SpringDesc defaults;
  o.real("stiffness", defaults.stiffness, kNotNegative);
  o.real("spring_damping", defaults.damping, kNotNegative);
  o.real("break_strain", defaults.break_strain, kPositive);
  o.flag("tension_only", defaults.tension_only);
  std::int64_t power = 1;
  if (o.integer("power", power, 1, 9)) defaults.power = static_cast<int>(power);
  if (!o.push("springs", LUA_TTABLE, "a list of {i, j, stiffness =, ...}")) return;
  lua_State* L = o.L();
  const auto count = lua_rawlen(L, -1);
  if (count > kMaxSprings)
    o.raise("springs", "expected at most " + std::to_string(kMaxSprings) + " springs, got " + std::to_string(count));
  desc.springs.reserve(count);
  charge(L, count);
  for (std::size_t k = 1; k <= count; ++k) {
    lua_rawgeti(L, -1, static_cast<lua_Integer>(k));
    const std::string what = o.path("springs") + "[" + std::to_string(k) + "]";
    const SpringDesc s = read_spring_row(L, -1, what, desc.points.size(), defaults);
    if (s.rest_length < 0 && !(length(desc.points[s.i] - desc.points[s.j]) > 0))
      fail(L, what + ": points " + std::to_string(s.i + 1) + " and " + std::to_string(s.j + 1) +
                  " are at the same place; expected a rest_length, got nil");
    desc.springs.push_back(s);
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

// A list of point numbers.
std::vector<std::size_t> read_pins(Options& o, std::size_t points) {
  std::vector<std::size_t> pins;
  if (!o.push("pins", LUA_TTABLE, "a list of point numbers")) return pins;
  lua_State* L = o.L();
  const auto count = lua_rawlen(L, -1);
  for (std::size_t k = 1; k <= count; ++k) {
    lua_rawgeti(L, -1, static_cast<lua_Integer>(k));
    pins.push_back(static_cast<std::size_t>(
        check_integer(L, -1, o.path("pins") + "[" + std::to_string(k) + "]", 1, static_cast<std::int64_t>(points)) -
        1));
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return pins;
}

// Triangles of point numbers, for drawing, export and fluids; a face of four is cut in two.
std::vector<std::uint32_t> read_faces(Options& o, std::size_t points) {
  std::vector<std::uint32_t> faces;
  if (!o.push("faces", LUA_TTABLE, "a list of {i, j, k}")) return faces;
  lua_State* L = o.L();
  const auto count = lua_rawlen(L, -1);
  for (std::size_t f = 1; f <= count; ++f) {
    lua_rawgeti(L, -1, static_cast<lua_Integer>(f));
    const std::string what = o.path("faces") + "[" + std::to_string(f) + "]";
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) < 3 || lua_rawlen(L, -1) > 4)
      fail(L, what + ": expected three or four point numbers, got " + describe(L, -1));
    const int corners = static_cast<int>(lua_rawlen(L, -1));
    std::uint32_t corner[4] = {};
    for (int k = 0; k < corners; ++k) {
      lua_rawgeti(L, -1, k + 1);
      corner[k] = static_cast<std::uint32_t>(check_integer(L, -1, what, 1, static_cast<std::int64_t>(points)) - 1);
      lua_pop(L, 1);
    }
    faces.insert(faces.end(), {corner[0], corner[1], corner[2]});
    if (corners == 4) faces.insert(faces.end(), {corner[0], corner[2], corner[3]});
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return faces;
}

void read_net(Options& o, NetDesc& desc, std::vector<std::uint32_t>& faces) {
  lua_State* L = o.L();
  o.text("name", desc.name);
  if (!o.push_any("points")) o.wrong("points", "a list of {x, y, z} or a buffer");
  desc.points = check_points(L, -1, o.path("points"), o.planar());
  lua_pop(L, 1);
  if (desc.points.empty()) o.raise("points", "expected at least one point, got none");
  if (o.push_any("velocities")) {
    desc.velocities = check_points(L, -1, o.path("velocities"), o.planar());
    lua_pop(L, 1);
    if (desc.velocities.size() != desc.points.size())
      o.raise("velocities", "expected " + std::to_string(desc.points.size()) + ", one per point, got " +
                                std::to_string(desc.velocities.size()));
  }
  read_masses(o, desc);
  read_springs(o, desc);
  desc.faces = faces = read_faces(o, desc.points.size());
  if (o.text("integrator", desc.integrator)) find_variant(integrators(), desc.integrator, "integrator");
  if (o.push("integrator_options", LUA_TTABLE, "a table of options")) {
    Options inner(L, -1, o.path("integrator_options"));
    inner.rest(desc.integrator_options);
    lua_pop(L, 1);
  }
  o.real("damping", desc.damping, kNotNegative);
  o.real("radius", desc.radius, kNotNegative);
  o.real("friction", desc.friction, kNotNegative);
  o.real("restitution", desc.restitution, Range{0, 1});
  std::int64_t bits = 0;
  o.flag("self_collision", desc.self_collision);
  if (o.integer("group", bits, 0, 0xffffffffll)) desc.group = static_cast<std::uint32_t>(bits);
  if (o.integer("mask", bits, 0, 0xffffffffll)) desc.mask = static_cast<std::uint32_t>(bits);
  o.real("gravity_scale", desc.gravity_scale);
}

}  // namespace

SpringDesc read_spring(Options& o, std::size_t point_count) {
  return read_spring_row(o.L(), o.index(), o.owner(), point_count, {});
}

int world_net(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  NetDesc desc;
  std::vector<std::uint32_t> faces;
  read_net(o, desc, faces);
  std::uint32_t color = 0;
  const bool colored = o.color("color", color);
  const std::vector<std::size_t> pins = read_pins(o, desc.points.size());
  o.has("tags");
  o.finish();
  desc.tags = tag_option(o, r);
  const ObjectId id = r.world->need<Springs>().add_net(desc);
  for (std::size_t i : pins) r.world->need<Springs>().pin(id, i);
  if (!faces.empty()) r.look.faces[id] = std::move(faces);
  if (colored) r.look.colors[id] = color;
  push_handle(L, r, id);
  return 1;
}

}  // namespace feder::lua
