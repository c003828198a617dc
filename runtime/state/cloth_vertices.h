// Vertices of all cloths one after another: a cloth owns a run of indices, first the visible ones, then hidden ones
// that nothing draws or hits (the far side of clamps, and one that fills empty lanes of kernels).
#pragma once
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"

namespace feder {

struct ClothVertices {
  explicit ClothVertices(Arena& a)
      : position(&a), velocity(&a), rest(&a), mass(&a), inv_mass(&a), cloth(&a), script_force(&a) {}

  Array<Vec3> position;      // m, world; within a step: at its start
  Array<Vec3> velocity;      // m/s
  Array<Vec3> rest;          // m, where it is unstrained (any frame)
  Array<Real> mass;          // kg
  Array<Real> inv_mass;      // 1/kg; 0 = pinned
  Array<ObjectId> cloth;     // owner
  Array<Vec3> script_force;  // N
  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }

  // Calls f(array) for every array, always in the same order: for growing, erasing, saving and loading.
  template <class V, class F>
  static void each_array(V& v, F&& f) {
    f(v.position), f(v.velocity), f(v.rest), f(v.mass), f(v.inv_mass), f(v.cloth), f(v.script_force);
  }
};

}  // namespace feder
