#include "feder/fluid.h"
#include "report/states.h"

namespace feder::report {
namespace {

void read_fluid(World& world, ObjectId id, ObjectState& out) {
  const Fluid& fluid = *world.find<Fluid>();
  fluid.positions(id, out.positions);
  fluid.velocities(id, out.velocities);
  out.radii.assign(out.positions.size(), fluid.desc(id).spacing / 2);
}

void read_fluid_fields(World& world, ObjectId id, ObjectState& out) {
  Fluid& fluid = *world.query<Fluid>();
  const Real density = fluid.desc(id).density;
  fluid.densities(id, out.densities);
  for (Real& d : out.densities) d *= density;
  fluid.pressures(id, out.pressures);
}

}  // namespace

StateReader states_fluid() { return {kFluidKind, false, read_fluid, read_fluid_fields}; }

}  // namespace feder::report
