// Time of impact of two moving shapes.
#pragma once
#include "feder/shape.h"
#include "feder/system.h"

namespace feder {

// A shape on an owner that moves by `shift` and turns by the rotation vector `turn` (rad, at a constant rate) in a
// step.
struct Sweep {
  const Shape* shape = nullptr;
  Pose local;  // in the owner's centre-of-mass frame
  Pose from;   // of that frame at the start of the step
  Vec3 shift = Vec3::Zero(), turn = Vec3::Zero();
  Real extent = kInfinity;  // of the shape from that centre of mass, m
  Real half_width = 0;      // least_half_width of the shape; asked of the first of two

  Pose owner_at(Real t) const {  // t: fraction of the step
    const bool turns = !turn.isZero(0);
    return {from.position + t * shift, turns ? integrate_rotation(from.rotation, t * turn) : from.rotation};
  }
  Pose at(Real t) const { return owner_at(t) * local; }
};

// The core of a convex shape is the shape at this scale about a point well inside: what meets another shape's surface
// is about to pass through it; what a body in contact brushes along never comes so near.
inline constexpr Real kCoreScale = 1 - kCoreDepth;

struct Impact {
  Real time = 2;               // fraction of the step; above 1: none
  Vec3 normal = Vec3::Zero();  // unit, world, from a to b
  Vec3 point = Vec3::Zero();   // on b, world
  bool inside = false;         // b was in a's core at the beginning, and is near the middle of a now
};

// When convex `a`, on its way from `begin` to `end`, has to stop lest its core goes through b: where the shapes
// themselves are `target` apart, or, when they begin nearer than that, where the core meets b. b: any shape but a
// compound.
Impact time_of_impact(const Sweep& a, const Sweep& b, Real begin, Real end, Real target);

}  // namespace feder
