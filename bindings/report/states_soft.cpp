#include "feder/soft.h"
#include "report/states.h"

namespace feder::report {
namespace {

void read_soft(World& world, ObjectId id, ObjectState& out) {
  const Soft& soft = *world.find<Soft>();
  soft.positions(id, out.positions);
  for (std::size_t i = 0; i < out.positions.size(); ++i) {
    out.velocities.push_back(soft.velocity(id, i));
    out.masses.push_back(soft.point_mass(id, i));
  }
}

}  // namespace

StateReader states_soft() { return {kSoftKind, false, read_soft}; }

}  // namespace feder::report
