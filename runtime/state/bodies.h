// Rigid bodies as plain arrays, indexed by a stable body index (a destroyed body leaves a free index that is used
// again). Positions are of the centre of mass; the body frame has its origin at the script's `position`.
#pragma once
#include "feder/body.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"

namespace feder {

struct Bodies {
  explicit Bodies(Arena& a);

  Array<BodyType> type;
  Array<std::uint8_t> awake;  // 0 or 1; fixed bodies are never awake
  Array<std::uint8_t> can_sleep;
  Array<std::uint8_t> bullet;
  Array<std::uint8_t> lock;  // LockBits
  Array<ObjectId> object;
  Array<Vec3> position;          // centre of mass, world, m
  Array<Quat> rotation;          // body to world
  Array<Vec3> velocity;          // of the centre of mass, m/s
  Array<Vec3> angular_velocity;  // world, rad/s
  Array<Vec3> local_com;         // centre of mass in the body frame, m
  Array<Real> mass;              // kg; 0 unless dynamic
  Array<Real> inv_mass;          // 1/kg
  Array<Mat3> inertia;           // about the centre of mass, body axes, kg m^2
  Array<Mat3> inv_inertia;       // zero unless dynamic; locks are applied in world axes by the solver
  Array<Vec3> force, torque;     // applied by script, world, N and N m; cleared after a step
  Array<Real> gravity_scale;
  Array<Real> linear_damping, angular_damping;  // 1/s
  Array<Real> extent;                           // farthest point of the shapes from the centre of mass, m
  Array<Pose> target;                           // kinematic: origin pose wanted at the end of the step
  Array<std::uint8_t> has_target;
  Array<Real> sleep_energy;             // moving average of kinetic energy per mass, m^2/s^2
  Array<std::uint32_t> island;          // island of a sleeping body (kNone when awake)
  Array<std::uint32_t> first_collider;  // head of the list through Colliders::next_of_body
  Array<std::uint32_t> solver_slot;     // slot in SolverBodies
  Array<std::uint32_t> free_list;

  std::uint32_t size() const { return static_cast<std::uint32_t>(type.size()); }
  std::uint32_t add();  // index with defaults: fixed, identity, at rest
  void remove(std::uint32_t i);
  void validate() const;  // asserts what holds of the arrays by themselves

  Vec3 origin(std::uint32_t i) const { return position[i] - rotate(rotation[i], local_com[i]); }
  Pose origin_pose(std::uint32_t i) const { return {origin(i), rotation[i]}; }
  Pose com_pose(std::uint32_t i) const { return {position[i], rotation[i]}; }
  // R I^-1 R^T with locked axes zeroed.
  Mat3 world_inv_inertia(std::uint32_t i) const;
  Vec3 velocity_at(std::uint32_t i, const Vec3& world_point) const {
    return velocity[i] + cross(angular_velocity[i], world_point - position[i]);
  }

  void save(Writer& w) const;
  void load(Reader& r);
};

}  // namespace feder
