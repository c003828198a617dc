// Description of a world. Plain data: World's constructor checks it (SceneError names the field).
#pragma once
#include <map>
#include <string>

#include "feder/params.h"
#include "feder/types.h"

namespace feder {

struct WorldDesc {
  Vec3 gravity = Vec3(0, Real(-9.81), 0);  // m/s^2
  double dt = 1.0 / 60.0;                  // s per step, in (0, 1]
  int substeps = 4;                        // 1 .. 1000
  std::uint64_t seed = 1;
  int threads = 1;  // 1 .. 64; results do not depend on it
  bool sleeping = true;
  bool rebuild = false;  // in every step all that is kept beside the state is made anew: results do not depend on it
  int dimension = 3;     // 2: bodies move in the xy plane
  Params options;        // broad_phase, narrow_phase
  std::map<std::string, Params> systems;  // options per system: systems["rigid"] holds solver = "soft_step" ...

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.gravity), f(d.dt), f(d.substeps), f(d.seed), f(d.threads), f(d.sleeping), f(d.rebuild), f(d.dimension);
    f(d.options), f(d.systems);
  }
};

// SceneError naming the field when something is out of range.
void check(const WorldDesc& desc);

}  // namespace feder
