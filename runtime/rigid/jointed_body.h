// Rotation of a jointed body with uneven moments of inertia, kick then drift. Kick: forces, joints and contacts change
// the angular momentum L at the pose where the substep begins, w = A I^-1 A^T L there (A: principal axes). Drift: free
// rotation with L fixed, by the angular velocity at the middle of the rotation (implicit midpoint). With joint impulses
// along the rows of the same pose this is a discrete variational integrator of constrained bodies (Wendlandt, Marsden
// 1997; SHAKE: Ryckaert, Ciccotti, Berendsen 1977): no pose is solved with the inertia of another one.
// Precision: double, in principal axes. Moments in the ratio of 1:10^5 multiply the rounding of a world matrix by as
// much, so that the inertia in the joint solve would differ from that of the motion.
// Kept between substeps: momentum and rotation axes. Weak spot: rows for directions do not predict the free rotation
// (Row::bend is 0), because joints prevent most of it.
#pragma once
#include <span>

#include "state/solver_bodies.h"

namespace feder {

// Angular momentum of a jointed body with uneven moments of inertia, within a substep.
struct JointedBody {
  Quat principal;                              // principal axes of inertia in the body frame
  Vec3d inv_moments = Vec3d::Zero();           // about them, 1/(kg m^2)
  Vec3d share = Vec3d::Ones();                 // of each inverse moment that the joint solve uses (geometric stiffness)
  Mat3d axes = Mat3d::Zero();                  // columns: the principal axes in the world when the substep began
  Mat3d free_axes = Mat3d::Zero();             // the same after the free rotation, without position corrections
  Vec3d momentum = Vec3d::Zero();              // angular momentum from forces and joints so far, N m s
  Vec3 given_angular_velocity = Vec3::Zero();  // angular velocity of that momentum, rad/s: what exceeds it
                                               // came from contacts and couplings
  Vec3 mean_angular_velocity = Vec3::Zero();   // at the middle of the rotation by forces alone, rad/s
  Vec3 drift_angular_velocity = Vec3::Zero();  // of the drift of this substep, rad/s
  Vec3 correction = Vec3::Zero();              // part of that drift that only corrected positions, rad
  Quat contact_rotation;                       // of the body whose inertia contacts use
  bool uneven = false;                         // false: SolverMass is enough, nothing here is used
  bool slender = false;                        // contacts use larger moments: see slender_inv_moments

  Vec3d in_axes(const Vec3& v) const { return axes.transpose() * v.cast<double>(); }
  Vec3d felt() const { return inv_moments.cwiseProduct(share); }
};

// Null unless the solver body is a body on a joint with uneven moments of inertia. `jointed`: by solver index.
inline JointedBody* uneven_of(std::span<JointedBody> jointed, std::uint32_t index) {
  return index < jointed.size() && jointed[index].uneven ? &jointed[index] : nullptr;
}

// Principal axes in the world, of the body at `rotation`.
Mat3d jointed_axes(const JointedBody& j, const Quat& rotation);

// Kick: begins a substep with the momentum after forces.
void start_jointed(JointedBody& j, const Vec3d& momentum, Real h, SolverBody& s);

// Angular impulse of a joint, N m s, solved with the axes of `j`. Returns the change of the angular velocity. `late`:
// it acts after the drift, as a contact's does, and stays out of the momentum.
Vec3 push_jointed(JointedBody& j, const Vec3d& moment, SolverBody& s, bool late = false);

// Change of the angular velocity by a joint's angular impulse.
inline Vec3 jointed_response(const JointedBody& j, const Vec3& moment) {
  return (j.axes * j.felt().cwiseProduct(j.in_axes(moment))).cast<Real>();
}

// Inverse moments for contacts: no principal moment below a tenth of the largest. Contact arms are those of the start
// of the step, and in a slender body an arm a few degrees off puts nearly all of an impulse into rotation about the
// long axis. What contacts change of the angular velocity is taken over as it is.
Vec3d slender_inv_moments(const Vec3d& inv_moments);

// Inverse inertia that contacts use with the body at `rotation`, 1/(kg m^2).
Mat3d seen_inv_inertia(const JointedBody& j, const Quat& rotation);

// Contacts are to use the inertia now where the body has turned since: a projection in the metric of another pose, in
// turn with those of joints, adds energy. Returns whether they do; `change`, an angular velocity that contacts have
// given, is then what the same angular impulse gives now.
bool turn_seen(JointedBody& j, const Quat& rotation, Real* change);

// Angular momentum with the impulses of contacts and couplings: their change of the angular velocity times the inertia
// they used; for slender bodies the inertia now.
Vec3d jointed_momentum(const JointedBody& j, const SolverBody& s);

// Takes the impulses of contacts and couplings so far into the momentum.
inline void take_pushes(JointedBody& j, const SolverBody& s) {
  j.momentum = jointed_momentum(j, s);
  j.given_angular_velocity = s.angular_velocity;
}

// The same after the substep, carried along with position corrections. A rotation by r that only corrects positions
// would leave the momentum in another direction of the body and add an energy of (r x L)^2/2I about an axis with moment
// I: so the momentum is rotated with the body, the more the smaller the moment about an axis.
Vec3d carried_momentum(const JointedBody& j, const SolverBody& s);

// Drift: free rotation for h seconds; returns the rotation vector, rad.
Vec3 rotate_jointed(JointedBody& j, Real h);

// Angular velocity at the middle of a free rotation of h seconds from the axes of `j`, rad/s.
Vec3 mean_angular_velocity(const JointedBody& j, const Vec3d& momentum, Real h);

}  // namespace feder
