// world:cloth{ ... }: a sheet or a mesh, its stiffness, pins, and what it does with bodies and itself.

#include "bounds/box_search.h"
#include "cloth/solver.h"
#include "lua/buffer.h"
#include "lua/cloth_part.h"
#include "lua/plastic.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxTriangles = 40000000;

struct ClothReading : Making<ClothDesc> {
  Vec3 position = Vec3::Zero();
  Quat rotation;
};

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
  each_entry(L, -1, [&](lua_Integer t) {
    const std::string what = o.path("triangles") + "[" + std::to_string(t) + "]";
    check_indices(L, -1, what, "three vertex numbers", 3, 3, count, desc.triangles);
  });
  lua_pop(L, 1);
}

// Two numbers under one key.
bool read_pair(Options& o, const OptionRow& row, double (&out)[2], bool whole) {
  lua_State* L = o.L();
  if (!o.push(row.name, LUA_TTABLE, "two numbers")) return false;
  if (lua_rawlen(L, -1) != 2) o.wrong(row.name, "two numbers");
  each_entry(L, -1, [&](lua_Integer k) {
    const std::string what = o.path(row.name) + "[" + std::to_string(k) + "]";
    out[k - 1] = whole ? static_cast<double>(check_integer(L, -1, what, static_cast<std::int64_t>(row.range.lo),
                                                           static_cast<std::int64_t>(row.range.hi)))
                       : check_number(L, -1, what, row.range);
  });
  lua_pop(L, 1);
  return true;
}

void read_vertices(Options& o, const OptionRow&, ClothReading& desc) {
  if (o.has("vertices")) {
    for (const char* key : {"size", "resolution"})
      if (o.has(key)) o.raise(key, "goes with a sheet; vertices and triangles make a mesh");
    points_option(o, "vertices", desc.vertices);
    read_triangles(o, desc);
    return;
  }
  if (o.has("triangles")) o.raise("triangles", "expected vertices too");
  desc.nx = desc.ny = 20;
}

void read_size(Options& o, const OptionRow& row, ClothReading& desc) {
  double size[2];
  if (read_pair(o, row, size, false))
    for (int k = 0; k < 2; ++k) desc.size[k] = static_cast<Real>(size[k]);
}

void read_resolution(Options& o, const OptionRow& row, ClothReading& desc) {
  double n[2];
  if (read_pair(o, row, n, true))
    desc.nx = static_cast<std::uint32_t>(n[0]), desc.ny = static_cast<std::uint32_t>(n[1]);
}

void read_pins(Options& o, const OptionRow&, ClothReading& desc) {
  if (!o.push_any("pins")) return;
  lua_State* L = o.L();
  const auto one = [&](int index, const std::string& what) {
    const std::size_t count = desc.nx ? std::size_t(desc.nx) * desc.ny : desc.vertices.size();
    if (lua_type(L, index) == LUA_TSTRING)
      desc.pin_names.emplace_back(lua_tostring(L, index));
    else if (lua_type(L, index) == LUA_TNUMBER)
      desc.pins.push_back(check_index(L, index, what, count));
    else
      fail(L, what + ": expected a vertex number or a name, got " + describe(L, index));
  };
  if (lua_type(L, -1) == LUA_TTABLE)
    each_entry(L, -1, [&](lua_Integer k) { one(-1, o.path("pins") + "[" + std::to_string(k) + "]"); });
  else
    one(-1, o.path("pins"));
  lua_pop(L, 1);
}

constexpr Option<ClothReading> kWind[] = {
    field<&ClothDesc::drag>("drag", "", kNotNegative),
    field<&ClothDesc::lift>("lift", "", kNotNegative),
};

// wind = true | false | { drag =, lift = }
void read_wind(Options& o, const OptionRow&, ClothReading& desc) {
  if (!o.push_any("wind")) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) == LUA_TBOOLEAN) {
    desc.wind = lua_toboolean(L, -1) != 0;
  } else if (lua_type(L, -1) == LUA_TTABLE) {
    Options inner(L, -1, o.path("wind"));
    inner.read(kWind, desc);
  } else {
    o.wrong("wind", "true, false or { drag =, lift = }");
  }
  lua_pop(L, 1);
}

// max_strain = a number | false
void read_max_strain(Options& o, const OptionRow& row, ClothReading& desc) {
  if (!o.push_any("max_strain")) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) == LUA_TBOOLEAN && !lua_toboolean(L, -1))
    desc.max_strain = kInfinity;
  else if (lua_type(L, -1) == LUA_TNUMBER)
    o.real("max_strain", desc.max_strain, row.range);
  else
    o.wrong("max_strain", "a number above 0 or false");
  lua_pop(L, 1);
}

void read_solver(Options& o, const OptionRow&, ClothReading& desc) {
  if (o.text("solver", desc.solver)) find_variant(cloth_solvers(), desc.solver, "cloth solver");
}

std::string show_solver(const ClothReading& desc) { return print_value(desc.solver); }

void read_self(Options& o, const OptionRow&, ClothReading& desc) {
  if (o.text("self", desc.self)) find_variant(box_searches(), desc.self, "search of self-contact");
}

std::string show_self(const ClothReading&) { return print_value(default_box_search()); }

std::string inside_names() { return "guard, ignore"; }

void read_inside(Options& o, const OptionRow&, ClothReading& desc) {
  if (o.text("inside", desc.inside) && desc.inside != "guard" && desc.inside != "ignore")
    o.raise("inside", "expected 'guard' or 'ignore', got '" + desc.inside + "'");
}

std::string show_inside(const ClothReading& desc) { return print_value(desc.inside); }

void read_integrator(Options& o, const OptionRow&, ClothReading& desc) {
  std::string integrator;
  if (o.text("integrator", integrator)) desc.solver_options.set("integrator", integrator);
}

constexpr Option<ClothReading> kCloth[] = {
    field<&ClothDesc::name>("name"),
    special("vertices", "list of vectors or buffer", read_vertices, "m"),
    later<ClothReading>("triangles", "list of {i, j, k} or buffer"),
    {{.name = "size", .unit = "m", .range = kPositive}, "{width, depth}", read_size},
    {{.name = "resolution", .range = {2, 4096}}, "{columns, rows}", read_resolution},
    field<&ClothReading::position>("position", "m"),
    field<&ClothReading::rotation>("rotation"),
    field<&ClothDesc::velocity>("velocity", "m/s"),
    field<&ClothDesc::area_density>("area_density", "kg/m2", kPositive),
    field<&ClothDesc::stretch>("stretch", "N/m", kPositive),
    field<&ClothDesc::shear>("shear", "N/m", kNotNegative).unset(),
    field<&ClothDesc::warp>("warp", "N/m", kPositive).unset(),
    field<&ClothDesc::weft>("weft", "N/m", kPositive).unset(),
    field<&ClothDesc::warp_axis>("warp_axis"),
    field<&ClothDesc::bend>("bend", "N m", kNotNegative),
    field<&ClothDesc::damping>("damping", "s", kNotNegative),
    field<&ClothDesc::thickness>("thickness", "m", kPositive),
    field<&ClothDesc::friction>("friction", "", kNotNegative),
    field<&ClothDesc::self_collision>("self_collision"),
    {{.name = "self"}, "string", read_self, show_self, nullptr, names_of<box_searches>},
    {{.name = "inside"}, "string", read_inside, show_inside, nullptr, inside_names},
    {{.name = "wind"}, "boolean or table", read_wind, nullptr, rows_of<kWind>},
    field<&ClothDesc::tear_strain>("tear_strain", "", kPositive),
    {{.name = "max_strain", .range = kPositive}, "number or false", read_max_strain},
    {{.name = "plastic"}, "table", read_plastic<ClothReading>, nullptr, rows_of<kPlastic<ClothReading>>},
    field<&ClothDesc::pressure>("pressure", "Pa", kNotNegative),
    field<&ClothDesc::gravity_scale>("gravity_scale", "", kGravityScale),
    field<&ClothDesc::group>("group", "", kBits),
    field<&ClothDesc::mask>("mask", "", kBits),
    field<&ClothDesc::substeps>("substeps", "", {1, 10000}).unset(),
    field<&ClothDesc::max_substeps>("max_substeps", "", {0, 10000}),
    field<&ClothDesc::stretch_error>("stretch_error", "", kPositive).unset(),
    {{.name = "solver"}, "string", read_solver, show_solver, nullptr, names_of<cloth_solvers>},
    special("integrator", "string", read_integrator),
    field<&ClothDesc::solver_options>("solver_options").with(options_of<cloth_solvers>),
    special("pins", "list of vertex numbers or names", read_pins),
    special("color", "color", read_color<ClothReading>),
    later<ClothReading>("tags", kWordsType),
};

}  // namespace

std::vector<OptionInfo> cloth_rows() { return describe_rows(kCloth); }

ObjectId world_cloth(WorldRecord& r, lua_State* L) {
  if (r.planar()) fail_here(L, "expected a world of dimension 3: cloth has no 2D section; take a net");
  ClothReading cloth = read_description(L, r, kCloth);
  cloth.pose = {cloth.position, cloth.rotation};
  const ObjectId id = r.world->need<Cloth>().add_cloth(cloth);
  if (cloth.painted) r.appearance.colors[id] = cloth.color;
  return id;
}

}  // namespace feder::lua
