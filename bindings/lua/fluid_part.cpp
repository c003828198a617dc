// Fluids in Lua: methods of fluids, emitters and drains, and the part. Particles are numbered in the order they were
// made, from 1.
#include "lua/fluid_part.h"

#include <algorithm>

#include "fluid/liquid_surface.h"
#include "lua/buffer.h"
#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

using Liquid = Object<Fluid>;

// Particles see their neighbours and walls as they are now.
Fluid& asked(const Liquid& f) { return *f.world.query<Fluid>(); }

// fn(x, y, z, i) -> vx, vy, vz; or a buffer of three numbers per particle.
void fluid_set_velocities(const Liquid& f, lua_State* L) {
  const std::size_t count = f.system.particle_count(f.id);
  std::vector<Vec3> v(count);
  const auto numbers = test_buffer(L, 2);
  if (numbers.data()) {
    if (numbers.size() < 3 * count)
      fail_here(L, "expected a buffer of at least " + std::to_string(3 * count) + " numbers, got one of " +
                       std::to_string(numbers.size()));
    for (std::size_t i = 0; i < count; ++i)
      for (int k = 0; k < 3; ++k) v[i][k] = static_cast<Real>(numbers[3 * i + static_cast<std::size_t>(k)]);
  } else if (lua_type(L, 2) == LUA_TFUNCTION) {
    std::vector<Vec3> x;
    f.system.positions(f.id, x);
    for (std::size_t i = 0; i < count; ++i) {
      lua_pushvalue(L, 2);
      push(L, x[i], i + 1);
      lua_call(L, 4, 3);
      const std::string what = std::string(function_name(L)) + ": velocity of particle " + std::to_string(i + 1);
      for (int k = 0; k < 3; ++k)
        v[i][k] = lua_isnil(L, k - 3) ? Real(0) : static_cast<Real>(check_number(L, k - 3, what));
      lua_pop(L, 3);
    }
    if (f.system.particle_count(f.id) != count) fail_here(L, "the function must not change the fluid");
  } else {
    fail_here(L, "expected a function (x, y, z, i) -> vx, vy, vz or a buffer, got " + describe(L, 2));
  }
  if (f.record.planar())
    for (Vec3& u : v) u[2] = 0;
  f.system.set_velocities(f.id, v);
}

std::array<double, 2> fluid_density_error(const Liquid& f) {
  double mean = 0, largest = 0;
  asked(f).density_error(f.id, mean, largest);
  return {mean, largest};
}

double fluid_pressure_at(const Liquid& f, const Vec3& point) { return asked(f).pressure_at(f.id, point); }

void set_vector(lua_State* L, const char* key, const auto& v) {
  push_list(L, std::array{v[0], v[1], v[2]}, [&](auto x) { push(L, x); });
  lua_setfield(L, -2, key);
}

int fluid_sample(lua_State* L) {
  const Liquid f(L);
  const FluidSample s = asked(f).sample(f.id, vector_argument(L, 2, f.record.planar()));
  lua_newtable(L);
  set_field(L, "density", s.density), set_field(L, "pressure", s.pressure);
  set_vector(L, "velocity", s.velocity);
  set_vector(L, "density_gradient", s.density_gradient), set_vector(L, "pressure_gradient", s.pressure_gradient);
  push_list(L, std::array{0, 1, 2}, [&](int row) {
    push_list(L, std::array{0, 1, 2}, [&](int column) { push(L, s.velocity_gradient(row, column)); });
  });
  lua_setfield(L, -2, "velocity_gradient");
  return 1;
}

int fluid_flux(lua_State* L) {
  const Liquid f(L);
  const FluidBox box = fluid_box(f, L);
  const FluidFlux flux = f.system.flux(f.id, box.lo, box.hi);
  const double mass = flux.mass > 0 ? flux.mass : 1;  // without any the momentum is zero
  lua_newtable(L);
  set_field(L, "mass", flux.mass);
  set_vector(L, "momentum", flux.momentum);
  set_vector(L, "velocity", std::array{flux.momentum[0] / mass, flux.momentum[1] / mass, flux.momentum[2] / mass});
  set_field(L, "x", flux.rate[0]), set_field(L, "y", flux.rate[1]), set_field(L, "z", flux.rate[2]);
  return 1;
}

double fluid_clumping(const Liquid& f) { return f.system.clumping(f.id); }

int fluid_height_at(lua_State* L) {
  const Liquid f(L);
  const Real x = static_cast<Real>(check_number(L, 2, std::string(function_name(L)) + ": x"));
  const Real z =
      lua_isnoneornil(L, 3) ? Real(0) : static_cast<Real>(check_number(L, 3, std::string(function_name(L)) + ": z"));
  Real y = 0;
  return asked(f).height_at(f.id, x, z, y) ? push(L, y) : push(L, nullptr);
}

// Nine numbers a triangle: its corners, counterclockwise as seen from outside.
int fluid_surface(lua_State* L) {
  const Liquid f(L);
  std::vector<Vec3> x, corners;
  f.system.positions(f.id, x);
  IsoMesh mesh;
  LiquidSurface().build(x, f.system.desc(f.id).spacing, false, mesh);
  for (const std::uint32_t v : mesh.triangles) corners.push_back(mesh.vertices[v]);
  charge(L, x.size());
  push_vectors(L, corners);
  push(L, corners.size() / 3);
  return 2;
}

std::array<double, 2> fluid_mass(const Liquid& f) {
  const double each = static_cast<double>(f.system.particle_mass(f.id));
  return {each * static_cast<double>(f.system.particle_count(f.id)), each};
}

// Particles at the surface lack neighbours, not density.
double fluid_volume(const Liquid& f) {
  std::vector<Real> ratios;
  asked(f).densities(f.id, ratios);
  double sum = 0;
  for (const Real r : ratios) sum += 1 / std::max(1.0, static_cast<double>(r));
  return sum * static_cast<double>(f.system.particle_mass(f.id) / f.system.desc(f.id).density);
}

Real fluid_spacing(const Liquid& f) { return f.system.desc(f.id).spacing; }

template <bool kRunning>
void set_running(const Liquid& f) {
  f.system.set_running(f.id, kRunning);
}

bool fluid_awake(const Liquid& f) { return !f.system.asleep(f.id); }
void fluid_wake(const Liquid& f) { f.system.wake(f.id); }

const Method kFluidMethods[] = {
    {"fill", method<fluid_fill>,
     "fluid:fill{ box = {min, max} | shape =, position =, rotation = | points =, velocity = } -> count",
     "particles on a lattice, or at the points", fill_rows},
    {"emitter", method<fluid_emitter>,
     "fluid:emitter{ body =, position =, direction =, speed =, radius =, rate =, limit = } -> emitter",
     "rate in particles per second (a full jet when left out), limit in particles; on a body: in its frame",
     emitter_rows},
    {"drain", method<fluid_drain>, "fluid:drain{ body =, box = {min, max} | shape =, position =, rotation = } -> drain",
     "takes the particles in it away after each step; on a body: in its frame", drain_rows},
    {"awake", method<fluid_awake>, "fluid:awake() -> boolean", "does it move?"},
    {"wake", method<fluid_wake>, "fluid:wake() -> self", "lets it move again"},
    {"count", method<&Fluid::particle_count>, "fluid:count() -> integer", "particles"},
    {"positions", guard<list_vectors<Fluid, &Fluid::positions>>, "fluid:positions([buffer]) -> buffer",
     "x, y, z of all, in the order they were made"},
    {"velocities", guard<list_vectors<Fluid, &Fluid::velocities>>, "fluid:velocities([buffer]) -> buffer",
     "likewise, m/s"},
    {"set_velocities", method<fluid_set_velocities>, "fluid:set_velocities(fn | buffer) -> self",
     "fn(x, y, z, i) -> vx, vy, vz"},
    {"density_error", method<fluid_density_error>, "fluid:density_error() -> mean, largest",
     "excess over the density at rest, as a share of it"},
    {"pressure_at", method<fluid_pressure_at>, "fluid:pressure_at(x, y, z) -> number",
     "mean of the particles near, Pa"},
    {"clumping", method<fluid_clumping>, "fluid:clumping() -> number",
     "share of the pairs of neighbours that are closer than half a spacing"},
    {"sample", guard<fluid_sample>, "fluid:sample(x, y, z) -> table",
     "density = sum of m W over the share of the kernel W that walls leave free; velocity, pressure = sum of A W over "
     "sum of W (Shepard 1968); density_gradient, velocity_gradient (rows: components), pressure_gradient, exact for "
     "linear fields (Randles and Libersky 1996); zeros where no particle is near"},
    {"flux", guard<fluid_flux>, "fluid:flux{ box = {min, max} } -> table",
     "mass (kg), momentum and mean velocity of what is in the box; x, y, z: kg/s that flow through it along the axis, "
     "momentum over extent",
     flux_rows},
    {"height_at", guard<fluid_height_at>, "fluid:height_at(x, z) -> y", "of the free surface, or nil"},
    {"surface", guard<fluid_surface>, "fluid:surface([buffer]) -> buffer, count",
     "of the liquid as triangles: nine numbers each, counterclockwise from outside; and how many"},
    {"mass", method<fluid_mass>, "fluid:mass() -> number, number", "of all, and of one particle, kg"},
    {"volume", method<fluid_volume>, "fluid:volume() -> number",
     "mass over density, which counts as that at rest where it is less, m3"},
    {"spacing", method<fluid_spacing>, "fluid:spacing() -> number", "m"},
};

const Method kEmitterMethods[] = {
    {"start", method<set_running<true>>, "emitter:start() -> self", "goes on where it stopped; not beyond its limit"},
    {"stop", method<set_running<false>>, "emitter:stop() -> self", "holds it"},
    {"running", method<&Fluid::running>, "emitter:running() -> boolean", "does it emit?"},
    {"count", method<&Fluid::passed>, "emitter:count() -> integer", "particles emitted so far"},
    {"fluid", method<&Fluid::fluid_of>, "emitter:fluid() -> fluid", "what it feeds"},
    {"aim", method<&Fluid::aim>, "emitter:aim(x, y, z, dx, dy, dz) -> self",
     "new place and direction of the nozzle, in the frame of its body"},
};

const Method kDrainMethods[] = {
    {"count", method<&Fluid::passed>, "drain:count() -> integer", "particles taken so far"},
    {"fluid", method<&Fluid::fluid_of>, "drain:fluid() -> fluid", "what it empties"},
};

// A function may destroy or fill what it is asked about: particles that are new then feel nothing yet.
void fluid_forces(ForceRun& run) {
  World& world = *run.record().world;
  Fluid* system = world.find<Fluid>();
  if (!system) return;
  system->clear_script_forces();
  const Objects& objects = world.objects();
  std::vector<ObjectId> all;
  objects.for_each(kFluidKind, [&](ObjectId id) { all.push_back(id); });
  std::vector<Vec3> x, v, force;
  for (const ObjectId id : all) {
    if (!objects.alive(id) || !run.any(id)) continue;
    system->positions(id, x), system->velocities(id, v);
    const Real mass = system->particle_mass(id);
    force.clear();
    for (std::size_t i = 0; i < x.size() && objects.alive(id); ++i)
      force.push_back(run.sum(id, static_cast<std::uint32_t>(i), x[i], v[i], mass));
    if (!objects.alive(id)) continue;
    force.resize(system->particle_count(id), Vec3::Zero());
    system->set_script_forces(id, force);
  }
}

std::vector<ObjectId> destroy_fluid(WorldRecord& record, ObjectId id, const std::string& where) {
  Fluid& fluid = record.world->need<Fluid>();
  std::vector<ObjectId> sources;  // go with it
  for (const ObjectKind kind : {kEmitterKind, kDrainKind})
    record.world->objects().for_each(kind, [&](ObjectId source) {
      if (fluid.fluid_of(source) == id) sources.push_back(source);
    });
  fluid.destroy_fluid(id, where);
  return sources;
}

// A fluid with its fill, emitters and drains: each a table or a list of tables of the method of that name.
void make_fluid(lua_State* L, int world) {
  const int options = lua_gettop(L);
  lua_newtable(L);  // the options without them
  copy_locations(L, options, -1);
  copy_fields(L, options);
  for (const char* part : {"fill", "emitter", "drain"}) set_field(L, part, nullptr);
  call_maker(L, world, "fluid", options + 1, 1);
  const int fluid = lua_gettop(L);
  for (const char* part : {"fill", "emitter", "drain"}) {
    const auto make = [&](int entry) {
      if (lua_type(L, entry) == LUA_TTABLE) make_shape_field(L, entry), resolve_name(L, world, entry, "body");
      call_maker(L, fluid, part, entry, 0);
    };
    if (lua_getfield(L, options, part) == LUA_TTABLE && lua_rawlen(L, -1) > 0)
      each_entry(L, -1, [&](lua_Integer) { make(lua_gettop(L)); });
    else if (lua_type(L, -1) == LUA_TTABLE)
      make(lua_gettop(L));
    lua_settop(L, fluid);
  }
  lua_settop(L, options - 1);
}

const Method kWorld[] = {
    {"fluid", method<world_fluid>, "world:fluid{ spacing =, density =, viscosity =, solver =, ... } -> fluid",
     "particles of a liquid", fluid_rows},
    {"interface", method<world_interface>, "world:interface{ a, b, tension = }",
     "tension between two fluids that may touch, N/m; the difference of their tensions when nobody says",
     interface_rows},
};
std::vector<OptionInfo> source_rows() {
  const auto row = [](const char* name, std::vector<OptionInfo> inner) {
    return OptionInfo{.row = {.name = name},
                      .type = "table or list of tables",
                      .fallback = "",
                      .choices = "",
                      .inner = std::move(inner)};
  };
  return {row("fill", fill_rows()), row("emitter", emitter_rows()), row("drain", drain_rows())};
}

const YamlList kYaml[] = {{"fluids", make_fluid, "fluid", source_rows}};

}  // namespace

const Part& fluid_part() {
  static const ObjectClass classes[] = {
      {.name = "fluid",
       .methods = kFluidMethods,
       .destroy = &destroy_fluid,
       .contact_field = "count",
       .takes_forces = true},
      {.name = "emitter", .methods = kEmitterMethods, .destroy = destroy_alone<&Fluid::destroy_emitter>},
      {.name = "drain", .methods = kDrainMethods, .destroy = destroy_alone<&Fluid::destroy_drain>}};
  static const Part part = {.name = "fluid",
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &fluid_forces,
                            .clear_forces = &clear_script_forces<Fluid>};
  return part;
}

}  // namespace feder::lua
