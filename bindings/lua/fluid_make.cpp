// world:fluid{ ... }, and what it is fed and emptied by: fluid:fill{}, fluid:emitter{}, fluid:drain{}.
#include "lua/buffer.h"
#include "lua/fluid_part.h"
#include "lua/shapes.h"

namespace feder::lua {
namespace {

// box = {min, max}, or shape = with position and rotation; in 2D the shape's section.
void shape_and_pose(Options& o, ShapePtr& shape, Pose& pose) {
  const bool has_box = box_option(o, shape, pose.position);
  if (!has_box && !shape_option(o, "shape", shape))
    o.raise(nullptr, "expected box = {min, max} or shape =, got neither");
  if (has_box && (o.has("shape") || o.has("position"))) o.raise("box", "expected box or shape and position, got both");
  o.vector("position", pose.position);
  o.rotation("rotation", pose.rotation);
  o.has("shape");
  if (o.planar() && !shape->planar()) shape = shape->section();
}

void read_fluid(Options& o, FluidDesc& d) {
  o.text("name", d.name);
  o.real("spacing", d.spacing, kPositive);
  o.real("density", d.density, kPositive);
  Real kinematic = 0;
  const bool has_dynamic = o.real("viscosity", d.viscosity, kNotNegative);
  if (o.real("kinematic_viscosity", kinematic, kNotNegative)) {
    if (has_dynamic)
      o.raise("kinematic_viscosity", "expected viscosity (Pa s) or kinematic_viscosity (m^2/s), got both");
    d.viscosity = kinematic * d.density;
  }
  o.real("surface_tension", d.surface_tension, kNotNegative);
  o.text("solver", d.solver);
  o.text("kernel", d.kernel);
  o.text("neighbors", d.neighbors);
  o.real("support", d.support, Range{1.2, 4});
  o.real("stiffness", d.stiffness, kNotNegative);
  o.real("compression", d.compression, Range{0, 0.5, true});
  o.real("artificial_viscosity", d.artificial_viscosity, Range{0, 10});
  o.real("gravity_scale", d.gravity_scale);
  std::int64_t n = 0;
  if (o.integer("iterations", n, 1, 1000)) d.iterations = static_cast<int>(n);
  if (o.integer("max_substeps", n, 1, 100000)) d.max_substeps = static_cast<int>(n);
  if (o.integer("max_particles", n, 1, 1 << 27)) d.max_particles = static_cast<std::size_t>(n);
  if (o.integer("group", n, 0, 0xffffffffll)) d.group = static_cast<std::uint32_t>(n);
  if (o.integer("mask", n, 0, 0xffffffffll)) d.mask = static_cast<std::uint32_t>(n);
}

}  // namespace

Fluid& fluids(WorldRecord& record) { return record.world->need<Fluid>(); }

int world_fluid(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  FluidDesc desc;
  read_fluid(o, desc);
  o.has("tags");
  o.finish();
  desc.tags = tag_option(o, r);
  push_handle(L, r, fluids(r).add_fluid(desc));
  return 1;
}

int fluid_fill(lua_State* L) {
  Self self = check_self(L);
  Options o(L, 2, function_name(L), self.record.planar());
  Vec3 velocity = Vec3::Zero();
  o.vector("velocity", velocity);
  std::size_t made = 0;
  if (o.push_any("points")) {
    const std::vector<Vec3> points = check_points(L, -1, o.path("points"), o.planar());
    lua_pop(L, 1);
    o.finish();
    charge(L, points.size());
    made = fluids(self.record).fill(self.id, points, velocity);
  } else {
    ShapePtr shape;
    Pose pose;
    shape_and_pose(o, shape, pose);
    o.finish();
    made = fluids(self.record).fill(self.id, *shape, pose, velocity);
    charge(L, made);
  }
  lua_pushinteger(L, static_cast<lua_Integer>(made));
  return 1;
}

int fluid_emitter(lua_State* L) {
  Self self = check_self(L);
  Options o(L, 2, function_name(L), self.record.planar());
  EmitterDesc d;
  o.text("name", d.name);
  o.vector("position", d.position);
  o.unit("direction", d.direction);
  o.real("speed", d.speed, kPositive);
  o.real("radius", d.radius, kNotNegative);
  o.real("rate", d.rate, kPositive);
  std::int64_t n = 0;
  if (o.integer("limit", n, 1, std::int64_t(1) << 40)) d.limit = static_cast<std::uint64_t>(n);
  o.has("tags");
  o.finish();
  d.tags = tag_option(o, self.record);
  push_handle(L, self.record, fluids(self.record).add_emitter(self.id, d));
  return 1;
}

int fluid_drain(lua_State* L) {
  Self self = check_self(L);
  Options o(L, 2, function_name(L), self.record.planar());
  std::string name;
  o.text("name", name);
  ShapePtr shape;
  Pose pose;
  shape_and_pose(o, shape, pose);
  o.has("tags");
  o.finish();
  const TagMask tags = tag_option(o, self.record);
  push_handle(L, self.record, fluids(self.record).add_drain(self.id, name, tags, std::move(shape), pose));
  return 1;
}

}  // namespace feder::lua
