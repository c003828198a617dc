// Rigid bodies as plain arrays, indexed by a stable body index (a destroyed body leaves a free index that is used
// again). Positions are of the centre of mass; the body frame has its origin at the script's `position`.
#pragma once
#include "feder/body.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"
#include "state/arrays.h"

namespace feder {

struct Bodies {
  explicit Bodies(Arena& a) : arena(a) {}

  Arena& arena;
  Array<BodyType> type{&arena};
  Array<std::uint8_t> awake{&arena};  // 0 or 1; fixed bodies are never awake
  Array<std::uint8_t> can_sleep{&arena};
  Array<Real> sleep_threshold{&arena};  // m/s
  Array<std::uint8_t> bullet{&arena};
  Array<std::uint8_t> lock{&arena};  // LockBits
  Array<ObjectId> object{&arena};
  Array<Vec3> position{&arena};               // centre of mass, world, m
  Array<Quat> rotation{&arena};               // body to world
  Array<Vec3> velocity{&arena};               // of the centre of mass, m/s
  Array<Vec3> angular_velocity{&arena};       // world, rad/s
  Array<Vec3> local_com{&arena};              // centre of mass in the body frame, m
  Array<Real> mass{&arena};                   // kg; 0 unless dynamic
  Array<Real> inv_mass{&arena};               // 1/kg
  Array<Mat3> inertia{&arena};                // about the centre of mass, body axes, kg m^2
  Array<Mat3> inv_inertia{&arena};            // zero unless dynamic; locks are applied in world axes by the solver
  Array<Vec3> force{&arena}, torque{&arena};  // applied by script, world, N and N m; cleared after a step
  Array<Real> gravity_scale{&arena};
  Array<Real> linear_damping{&arena}, angular_damping{&arena};  // 1/s
  Array<Real> extent{&arena};  // farthest point of the shapes from the centre of mass, m
  Array<Pose> target{&arena};  // kinematic: origin pose wanted at the end of the step; may be shorter than the others
  Array<std::uint8_t> has_target{&arena};
  Array<Real> sleep_energy{&arena};             // moving average of kinetic energy per mass, m^2/s^2
  Array<std::uint32_t> island{&arena};          // island of a sleeping body (kNone when awake)
  Array<std::uint32_t> first_collider{&arena};  // head of the list through Colliders::next_of_body
  Array<std::uint32_t> solver_slot{&arena};     // slot in SolverBodies
  Array<std::uint32_t> free_list{&arena};

  std::uint32_t size() const { return static_cast<std::uint32_t>(type.size()); }
  std::uint32_t add();  // index with defaults: fixed, identity, at rest
  void remove(std::uint32_t i);
  void validate() const;  // asserts what holds of the arrays by themselves

  // Awake and dynamic: impulses move it. kNone, the world, never is.
  bool moves(std::uint32_t i) const { return i != kNone && type[i] == BodyType::dynamic && awake[i]; }
  Vec3 origin(std::uint32_t i) const { return position[i] - rotate(rotation[i], local_com[i]); }
  Pose origin_pose(std::uint32_t i) const { return {origin(i), rotation[i]}; }
  Pose com_pose(std::uint32_t i) const { return {position[i], rotation[i]}; }
  // R I^-1 R^T with locked axes zeroed.
  Mat3 world_inv_inertia(std::uint32_t i) const;
  Vec3 velocity_at(std::uint32_t i, const Vec3& world_point) const {
    return velocity[i] + cross(angular_velocity[i], world_point - position[i]);
  }

  // Calls f(array) for each of the arrays that have an entry per body.
  template <class B, class F>
  static void each_array(B& b, F&& f) {
    for_each_of(f, b.type, b.awake, b.can_sleep, b.sleep_threshold, b.bullet, b.lock, b.object, b.position, b.rotation,
                b.velocity, b.angular_velocity, b.local_com, b.mass, b.inv_mass, b.inertia, b.inv_inertia, b.force,
                b.torque, b.gravity_scale, b.linear_damping, b.angular_damping, b.extent, b.has_target, b.sleep_energy,
                b.island, b.first_collider, b.solver_slot);
  }
  // Calls f(member) for what snapshots hold.
  template <class B, class F>
  static void each_saved(B& b, F&& f) {
    each_array(b, f);
    for_each_of(f, b.target, b.free_list);
  }
};

}  // namespace feder
