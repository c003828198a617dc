// Mass points as plain arrays: the points of all nets one after another (a net owns a run of indices).
#pragma once
#include "base/compensated.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"
#include "state/arrays.h"

namespace feder {

struct Particles {
  explicit Particles(Arena& a) : arena(a) {}

  Arena& arena;
  Array<Vec3> position{&arena};           // m, world
  Array<Vec3> position_low{&arena};       // what rounding left of it (base/compensated.h), m
  Array<Vec3> velocity{&arena};           // m/s
  Array<Vec3> start{&arena};              // position at the start of the step, m
  Array<Real> mass{&arena};               // kg
  Array<Real> inertia{&arena};            // kg; mass, plus what the point carries while couple lets the integrators run
  Array<Real> inv_mass{&arena};           // 1/inertia, 1/kg; 0 = pinned
  Array<Real> radius{&arena};             // m; 0 = does not collide
  Array<ObjectId> net{&arena};            // owner
  Array<Vec3> script_force{&arena};       // N
  Array<std::uint32_t> collider{&arena};  // in Colliders, kNone while nothing collides; kept by couple
  Array<std::uint32_t> solver_slot{&arena};  // in SolverBodies, likewise
  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }

  // Whoever changes a position does it by one of these.
  void place(std::uint32_t i, const Vec3& x) { position[i] = x, position_low[i] = Vec3::Zero(); }
  void move(std::uint32_t i, const Vec3& d) { add_compensated(position[i], position_low[i], d); }

  // Calls f(array) for every array, always in the same order: for growing, erasing, saving and loading.
  template <class P, class F>
  static void each_array(P& p, F&& f) {
    for_each_of(f, p.position, p.position_low, p.velocity, p.start, p.mass, p.inertia, p.inv_mass, p.radius, p.net,
                p.script_force, p.collider, p.solver_slot);
  }
};

}  // namespace feder
