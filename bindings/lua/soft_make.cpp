// world:soft{ ... }: tetrahedra, or a shape to be filled with them; material, pins, and what it does with others.

#include "bounds/box_search.h"
#include "lua/buffer.h"
#include "lua/plastic.h"
#include "lua/shapes.h"
#include "lua/soft_part.h"
#include "soft/solver.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxTetrahedra = 10000000;

struct SoftReading : Making<SoftDesc> {
  Vec3 position = Vec3::Zero();
  Quat rotation;
};

// A list of {i, j, k, l}, or a buffer of 4 n point numbers.
void read_tetrahedra(Options& o, SoftDesc& desc) {
  lua_State* L = o.L();
  if (!o.push_any("tetrahedra")) o.wrong("tetrahedra", "a list of {i, j, k, l} or a buffer");
  const std::size_t count = desc.points.size();
  if (const auto numbers = test_buffer(L, -1); numbers.data()) {
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double x = numbers[i];
      if (!(x >= 1 && x <= static_cast<double>(count)) || x != static_cast<double>(static_cast<std::uint32_t>(x)))
        o.raise("tetrahedra", "expected whole numbers from 1 to " + std::to_string(count) + ", got " + print_number(x) +
                                  " at place " + std::to_string(i + 1));
      desc.tetrahedra.push_back(static_cast<std::uint32_t>(x) - 1);
    }
    lua_pop(L, 1);
    return;
  }
  if (lua_type(L, -1) != LUA_TTABLE) o.wrong("tetrahedra", "a list of {i, j, k, l} or a buffer");
  const auto size = lua_rawlen(L, -1);
  if (size > kMaxTetrahedra) o.raise("tetrahedra", "expected at most " + std::to_string(kMaxTetrahedra));
  charge(L, size);
  each_entry(L, -1, [&](lua_Integer t) {
    const std::string what = o.path("tetrahedra") + "[" + std::to_string(t) + "]";
    check_indices(L, -1, what, "four point numbers", 4, 4, count, desc.tetrahedra);
  });
  lua_pop(L, 1);
}

void read_soft_points(Options& o, const OptionRow&, SoftReading& desc) {
  if (o.has("points")) {
    for (const char* key : {"shape", "resolution"})
      if (o.has(key)) o.raise(key, "fills a shape; points and tetrahedra say what the body is made of");
    points_option(o, "points", desc.points);
    read_tetrahedra(o, desc);
    return;
  }
  if (o.has("tetrahedra")) o.raise("tetrahedra", "expected points too");
  if (!o.has("shape")) o.raise("shape", "expected a shape, or points and tetrahedra, got nil");
}

void read_soft_shape(Options& o, const OptionRow&, SoftReading& desc) { shape_option(o, "shape", desc.shape); }

void read_soft_pins(Options& o, const OptionRow&, SoftReading& desc) {
  if (!o.push_any("pins")) return;
  lua_State* L = o.L();
  constexpr std::size_t kAny = 0xfffffff0u;  // how many a shape gets is known later
  const std::size_t count = desc.points.empty() ? kAny : desc.points.size();
  if (lua_type(L, -1) != LUA_TTABLE) o.wrong("pins", "a list of point numbers");
  each_entry(L, -1, [&](lua_Integer k) {
    desc.pins.push_back(check_index(L, -1, o.path("pins") + "[" + std::to_string(k) + "]", count));
  });
  lua_pop(L, 1);
}

void read_soft_solver(Options& o, const OptionRow&, SoftReading& desc) {
  if (o.text("solver", desc.solver)) find_variant(soft_solvers(), desc.solver, "solver of soft bodies");
}

std::string show_soft_solver(const SoftReading& desc) { return print_value(desc.solver); }

void read_soft_self(Options& o, const OptionRow&, SoftReading& desc) {
  if (o.text("self", desc.self)) find_variant(box_searches(), desc.self, "search of self-contact");
}

void read_elasticity(Options& o, const OptionRow&, SoftReading& desc) {
  if (o.text("elasticity", desc.elasticity)) find_variant(elastic_laws(), desc.elasticity, "law of elasticity");
}

std::string show_elasticity(const SoftReading& desc) { return print_value(desc.elasticity); }

constexpr Option<SoftReading> kSoft[] = {
    field<&SoftDesc::name>("name"),
    special("points", "list of vectors or buffer", read_soft_points, "m"),
    later<SoftReading>("tetrahedra", "list of {i, j, k, l} or buffer"),
    special("shape", "shape", read_soft_shape),
    field<&SoftDesc::resolution>("resolution", "", {1, 10000000}),
    field<&SoftReading::position>("position", "m"),
    field<&SoftReading::rotation>("rotation"),
    field<&SoftDesc::velocity>("velocity", "m/s"),
    field<&SoftDesc::angular_velocity>("angular_velocity", "rad/s"),
    field<&SoftDesc::density>("density", "kg/m3", kPositive),
    field<&SoftDesc::young>("young", "Pa", kPositive),
    field<&SoftDesc::poisson>("poisson", "", {-0.99, 0.499}),
    field<&SoftDesc::damping>("damping", "s", kNotNegative),
    field<&SoftDesc::thickness>("thickness", "m", kPositive).unset(),
    field<&SoftDesc::friction>("friction", "", kNotNegative),
    field<&SoftDesc::self_collision>("self_collision"),
    {{.name = "self"}, "string", read_soft_self, nullptr, nullptr, names_of<box_searches>},
    field<&SoftDesc::gravity_scale>("gravity_scale", "", kGravityScale),
    field<&SoftDesc::group>("group", "", kBits),
    field<&SoftDesc::mask>("mask", "", kBits),
    field<&SoftDesc::substeps>("substeps", "", {1, 10000}).unset(),
    field<&SoftDesc::max_substeps>("max_substeps", "", {0, 10000}),
    {{.name = "solver"}, "string", read_soft_solver, show_soft_solver, nullptr, names_of<soft_solvers>},
    field<&SoftDesc::solver_options>("solver_options").with(options_of<soft_solvers>),
    {{.name = "elasticity"}, "string", read_elasticity, show_elasticity, nullptr, names_of<elastic_laws>},
    special("pins", "list of point numbers", read_soft_pins),
    {{.name = "plastic"}, "table", read_plastic<SoftReading>, nullptr, rows_of<kPlastic<SoftReading>>},
    field<&SoftDesc::fracture_stress>("fracture_stress", "Pa", kPositive).unset(),
    special("color", "color", read_color<SoftReading>),
    later<SoftReading>("tags", kWordsType),
};

}  // namespace

std::vector<OptionInfo> soft_rows() { return describe_rows(kSoft); }

ObjectId world_soft(WorldRecord& r, lua_State* L) {
  if (r.planar()) fail_here(L, "expected a world of dimension 3: soft bodies have no 2D section; take a net");
  SoftReading soft = read_description(L, r, kSoft);
  soft.pose = {soft.position, soft.rotation};
  const ObjectId id = r.world->need<Soft>().add_soft(soft);
  if (soft.painted) r.appearance.colors[id] = soft.color;
  return id;
}

}  // namespace feder::lua
