// Ball joint: two anchors stay together, all rotations are free. One block of three rows along the world axes,
// C = anchor_b - anchor_a. Weak spot: while C is not zero the impulses make a couple C x impulse, since the Jacobian
// is the exact derivative.
#include "constrain/frames.h"

namespace feder::joints {
namespace {

void fill(const JointInput& in, RowWriter& out) { fill_point_rows(world_anchors(in), in, out.block(3)); }

}  // namespace

JointKind constrain_ball() { return {"ball", "two anchors stay together", fill, no_coordinate, 0, WideRows::point}; }

}  // namespace feder::joints
