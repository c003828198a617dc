// world:net{ ... }: points, masses, springs, pins, and what the net does with bodies.

#include "integrate/integrator.h"
#include "lua/buffer.h"
#include "lua/shapes.h"
#include "lua/springs_part.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxSprings = 20000000;

struct NetReading : Making<NetDesc>, SpringDesc {  // what springs have that say nothing else
  std::vector<std::size_t> pins;
  using NetDesc::damping;
};

constexpr Option<SpringDesc> kSpring[] = {
    later<SpringDesc>("i", "integer"),
    later<SpringDesc>("j", "integer"),
    field<&SpringDesc::stiffness>("stiffness", "N/m", kNotNegative),
    field<&SpringDesc::damping>("damping", "N s/m", kNotNegative),
    field<&SpringDesc::rest_length>("rest_length", "m", kNotNegative).unset(),
    field<&SpringDesc::break_strain>("break_strain", "", kPositive),
    field<&SpringDesc::power>("power", "", {1, 9}),
    field<&SpringDesc::tension_only>("tension_only"),
};

// More than the two numbers, which is all that most springs of a large net have?
bool has_options(lua_State* L, int index) {
  for (lua_pushnil(L); lua_next(L, index); lua_pop(L, 1)) {
    if (lua_isinteger(L, -2) && (lua_tointeger(L, -2) == 1 || lua_tointeger(L, -2) == 2)) continue;
    lua_pop(L, 2);
    return true;
  }
  return false;
}

// One number for all, a list, or a buffer.
void read_masses(Options& o, const OptionRow& row, NetReading& desc) {
  const std::size_t count = desc.points.size();
  desc.masses.assign(count, Real(1));
  if (!o.push_any("masses")) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) == LUA_TNUMBER) {
    Real m = 1;
    o.real("masses", m, row.range);
    desc.masses.assign(count, m);
  } else {
    const auto numbers = test_buffer(L, -1);
    if (!numbers.data() && lua_type(L, -1) != LUA_TTABLE) o.wrong("masses", "a number above 0, or one per point");
    const std::size_t given = numbers.data() ? numbers.size() : lua_rawlen(L, -1);
    if (given != count)
      o.raise("masses", "expected " + std::to_string(count) + " numbers, one per point, got " + std::to_string(given));
    for (std::size_t i = 0; i < count; ++i) {
      numbers.data() ? push(L, numbers[i]) : lua_rawgeti(L, -1, static_cast<lua_Integer>(i) + 1);
      desc.masses[i] =
          static_cast<Real>(check_number(L, -1, o.path("masses") + "[" + std::to_string(i + 1) + "]", row.range));
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
  const auto field = [&](int k, const char* name) {
    if (lua_rawgeti(L, index, k) == LUA_TNIL) {
      lua_pop(L, 1);
      lua_pushstring(L, name);
      lua_rawget(L, index);
    }
    const std::uint32_t i = check_index(L, -1, what + "." + name, count);
    lua_pop(L, 1);
    return i;
  };
  s.i = field(1, "i"), s.j = field(2, "j");
  if (s.i == s.j) fail(L, what + ": expected two different points, got " + std::to_string(s.i + 1) + " twice");
  if (has_options(L, index)) {
    Options o(L, index, what);
    o.skip_entries(2);
    o.read(kSpring, s);
  }
  return s;
}

void read_springs(Options& o, const OptionRow&, NetReading& desc) {
  const SpringDesc& defaults = desc;
  if (!o.push("springs", LUA_TTABLE, "a list of {i, j, stiffness =, ...}")) return;
  lua_State* L = o.L();
  const auto count = lua_rawlen(L, -1);
  if (count > kMaxSprings)
    o.raise("springs", "expected at most " + std::to_string(kMaxSprings) + " springs, got " + std::to_string(count));
  desc.springs.reserve(count);
  charge(L, count);
  each_entry(L, -1, [&](lua_Integer k) {
    const std::string what = o.path("springs") + "[" + std::to_string(k) + "]";
    const SpringDesc s = read_spring_row(L, -1, what, desc.points.size(), defaults);
    if (s.rest_length < 0 && !(length(desc.points[s.i] - desc.points[s.j]) > 0))
      fail(L, what + ": points " + std::to_string(s.i + 1) + " and " + std::to_string(s.j + 1) +
                  " are at the same place; expected a rest_length, got nil");
    desc.springs.push_back(s);
  });
  lua_pop(L, 1);
}

// A list of point numbers.
void read_pins(Options& o, const OptionRow&, NetReading& desc) {
  if (!o.push("pins", LUA_TTABLE, "a list of point numbers")) return;
  each_entry(o.L(), -1, [&](lua_Integer k) {
    desc.pins.push_back(check_index(o.L(), -1, o.path("pins") + "[" + std::to_string(k) + "]", desc.points.size()));
  });
  lua_pop(o.L(), 1);
}

// Triangles of point numbers, for drawing, export and fluids; a face of four is cut in two.
void read_faces(Options& o, const OptionRow&, NetReading& desc) {
  if (!o.push("faces", LUA_TTABLE, "a list of {i, j, k}")) return;
  std::vector<std::uint32_t> corner;
  each_entry(o.L(), -1, [&](lua_Integer f) {
    const std::string what = o.path("faces") + "[" + std::to_string(f) + "]";
    corner.clear();
    check_indices(o.L(), -1, what, "three or four point numbers", 3, 4, desc.points.size(), corner);
    desc.faces.insert(desc.faces.end(), {corner[0], corner[1], corner[2]});
    if (corner.size() == 4) desc.faces.insert(desc.faces.end(), {corner[0], corner[2], corner[3]});
  });
  lua_pop(o.L(), 1);
}

void read_points(Options& o, const OptionRow&, NetReading& desc) {
  if (!points_option(o, "points", desc.points)) o.wrong("points", "a list of {x, y, z} or a buffer");
  if (desc.points.empty()) o.raise("points", "expected at least one point, got none");
}

void read_velocities(Options& o, const OptionRow&, NetReading& desc) {
  if (points_option(o, "velocities", desc.velocities) && desc.velocities.size() != desc.points.size())
    o.raise("velocities", "expected " + std::to_string(desc.points.size()) + ", one per point, got " +
                              std::to_string(desc.velocities.size()));
}

void read_integrator(Options& o, const OptionRow&, NetReading& desc) {
  if (o.text("integrator", desc.integrator)) find_variant(integrators(), desc.integrator, "integrator");
}

std::string show_integrator(const NetReading& desc) { return print_value(desc.integrator); }

constexpr Option<NetReading> kNet[] = {
    field<&NetDesc::name>("name"),
    special("points", "list of vectors or buffer", read_points, "m"),
    special("velocities", "list of vectors or buffer", read_velocities, "m/s"),
    {{.name = "masses", .unit = "kg", .range = kPositive}, "number, list or buffer", read_masses},
    // of springs that say nothing else
    field<&SpringDesc::stiffness>("stiffness", "N/m", kNotNegative),
    field<&SpringDesc::damping>("spring_damping", "N s/m", kNotNegative),
    field<&SpringDesc::break_strain>("break_strain", "", kPositive),
    field<&SpringDesc::tension_only>("tension_only"),
    field<&SpringDesc::power>("power", "", {1, 9}),
    {{.name = "springs"}, "list of {i, j, ...}", read_springs, nullptr, rows_of<kSpring>},
    special("faces", "list of {i, j, k}", read_faces),
    {{.name = "integrator"}, "string", read_integrator, show_integrator, nullptr, names_of<integrators>},
    field<&NetDesc::integrator_options>("integrator_options").with(options_of<integrators>),
    field<&NetDesc::damping>("damping", "1/s", kNotNegative),
    field<&NetDesc::radius>("radius", "m", kNotNegative),
    field<&NetDesc::friction>("friction", "", kNotNegative),
    field<&NetDesc::restitution>("restitution", "", kUnitRange),
    field<&NetDesc::self_collision>("self_collision"),
    field<&NetDesc::group>("group", "", kBits),
    field<&NetDesc::mask>("mask", "", kBits),
    field<&NetDesc::gravity_scale>("gravity_scale", "", kGravityScale),
    special("color", "color", read_color<NetReading>),
    special("pins", "list of point numbers", read_pins),
    later<NetReading>("tags", kWordsType),
};

}  // namespace

SpringDesc read_spring(Options& o, std::size_t point_count) {
  return read_spring_row(o.L(), o.index(), o.owner(), point_count, {});
}

std::vector<OptionInfo> net_rows() { return describe_rows(kNet); }

ObjectId world_net(WorldRecord& r, lua_State* L) {
  const NetReading net = read_description(L, r, kNet);
  Springs& springs = system_of<Springs>(r);
  const ObjectId id = springs.add_net(net);
  for (std::size_t i : net.pins) springs.pin(id, i);
  if (!net.faces.empty()) r.appearance.faces[id] = net.faces;
  if (net.painted) r.appearance.colors[id] = net.color;
  return id;
}

}  // namespace feder::lua
