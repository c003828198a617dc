// Vertices of all cloths one after another: a cloth owns a run of indices, first the visible ones, then hidden ones
// that nothing draws or hits (the far side of clamps, and one that fills empty lanes of kernels).
#pragma once
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"
#include "state/arrays.h"

namespace feder {

struct ClothVertices {
  explicit ClothVertices(Arena& a) : arena(a) {}

  Arena& arena;
  Array<Vec3> position{&arena};      // m, world; within a step: at its start
  Array<Vec3> velocity{&arena};      // m/s
  Array<Vec3> rest{&arena};          // m, where it is unstrained (any frame)
  Array<Real> mass{&arena};          // kg
  Array<Real> inv_mass{&arena};      // 1/kg; 0 = pinned
  Array<ObjectId> cloth{&arena};     // owner
  Array<Vec3> script_force{&arena};  // N
  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }

  // Calls f(array) for every array, always in the same order: for growing, erasing, saving and loading.
  template <class V, class F>
  static void each_array(V& v, F&& f) {
    for_each_of(f, v.position, v.velocity, v.rest, v.mass, v.inv_mass, v.cloth, v.script_force);
  }
};

}  // namespace feder
