// Mass points as plain arrays: the points of all nets one after another (a net owns a run of indices).
#pragma once
#include "base/compensated.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"

namespace feder {

struct Particles {
  explicit Particles(Arena& a)
      : position(&a), position_low(&a), velocity(&a), start(&a), mass(&a), inertia(&a), inv_mass(&a), radius(&a),
        net(&a), script_force(&a), collider(&a), solver_slot(&a) {}

  Array<Vec3> position;              // m, world
  Array<Vec3> position_low;          // what rounding left of it (base/compensated.h), m
  Array<Vec3> velocity;              // m/s
  Array<Vec3> start;                 // position at the start of the step, m
  Array<Real> mass;                  // kg
  Array<Real> inertia;               // kg; mass, plus what the point carries while couple lets the integrators run
  Array<Real> inv_mass;              // 1/inertia, 1/kg; 0 = pinned
  Array<Real> radius;                // m; 0 = does not collide
  Array<ObjectId> net;               // owner
  Array<Vec3> script_force;          // N
  Array<std::uint32_t> collider;     // in Colliders, kNone while nothing collides; kept by couple
  Array<std::uint32_t> solver_slot;  // in SolverBodies, likewise
  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }

  // Whoever changes a position does it by one of these.
  void place(std::uint32_t i, const Vec3& x) { position[i] = x, position_low[i] = Vec3::Zero(); }
  void move(std::uint32_t i, const Vec3& d) { add_compensated(position[i], position_low[i], d); }

  // Calls f(array) for every array, always in the same order: for growing, erasing, saving and loading.
  template <class P, class F>
  static void each_array(P& p, F&& f) {
    f(p.position), f(p.position_low), f(p.velocity), f(p.start), f(p.mass), f(p.inertia), f(p.inv_mass), f(p.radius),
        f(p.net), f(p.script_force);
    f(p.collider), f(p.solver_slot);
  }
};

}  // namespace feder
