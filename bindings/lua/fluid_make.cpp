// world:fluid{ ... }, and what it is fed and emptied by: fluid:fill{}, fluid:emitter{}, fluid:drain{}.
#include <cmath>

#include "fluid/solver.h"
#include "lua/box_option.h"
#include "lua/buffer.h"
#include "lua/fluid_part.h"
#include "lua/shapes.h"
#include "neighbors/neighbor_search.h"
#include "sph/kernel.h"

namespace feder::lua {
namespace {

struct FluidReading : Making<FluidDesc> {
  Real kinematic = 0;      // m^2/s
  Real transparency = -1;  // below 0: as its colour has it
};

void read_kinematic(Options& o, const OptionRow& row, FluidReading& d) {
  if (!o.real(row.name, d.kinematic, row.range)) return;
  if (o.has("viscosity"))
    o.raise("kinematic_viscosity", "expected viscosity (Pa s) or kinematic_viscosity (m^2/s), got both");
  d.viscosity = d.kinematic * d.density;
}

// The angle in the liquid of a drop on a wall, by the work of adhesion (Dupre 1869, Young 1805).
void read_contact_angle(Options& o, const OptionRow& row, FluidReading& d) {
  Real angle = 0;
  if (!o.real(row.name, angle, row.range)) return;
  if (o.has("adhesion")) o.raise(row.name, "expected adhesion (N/m) or contact_angle (degrees), got both");
  if (!(d.surface_tension > 0)) o.raise(row.name, "expected a surface_tension above 0 with it");
  d.adhesion = d.surface_tension * (1 + std::cos(angle * Real(3.14159265358979323846 / 180)));
}

struct KernelRoles {
  std::string density, pressure, viscosity;
};
constexpr Option<KernelRoles> kKernels[] = {
    field<&KernelRoles::density>("density").unset(),
    field<&KernelRoles::pressure>("pressure").unset(),
    field<&KernelRoles::viscosity>("viscosity").of(viscosity_names).unset(),
};

// kernels = { density =, pressure =, viscosity = }
void read_kernels(Options& o, const OptionRow& row, FluidReading& d) {
  if (!o.push_any(row.name)) return;
  lua_State* L = o.L();
  if (lua_type(L, -1) != LUA_TTABLE) o.wrong(row.name, "{ density =, pressure =, viscosity = }");
  if (o.has("kernel")) o.raise(row.name, "expected kernel or kernels, got both");
  KernelRoles roles;
  Options inner(L, -1, o.path(row.name));
  inner.read(kKernels, roles);
  lua_pop(L, 1);
  if (!roles.pressure.empty() || !roles.density.empty()) {
    const std::string& one = roles.density.empty() ? roles.pressure : roles.density;
    d.kernel = kernel_by_roles(one, roles.pressure.empty() ? one : roles.pressure);
  }
  if (!roles.viscosity.empty()) kernel_by_viscosity(d.viscosity_kernel = roles.viscosity);
}

// A word that the description keeps as it is; shown: what it is when nobody says is one of them.
constexpr const char kWallSlip[] = "none, free", kSurfaceModel[] = "cohesion, color_field",
                     kIntegrator[] = "leapfrog, symplectic_euler";

template <auto Field, const char* kChoices>
constexpr Option<FluidReading> word(const char* name, bool shown = true) {
  Option<FluidReading> option{
      {.name = name, .choices = kChoices}, "string", [](Options& o, const OptionRow& row, FluidReading& d) {
        int index = 0;
        if (o.choice(row.name, kChoices, index)) d.*Field = split_choices(kChoices)[static_cast<std::size_t>(index)];
      }};
  if (shown) option.fallback = [](const FluidReading& d) { return print_value(d.*Field); };
  return option;
}

constexpr Option<FluidReading> kFluid[] = {
    field<&FluidDesc::name>("name"),
    field<&FluidDesc::spacing>("spacing", "m", kPositive),
    field<&FluidDesc::density>("density", "kg/m3", kPositive),
    field<&FluidDesc::viscosity>("viscosity", "Pa s", kNotNegative),
    {{.name = "kinematic_viscosity", .unit = "m2/s", .range = kNotNegative}, "number", read_kinematic},
    word<&FluidDesc::wall_slip, kWallSlip>("wall_slip"),
    field<&FluidDesc::surface_tension>("surface_tension", "N/m", kNotNegative),
    word<&FluidDesc::surface_model, kSurfaceModel>("surface_model", false),
    field<&FluidDesc::adhesion>("adhesion", "N/m", kNotNegative),
    {{.name = "contact_angle", .unit = "degrees", .range = {0, 180}}, "number", read_contact_angle},
    field<&FluidDesc::friction>("friction", "", kNotNegative),
    field<&FluidDesc::vorticity>("vorticity", "1/s", kNotNegative),
    field<&FluidDesc::solver>("solver").of(names_of<fluid_solvers>),
    field<&FluidDesc::kernel>("kernel").of(names_of<kernels>).unset(),
    {{.name = "kernels"}, "table", read_kernels, nullptr, rows_of<kKernels>},
    field<&FluidDesc::neighbors>("neighbors").of(names_of<neighbor_searches>),
    field<&FluidDesc::support>("support", "", {1.2, 4}).unset(),
    field<&FluidDesc::stiffness>("stiffness", "Pa", kNotNegative),
    field<&FluidDesc::compression>("compression", "", {0, 0.5, true}).unset(),
    field<&FluidDesc::artificial_viscosity>("artificial_viscosity", "", {0, 10}),
    word<&FluidDesc::integrator, kIntegrator>("integrator"),
    field<&FluidDesc::gravity_scale>("gravity_scale", "", kGravityScale),
    field<&FluidDesc::iterations>("iterations", "", {1, 1000}),
    field<&FluidDesc::tolerance>("tolerance", "%", {1e-6, 100}),
    field<&FluidDesc::negative_pressure>("negative_pressure", "atm", {0, 1}),
    field<&FluidDesc::max_substeps>("max_substeps", "", {1, 100000}),
    field<&FluidDesc::max_particles>("max_particles", "", {1, 134217728}),
    field<&FluidDesc::kill_height>("kill_height", "m").unset(),
    field<&FluidDesc::group>("group", "", kBits),
    field<&FluidDesc::mask>("mask", "", kBits),
    special("color", "color", read_color<FluidReading>),
    field<&FluidReading::transparency>("transparency", "", {0, 1}).unset(),
    later<FluidReading>("tags", kWordsType),
};

// What a fluid is filled into, or drained from.
struct Volume {
  WorldRecord* record = nullptr;
  ObjectId body;  // that a drain rides on
  std::string name;
  TagMask tags = 0;
  std::vector<Vec3> points;
  ShapePtr shape;
  Pose pose;
  Vec3 velocity = Vec3::Zero();
};

// box = {min, max}, or shape = with position and rotation; in 2D the shape's section.
void read_volume(Options& o, const OptionRow&, Volume& v) {
  if (o.given("points")) return;
  box_or_shape(o, v.shape, v.pose.position, v.pose.rotation);
  if (o.planar() && !v.shape->planar()) v.shape = v.shape->section();
}

void read_points(Options& o, const OptionRow&, Volume& v) {
  if (!o.has("points")) return;
  if (has_volume(o)) o.raise("points", "expected points or a volume, got both");
  points_option(o, "points", v.points);
}

constexpr Option<Volume> kFill[] = {
    field<&Volume::velocity>("velocity", "m/s"),
    special("points", "list of vectors or buffer", read_points, "m"),
    box_row(read_volume),
    later<Volume>("shape", "shape"),
    later<Volume>("position", "vector", "m"),
    later<Volume>("rotation", "rotation"),
};

// body = b, that a source rides on.
template <class T>
void read_carrier(Options& o, const OptionRow& row, T& made) {
  if (!o.push_any(row.name)) return;
  made.body = check_object(o.L(), -1, *made.record, o.path(row.name), "body");
  lua_pop(o.L(), 1);
}

struct EmitterReading : EmitterDesc {
  WorldRecord* record = nullptr;
};

void read_jet(Options& o, const OptionRow& row, EmitterReading& made) { o.unit(row.name, made.direction); }

constexpr Option<Volume> kDrain[] = {
    special("body", "body", read_carrier<Volume>),
    field<&Volume::name>("name"),
    box_row(read_volume),
    later<Volume>("shape", "shape"),
    later<Volume>("position", "vector", "m"),
    later<Volume>("rotation", "rotation"),
    later<Volume>("tags", kWordsType),
};

void read_flux_box(Options& o, const OptionRow& row, FluidBox& box) {
  if (!box_corners(o, box.lo, box.hi)) o.raise(row.name, "expected {min, max}, got nothing");
}

constexpr Option<FluidBox> kFlux[] = {box_row(read_flux_box)};

constexpr Option<EmitterReading> kEmitter[] = {
    field<&EmitterDesc::name>("name"),
    special("body", "body", read_carrier<EmitterReading>),
    field<&EmitterDesc::position>("position", "m"),
    special("direction", "direction", read_jet),
    field<&EmitterDesc::speed>("speed", "m/s", kPositive),
    field<&EmitterDesc::radius>("radius", "m", kNotNegative),
    field<&EmitterDesc::rate>("rate", "1/s", kPositive).unset(),
    field<&EmitterDesc::limit>("limit", "", {1, 1099511627776.0}).unset(),
    later<EmitterReading>("tags", kWordsType),
};

struct Interface {
  Real tension = 0;
};

constexpr Option<Interface> kInterface[] = {field<&Interface::tension>("tension", "N/m", kNotNegative).unset()};

}  // namespace

std::vector<OptionInfo> interface_rows() { return describe_rows(kInterface); }
std::vector<OptionInfo> fluid_rows() { return describe_rows(kFluid); }
std::vector<OptionInfo> fill_rows() { return describe_rows(kFill); }
std::vector<OptionInfo> flux_rows() { return describe_rows(kFlux); }
std::vector<OptionInfo> emitter_rows() { return describe_rows(kEmitter); }
std::vector<OptionInfo> drain_rows() { return describe_rows(kDrain); }

ObjectId world_fluid(WorldRecord& r, lua_State* L) {
  const FluidReading fluid = read_description(L, r, kFluid);
  const ObjectId id = system_of<Fluid>(r).add_fluid(fluid);
  if (fluid.painted) r.appearance.colors[id] = fluid.color;
  if (fluid.transparency >= 0) r.appearance.transparencies[id] = static_cast<float>(fluid.transparency);
  return id;
}

void world_interface(WorldRecord& r, lua_State* L) {
  Options o(L, 2, function_name(L), r.planar());
  o.skip_entries(2);
  Interface made;
  o.read(kInterface, made);
  if (!o.given("tension")) o.raise("tension", "expected a number, 0 or more, got nothing");
  ObjectId fluids[2];
  for (int k = 0; k < 2; ++k) {
    lua_rawgeti(L, o.index(), k + 1);
    fluids[k] = check_object(L, -1, r, o.owner() + "[" + std::to_string(k + 1) + "]", "fluid");
    lua_pop(L, 1);
  }
  system_of<Fluid>(r).set_interface(fluids[0], fluids[1], made.tension);
}

std::size_t fluid_fill(const Object<Fluid>& f, lua_State* L) {
  Options o(L, 2, function_name(L), f.record.planar());
  Volume v;
  o.read(kFill, v);
  if (!v.shape) {
    charge(L, v.points.size());
    return f.system.fill(f.id, v.points, v.velocity);
  }
  const std::size_t made = f.system.fill(f.id, *v.shape, v.pose, v.velocity);
  charge(L, made);
  return made;
}

FluidBox fluid_box(const Object<Fluid>& f, lua_State* L) {
  Options o(L, 2, function_name(L), f.record.planar());
  FluidBox box;
  o.read(kFlux, box);
  return box;
}

ObjectId fluid_emitter(const Object<Fluid>& f, lua_State* L) {
  const EmitterReading emitter = read_description(L, f.record, kEmitter);
  return f.system.add_emitter(f.id, emitter);
}

ObjectId fluid_drain(const Object<Fluid>& f, lua_State* L) {
  Volume v = read_description(L, f.record, kDrain);
  return f.system.add_drain(f.id, v.name, v.tags, std::move(v.shape), v.pose, v.body);
}

}  // namespace feder::lua
