#include "feder/net.h"
#include "report/states.h"

namespace feder::report {
namespace {

// Springs that are whole as lines, faces as triangles.
void read_net(World& world, ObjectId id, ObjectState& out) {
  const Springs& springs = *world.find<Springs>();
  springs.positions(id, out.positions);
  for (std::size_t i = 0; i < out.positions.size(); ++i) {
    out.velocities.push_back(springs.velocity(id, i));
    out.masses.push_back(springs.point_mass(id, i));
  }
  const SpringView s = springs.springs(id);
  for (std::size_t k = 0; k < s.i.size(); ++k)
    if (s.alive[k]) out.lines.insert(out.lines.end(), {s.i[k], s.j[k]});
  for (std::size_t n = 0; n < springs.net_count(); ++n)
    if (const Springs::NetInfo net = springs.net_info(n); net.object == id)
      out.triangles.assign(net.faces.begin(), net.faces.end());
}

}  // namespace

StateReader states_springs() { return {kNetKind, false, read_net}; }

}  // namespace feder::report
