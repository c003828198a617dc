#include "feder/rigid.h"
#include "report/states.h"

namespace feder::report {
namespace {

void read_body(World& world, ObjectId id, ObjectState& out) {
  const Rigid& rigid = *world.find<Rigid>();
  out.pose = rigid.pose(id);
  out.velocity = rigid.velocity(id);
  out.angular_velocity = rigid.angular_velocity(id);
}

}  // namespace

StateReader states_rigid() { return {kBodyKind, true, read_body}; }

}  // namespace feder::report
