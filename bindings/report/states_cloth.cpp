#include "feder/cloth.h"
#include "report/states.h"

namespace feder::report {
namespace {

void read_cloth(World& world, ObjectId id, ObjectState& out) {
  const Cloth& cloth = *world.find<Cloth>();
  cloth.positions(id, out.positions);
  cloth.triangles(id, out.triangles);
  for (std::size_t i = 0; i < out.positions.size(); ++i) {
    out.velocities.push_back(cloth.velocity(id, i));
    out.masses.push_back(cloth.point_mass(id, i));
  }
}

}  // namespace

StateReader states_cloth() { return {kClothKind, false, read_cloth}; }

}  // namespace feder::report
