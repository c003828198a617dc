// What the impulse solver works on: movers, contacts and joint blocks of one substep, and the closed-form answers for
// a single one of them. impulse.cpp decides the order.
#pragma once
#include "rigid/solver.h"

namespace feder {

// Per mover, beside MoverState and MoverMass.
struct ImpulseBody {
  Mat3 inv_inertia = Mat3::Zero();                                // world, at the start of the step
  Vec3 last_velocity = Vec3::Zero(), last_spin = Vec3::Zero();    // when the last substep ended
  Vec3 force_velocity = Vec3::Zero(), force_spin = Vec3::Zero();  // gained from forces in this substep
  Vec3 late_move = Vec3::Zero(), late_turn = Vec3::Zero();        // of impacts inside the substep, m and rad
  bool movable = false;
};

struct ImpulseScene {
  MoverState* state;
  const MoverMass* mass;
  ImpulseBody* body;
  Real h;           // s
  Real rest_speed;  // m/s: slower impacts do not bounce
  Real slop;        // m: overlap left alone
};

// Impulse on mover i: linear part and moment about its centre.
inline void push(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3& moment) {
  if (!s.body[i].movable) return;
  s.state[i].velocity += s.mass[i].inv_mass_axes.cwiseProduct(linear);
  s.state[i].angular_velocity += s.body[i].inv_inertia * moment;
}

// The same for positions: `linear` in kg m, `moment` in kg m^2.
inline void shift(const ImpulseScene& s, std::uint32_t i, const Vec3& linear, const Vec3& moment) {
  if (!s.body[i].movable) return;
  const Vec3 turn = s.body[i].inv_inertia * moment;
  s.state[i].moved += s.mass[i].inv_mass_axes.cwiseProduct(linear);
  s.state[i].turned += turn;
  s.state[i].rotation = integrate_rotation(s.state[i].rotation, turn);
}

struct ImpulsePoint {
  Vec3 arm_a = Vec3::Zero(), arm_b = Vec3::Zero();  // at the start of the step, m
  Mat3 k = Mat3::Zero(), k_inverse = Mat3::Zero();  // relative velocity per impulse, 1/kg, and its inverse
  Vec3 impulse = Vec3::Zero();    // on b, accumulated in this substep; may be taken back
  Real start_separation = 0;      // m
  Real separation = 0;            // at the start of the substep, m
  Real target = 0;                // normal speed the point must at least have, m/s
  Real force_speed = 0;           // closing speed that forces added in this substep, m/s
  Real bounced = 0;               // normal impulse of impacts in this substep: never taken back
};

struct ImpulseContact {
  std::uint32_t slot = 0, a = 0, b = 0;  // contact slot, solver indices
  int count = 0;
  Vec3 normal = Vec3::Zero();            // a to b
  Vec3 surface_velocity = Vec3::Zero();
  Real friction_static = 0, friction_dynamic = 0, restitution = 0, rolling_friction = 0;
  bool slides = false;                   // judged: the dynamic cone holds, else the static one
  ImpulsePoint points[kMaxContactPoints];
  Vec3 rolling = Vec3::Zero();           // accumulated rolling impulse on b, N m s
};

// Contacts (impulse_contact.cpp).
void load_contact(const Contact& from, const ImpulseScene& s, ImpulseContact& c);  // once per step; c.a and c.b are set
void store_contact(const ImpulseContact& c, Contact& to);
void start_contact(ImpulseContact& c, const ImpulseScene& s);        // gaps and targets; applies what was kept
Real contact_speed_error(const ImpulseContact& c, const ImpulseScene& s);  // m/s: what solving it would change
void solve_contact_speed(ImpulseContact& c, const ImpulseScene& s, Real tolerance);
bool begins_to_slide(const ImpulseContact& c, const ImpulseScene& s);  // to be asked when speeds are solved
Real contact_depth(const ImpulseContact& c, const ImpulseScene& s);  // beyond the slop, m
void push_contact_apart(const ImpulseContact& c, const ImpulseScene& s);

// A block of joint rows with J M^-1 J^T factored as L D L^T.
struct ImpulseBlock {
  Real factor[6][6];      // L below the diagonal
  Real inv_d[6];          // 0 for rows that depend on others
  Real target[6];         // wanted J v (rows with softness: less gamma times the impulse)
  Real gamma[6];
};

struct ImpulseJoint {
  std::uint32_t joint = 0, a = 0, b = 0;  // index in SolverInput::joints, solver indices
  std::uint32_t first_block = 0, block_count = 0;
};

struct ImpulseRows {
  const Row* rows;
  const RowBlock* blocks;
};

// Joints (impulse_joint.cpp).
void factor_block(const Row* rows, int count, std::uint32_t a, std::uint32_t b, const ImpulseScene& s,
                  ImpulseBlock& out);
void apply_block(const Row* rows, int count, std::uint32_t a, std::uint32_t b, const Real* impulse,
                 const ImpulseScene& s);
Real block_speed_error(const Row* rows, int count, std::uint32_t a, std::uint32_t b, const ImpulseBlock& block,
                       const Real* impulse, const ImpulseScene& s);
void solve_block_speed(const Row* rows, int count, std::uint32_t a, std::uint32_t b, const ImpulseBlock& block,
                       Real* impulse, const ImpulseScene& s);
// What the motion of the substep added to the errors of stiff rows (m or rad), and its way back in position and speed.
Real block_drift(const Row* start, const Row* now, int count);
void correct_drift(const Row* start, const Row* now, int count, std::uint32_t a, std::uint32_t b,
                   const ImpulseBlock& block, Real* impulse, const ImpulseScene& s);
Real block_position_error(const Row* rows, int count);  // m or rad
void correct_block(const Row* rows, int count, std::uint32_t a, std::uint32_t b, const ImpulseScene& s);

}  // namespace feder
