// The methods of fluids, emitters and drains. Particles are numbered in the order they were made, from 1.

#include "lua/buffer.h"
#include "lua/fluid_part.h"

namespace feder::lua {
namespace {

struct Of {
  Self self;
  Fluid& fluid;
};

Of of(lua_State* L) {
  Self self = check_self(L);
  return {self, fluids(self.record)};
}

int fluid_count(lua_State* L) {
  const Of f = of(L);
  lua_pushinteger(L, static_cast<lua_Integer>(f.fluid.particle_count(f.self.id)));
  return 1;
}

int fluid_positions(lua_State* L) {
  const Of f = of(L);
  std::vector<Vec3> x;
  f.fluid.positions(f.self.id, x);
  return push_vectors(L, x);
}

int fluid_velocities(lua_State* L) {
  const Of f = of(L);
  std::vector<Vec3> v;
  f.fluid.velocities(f.self.id, v);
  return push_vectors(L, v);
}

// fn(x, y, z, i) -> vx, vy, vz; or a buffer of three numbers per particle.
int fluid_set_velocities(lua_State* L) {
  const Of f = of(L);
  const std::size_t count = f.fluid.particle_count(f.self.id);
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
    f.fluid.positions(f.self.id, x);
    for (std::size_t i = 0; i < count; ++i) {
      lua_pushvalue(L, 2);
      for (int k = 0; k < 3; ++k) lua_pushnumber(L, x[i][k]);
      lua_pushinteger(L, static_cast<lua_Integer>(i) + 1);
      lua_call(L, 4, 3);
      const std::string what = std::string(function_name(L)) + ": velocity of particle " + std::to_string(i + 1);
      for (int k = 0; k < 3; ++k)
        v[i][k] = lua_isnil(L, k - 3) ? Real(0) : static_cast<Real>(check_number(L, k - 3, what));
      lua_pop(L, 3);
    }
    if (f.fluid.particle_count(f.self.id) != count) fail_here(L, "the function must not change the fluid");
  } else {
    fail_here(L, "expected a function (x, y, z, i) -> vx, vy, vz or a buffer, got " + describe(L, 2));
  }
  if (f.self.record.planar())
    for (Vec3& u : v) u[2] = 0;
  f.fluid.set_velocities(f.self.id, v);
  return return_self(L);
}

int fluid_density_error(lua_State* L) {
  const Of f = of(L);
  double mean = 0, most = 0;
  f.self.record.world->query<Fluid>()->density_error(f.self.id, mean, most);
  lua_pushnumber(L, mean), lua_pushnumber(L, most);
  return 2;
}

int fluid_pressure_at(lua_State* L) {
  const Of f = of(L);
  lua_pushnumber(
      L, f.self.record.world->query<Fluid>()->pressure_at(f.self.id, vector_argument(L, 2, f.self.record.planar())));
  return 1;
}

int fluid_height_at(lua_State* L) {
  const Of f = of(L);
  const Real x = static_cast<Real>(check_number(L, 2, std::string(function_name(L)) + ": x"));
  const Real z =
      lua_isnoneornil(L, 3) ? Real(0) : static_cast<Real>(check_number(L, 3, std::string(function_name(L)) + ": z"));
  Real y = 0;
  if (f.self.record.world->query<Fluid>()->height_at(f.self.id, x, z, y))
    lua_pushnumber(L, y);
  else
    lua_pushnil(L);
  return 1;
}

int fluid_surface(lua_State* L) {
  const Of f = of(L);
  std::vector<Vec3> x, n;
  f.self.record.world->query<Fluid>()->surface(f.self.id, x, n);
  push_vectors(L, x);
  lua_pushinteger(L, static_cast<lua_Integer>(x.size()));
  return 2;
}

int fluid_mass(lua_State* L) {
  const Of f = of(L);
  const double each = static_cast<double>(f.fluid.particle_mass(f.self.id));
  lua_pushnumber(L, each * static_cast<double>(f.fluid.particle_count(f.self.id))), lua_pushnumber(L, each);
  return 2;
}

int fluid_spacing(lua_State* L) {
  const Of f = of(L);
  lua_pushnumber(L, f.fluid.desc(f.self.id).spacing);
  return 1;
}

int emitter_start(lua_State* L) {
  const Of f = of(L);
  f.fluid.set_running(f.self.id, true);
  return return_self(L);
}
int emitter_stop(lua_State* L) {
  const Of f = of(L);
  f.fluid.set_running(f.self.id, false);
  return return_self(L);
}
int emitter_running(lua_State* L) {
  const Of f = of(L);
  lua_pushboolean(L, f.fluid.running(f.self.id));
  return 1;
}
int source_count(lua_State* L) {
  const Of f = of(L);
  lua_pushinteger(L, static_cast<lua_Integer>(f.fluid.passed(f.self.id)));
  return 1;
}
int source_fluid(lua_State* L) {
  const Of f = of(L);
  push_handle(L, f.self.record, f.fluid.fluid_of(f.self.id));
  return 1;
}
int emitter_aim(lua_State* L) {
  const Of f = of(L);
  int next = 0;
  const Vec3 position = vector_argument(L, 2, f.self.record.planar(), &next);
  f.fluid.aim(f.self.id, position, vector_argument(L, next, f.self.record.planar()));
  return return_self(L);
}

const Method kFluidMethods[] = {
    {"fill", guard<fluid_fill>,
     "fluid:fill{ box = {min, max} | shape =, position =, rotation = | points =, velocity = } -> count",
     "particles on a lattice, or at the points", fill_rows},
    {"emitter", guard<fluid_emitter>,
     "fluid:emitter{ position =, direction =, speed =, radius =, rate =, limit = } -> emitter",
     "rate in particles per second (a full jet when left out), limit in particles", emitter_rows},
    {"drain", guard<fluid_drain>, "fluid:drain{ box = {min, max} | shape =, position =, rotation = } -> drain",
     "takes the particles in it away after each step", drain_rows},
    {"count", guard<fluid_count>, "fluid:count() -> integer", "particles"},
    {"positions", guard<fluid_positions>, "fluid:positions([buffer]) -> buffer",
     "x, y, z of all, in the order they were made"},
    {"velocities", guard<fluid_velocities>, "fluid:velocities([buffer]) -> buffer", "likewise, m/s"},
    {"set_velocities", guard<fluid_set_velocities>, "fluid:set_velocities(fn | buffer) -> self",
     "fn(x, y, z, i) -> vx, vy, vz"},
    {"density_error", guard<fluid_density_error>, "fluid:density_error() -> mean, largest",
     "excess over the density at rest, as a share of it"},
    {"pressure_at", guard<fluid_pressure_at>, "fluid:pressure_at(x, y, z) -> number", "mean of the particles near, Pa"},
    {"height_at", guard<fluid_height_at>, "fluid:height_at(x, z) -> y", "of the free surface, or nil"},
    {"surface", guard<fluid_surface>, "fluid:surface([buffer]) -> buffer, count", "particles at the surface"},
    {"mass", guard<fluid_mass>, "fluid:mass() -> number, number", "of all, and of one particle, kg"},
    {"spacing", guard<fluid_spacing>, "fluid:spacing() -> number", "m"},
};

const Method kEmitterMethods[] = {
    {"start", guard<emitter_start>, "emitter:start() -> self", "goes on where it stopped; not beyond its limit"},
    {"stop", guard<emitter_stop>, "emitter:stop() -> self", "holds it"},
    {"running", guard<emitter_running>, "emitter:running() -> boolean", "does it emit?"},
    {"count", guard<source_count>, "emitter:count() -> integer", "particles emitted so far"},
    {"fluid", guard<source_fluid>, "emitter:fluid() -> fluid", "what it feeds"},
    {"aim", guard<emitter_aim>, "emitter:aim(x, y, z, dx, dy, dz) -> self", "new place and direction of the nozzle"},
};

const Method kDrainMethods[] = {
    {"count", guard<source_count>, "drain:count() -> integer", "particles taken so far"},
    {"fluid", guard<source_fluid>, "drain:fluid() -> fluid", "what it empties"},
};

}  // namespace

std::span<const Method> fluid_methods() { return kFluidMethods; }
std::span<const Method> emitter_methods() { return kEmitterMethods; }
std::span<const Method> drain_methods() { return kDrainMethods; }

}  // namespace feder::lua
