// The tank of the maps of fluids, in the plane. Private to the module.
#pragma once
#include "couple/fluid_rigid.h"
#include "feder/query.h"
#include "fluid/solver.h"
#include "study/worlds.h"

namespace feder {

// A floor and two walls, without a lid; `width`, m, from x = 0 on.
inline std::unique_ptr<World> make_tank(WorldDesc d, double width) {
  static const SystemDescriptor* const catalog[] = {&Collide::descriptor(), &Rigid::descriptor(), &Fluid::descriptor(),
                                                    &FluidRigid::descriptor()};
  d.dimension = 2;
  auto world = std::make_unique<World>(d, catalog);
  for (const Vec3& n : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(-1, 0, 0)}) {
    BodyDesc wall;
    wall.type = BodyType::fixed;
    wall.shape = make_plane(n, n[0] < 0 ? static_cast<Real>(-width) : Real(0));
    world->need<Rigid>().add_body(wall);
  }
  return world;
}

// A beam `width` by `height`, m, of `density`, kg/m^3, its middle at `at`.
inline ObjectId add_beam(World& world, double width, double height, double density, const Vec3d& at) {
  BodyDesc b;
  b.shape = make_box(static_cast<Real>(width), static_cast<Real>(height), 1)->section();
  b.density = static_cast<Real>(density);
  b.position = at.cast<Real>();
  return world.need<Rigid>().add_body(b);
}

}  // namespace feder
