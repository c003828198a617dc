// Working set of the impulse solver: solver bodies, contacts and joint blocks of one substep, and the closed-form
// solution of a single one. impulse.cpp decides the order.
#pragma once
#include "feder/error.h"
#include "rigid/solver.h"
#include "state/rows.h"
#include "state/solver_bodies.h"

namespace feder {

// Per solver body, beside SolverBody and SolverMass.
struct ImpulseBody {
  Mat3 inv_inertia = Mat3::Zero();  // world, at the start of the step: contacts
  JointedBody* uneven = nullptr;    // for joints, whose inertia rotates with the body
  Vec3 last_velocity = Vec3::Zero(), last_angular_velocity = Vec3::Zero();    // when the last substep ended
  Vec3 force_velocity = Vec3::Zero(), force_angular_velocity = Vec3::Zero();  // gained from forces in this substep
  Vec3 impact_delta_position = Vec3::Zero(),
       impact_delta_rotation = Vec3::Zero();   // corrections of the travel by impacts inside the substep, m and rad
  Quat substep_rotation;                       // at the start of the substep
  Vec3 substep_delta_rotation = Vec3::Zero();  // by motion and joints since then, rad
  bool movable = false;
};

struct ImpulseScene {
  SolverBody* state;
  const SolverMass* mass;
  ImpulseBody* body;
  Real h;           // s
  Real rest_speed;  // m/s: slower impacts do not bounce
  Real slop;        // m: overlap left alone
};

// Impulse on solver body i: linear part and moment about its centre.
inline void push(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3& moment) {
  if (!s.body[i].movable) return;
  s.state[i].velocity += s.mass[i].inv_mass_axes.cwiseProduct(linear);
  s.state[i].angular_velocity += s.body[i].inv_inertia * moment;
}

// Change of the angular velocity by a joint's angular impulse.
inline Vec3 joint_response(const ImpulseBody& b, const Vec3& moment) {
  return b.uneven ? jointed_response(*b.uneven, moment) : Vec3(b.inv_inertia * moment);
}

// Impulse of a joint.
inline void push_joint(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3d& moment) {
  ImpulseBody& b = s.body[i];
  if (!b.movable) return;
  s.state[i].velocity += s.mass[i].inv_mass_axes.cwiseProduct(linear);
  if (b.uneven)
    push_jointed(*b.uneven, moment, s.state[i]);
  else
    s.state[i].angular_velocity += b.inv_inertia * moment.cast<Real>();
}

// Rotation of the substep so far, rad: uneven bodies rotate freely with the momentum they have.
inline Vec3 free_delta_rotation(const ImpulseScene& s, std::uint32_t i) {
  const ImpulseBody& b = s.body[i];
  const Vec3 w = b.uneven ? mean_angular_velocity(*b.uneven, b.uneven->momentum, s.h) : s.state[i].angular_velocity;
  return s.h * w + b.impact_delta_rotation;
}

// Position correction by a contact: `linear` in kg m, `moment` in kg m^2.
inline void shift(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3& moment) {
  ImpulseBody& b = s.body[i];
  if (!b.movable) return;
  const Vec3 rotation = b.inv_inertia * moment;
  s.state[i].delta_position += s.mass[i].inv_mass_axes.cwiseProduct(linear);
  s.state[i].delta_rotation += rotation;
  b.substep_rotation = s.state[i].rotation = integrate_rotation(s.state[i].rotation, rotation);
  b.substep_delta_rotation = Vec3::Zero();
}

// Rotation of a jointed body: one rotation vector from the start of the substep, because successive ones do not add up.
inline void rotate_joint(const ImpulseScene& s, std::uint32_t i, const Vec3& rotation) {
  ImpulseBody& b = s.body[i];
  s.state[i].delta_rotation += rotation - b.substep_delta_rotation;
  b.substep_delta_rotation = rotation;
  s.state[i].rotation = integrate_rotation(b.substep_rotation, rotation);
}

inline void shift_joint(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3& moment) {
  ImpulseBody& b = s.body[i];
  if (!b.movable) return;
  const Vec3 rotation = joint_response(b, moment);
  s.state[i].delta_position += s.mass[i].inv_mass_axes.cwiseProduct(linear);
  rotate_joint(s, i, b.substep_delta_rotation + rotation);
}

// Impulse of a joint after the drift, in velocity and position as if it had acted before.
inline void push_back(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3d& moment) {
  if (!s.body[i].movable) return;
  push_joint(s, i, linear, moment);
  s.state[i].delta_position += s.h * s.mass[i].inv_mass_axes.cwiseProduct(linear);
  rotate_joint(s, i, free_delta_rotation(s, i));
}

struct ImpulsePoint {
  Vec3 arm_a = Vec3::Zero(), arm_b = Vec3::Zero();  // at the start of the step, m
  Mat3 k = Mat3::Zero(), k_inverse = Mat3::Zero();  // relative velocity per impulse, 1/kg, and its inverse
  Vec3 impulse = Vec3::Zero();                      // on b, accumulated in this substep; may shrink again
  Real start_separation = 0;                        // m
  Real separation = 0;                              // at the start of the substep, m
  Real target = 0;                                  // normal speed the point must at least have, m/s
  Real force_speed = 0;                             // closing speed that forces added in this substep, m/s
  Real bounced = 0;                                 // normal impulse of impacts in this substep: final
};

struct ImpulseContact {
  std::uint32_t slot = 0, a = 0, b = 0;  // contact slot, solver indices
  int count = 0;
  Vec3 normal = Vec3::Zero();  // a to b
  Vec3 surface_velocity = Vec3::Zero();
  Real friction_static = 0, friction_dynamic = 0, restitution = 0, rolling_friction = 0;
  bool slides = false;  // the dynamic friction cone is used, else the static one
  ImpulsePoint points[kMaxContactPoints];
  Vec3 rolling = Vec3::Zero();  // accumulated rolling impulse on b, N m s
};

// Contacts (impulse_contact.cpp).
void load_contact(const Contact& from, const ImpulseScene& s, ImpulseContact& c);  // once per step; c.a and c.b are set
void store_contact(const ImpulseContact& c, Contact& to);
void start_contact(ImpulseContact& c, const ImpulseScene& s);              // separations and targets; warm start
Real contact_speed_error(const ImpulseContact& c, const ImpulseScene& s);  // m/s: the change that a solve would make
void solve_contact_speed(ImpulseContact& c, const ImpulseScene& s, Real tolerance);
bool begins_to_slide(const ImpulseContact& c, const ImpulseScene& s);  // once speeds are solved
Real contact_depth(const ImpulseContact& c, const ImpulseScene& s);    // beyond the slop, m
void push_contact_apart(const ImpulseContact& c, const ImpulseScene& s);

// A block of joint rows with J M^-1 J^T factored as L D L^T.
struct ImpulseBlock {
  Real factor[6][6];  // L below the diagonal
  Real inv_d[6];      // 0 for rows that depend on others
  Real target[6];     // wanted J v (rows with softness: less gamma times the impulse)
  Real gamma[6];
};

struct ImpulseJoint {
  std::uint32_t joint = 0, a = 0, b = 0;  // index in SolverInput::joints, solver indices
  std::uint32_t first_block = 0, block_count = 0;
};

// Joint rows that are solved together, and the solver bodies they push.
struct BlockRows {
  const Row* rows;
  int count;
  std::uint32_t a, b;
};

// Joints (impulse_joint.cpp).
void factor_block(const BlockRows& r, const ImpulseScene& s, ImpulseBlock& out);
void apply_block(const BlockRows& r, const Real* impulse, const ImpulseScene& s);
// The same after the drift, in velocity and position as if it had acted before.
void push_back_block(const BlockRows& r, const Real* impulse, const ImpulseScene& s);
Real block_speed_error(const BlockRows& r, const ImpulseBlock& block, const Real* impulse, const ImpulseScene& s);
void solve_block_speed(const BlockRows& r, const ImpulseBlock& block, Real* impulse, const ImpulseScene& s);
// What the motion of the substep added to the errors of stiff rows, m or rad; the correction of position and speed.
Real block_drift(const BlockRows& start, const BlockRows& now);
void correct_block_drift(const BlockRows& start, const BlockRows& now, const ImpulseBlock& block, Real* impulse,
                         const ImpulseScene& s);
Real block_position_error(const BlockRows& r);  // m or rad
void correct_block(const BlockRows& r, const ImpulseScene& s);

}  // namespace feder
