#include "feder/rope.h"
#include "report/states.h"

namespace feder::report {
namespace {

void read_rope(World& world, ObjectId id, ObjectState& out) {
  const Rope& ropes = *world.find<Rope>();
  ropes.positions(id, out.positions);
  for (std::size_t i = 0; i < out.positions.size(); ++i) {
    out.velocities.push_back(ropes.velocity(id, i));
    out.masses.push_back(ropes.point_mass(id, i));
  }
}

}  // namespace

StateReader states_rope() { return {kRopeKind, false, read_rope}; }

}  // namespace feder::report
