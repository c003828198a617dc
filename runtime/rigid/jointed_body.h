// Rotation of a jointed body with uneven moments of inertia. A substep kicks, then drifts: forces, joints and contacts
// change the angular momentum L at the pose where the substep begins, w = A I^-1 A^T L there (A: principal axes); then
// the body turns freely with L fixed, by the velocity at the middle of the turn (implicit midpoint). With joint
// impulses along the rows of the same pose that is a discrete variational integrator of constrained bodies (Wendlandt,
// Marsden 1997; SHAKE: Ryckaert, Ciccotti, Berendsen 1977): no pose is solved with the inertia of another one.
// All in double and by principal axes: moments in the ratio of 1:10^5 multiply the rounding of a world matrix by as
// much, and what joints believe of a body would not be what it does. Rows for directions do not foresee the turn
// (Row::bend is 0): the free turn of a body that a joint holds is not what it will do.
#pragma once
#include <span>

#include "state/solver_bodies.h"

namespace feder {

// Of a jointed body whose moments of inertia differ: its angular momentum in the substep.
struct JointedBody {
  Quat principal;                     // principal axes of inertia in the body frame
  Vec3d inv_moments = Vec3d::Zero();  // about them, 1/(kg m^2)
  Vec3d share = Vec3d::Ones();        // of each that joints felt
  Mat3d axes = Mat3d::Zero();         // columns: the principal axes in the world when the substep began
  Mat3d free_axes = Mat3d::Zero();    // the same after the turn that is motion, without what corrected positions
  Vec3d momentum = Vec3d::Zero();     // angular, of forces and joints so far, N m s
  Vec3 given_angular_velocity = Vec3::Zero();  // the angular velocity that stands for it, rad/s: what is more came from
                                               // contacts and couplings
  Vec3 mean_angular_velocity = Vec3::Zero();   // at the middle of the turn that forces alone would lead to, rad/s
  Vec3 drift_angular_velocity = Vec3::Zero();  // the angular velocity that the turn of this substep came from, rad/s
  Vec3 correction = Vec3::Zero();              // turn within that to free_axes that only corrected positions, rad
  bool uneven = false;                         // false: nothing here is used, SolverMass holds all there is
  bool slender = false;                        // contacts see larger moments than the body has: see slender_inv_moments

  Vec3d in_axes(const Vec3& v) const { return axes.transpose() * v.cast<double>(); }
  Vec3d felt() const { return inv_moments.cwiseProduct(share); }
};

// Null unless the solver body is a body on a joint with uneven moments of inertia. `jointed`: by solver index.
inline JointedBody* uneven_of(std::span<JointedBody> jointed, std::uint32_t index) {
  return index < jointed.size() && jointed[index].uneven ? &jointed[index] : nullptr;
}

// Principal axes in the world of the body turned by `rotation`.
Mat3d jointed_axes(const JointedBody& j, const Quat& rotation);

// Begins a substep with the momentum that forces left.
void start_jointed(JointedBody& j, const Vec3d& momentum, Real h, SolverBody& s);

// Impulse of joints, N m s: joints felt the axes of `j`. Returns the change of the angular velocity. `late`: it comes
// after the turn, as from a contact.
Vec3 push_jointed(JointedBody& j, const Vec3d& moment, SolverBody& s, bool late = false);

// What a moment of joints would change the angular velocity by.
inline Vec3 jointed_response(const JointedBody& j, const Vec3& moment) {
  return (j.axes * j.felt().cwiseProduct(j.in_axes(moment))).cast<Real>();
}

// Contacts push at the arms that they had at the start of the step, and in a slender body such an arm, a few degrees
// off, turns nearly all of a push into spin about the long axis. For them no principal moment is below a tenth of the
// largest, and what they changed of the angular velocity is what the body takes over.
Vec3d slender_inv_moments(const Vec3d& inv_moments);

// The momentum with what contacts and couplings gave: what their change of the velocity amounts to with the inertia
// they used, that of the start of the step; in slender bodies with that of the body now.
Vec3d jointed_momentum(const JointedBody& j, const SolverBody& s, const SolverMass& m);

// Makes what contacts and couplings gave so far a part of the momentum.
inline void take_pushes(JointedBody& j, const SolverBody& s, const SolverMass& m) {
  j.momentum = jointed_momentum(j, s, m);
  j.given_angular_velocity = s.angular_velocity;
}

// The same after the substep. A turn that only corrected positions would leave the momentum lying otherwise in the
// body: the spin about an axis with the moment I would gain (turn x L)^2/2I of energy. The momentum goes along with
// the body, the more the smaller the moment about an axis is.
Vec3d carried_momentum(const JointedBody& j, const SolverBody& s, const SolverMass& m);

// Turns freely for h seconds; returns the rotation vector, rad.
Vec3 rotate_jointed(JointedBody& j, Real h);

// The angular velocity at the middle of the free turn of h seconds from the axes of `j`, rad/s.
Vec3 mean_angular_velocity(const JointedBody& j, const Vec3d& momentum, Real h);

}  // namespace feder
