// Random unit vectors.
#pragma once
#include "base/rng.h"
#include "feder/types.h"

namespace feder {

inline Vec3 random_direction(Rng& rng, bool planar) {
  for (;;) {
    const Real x = rng.uniform(-1, 1), y = rng.uniform(-1, 1), z = rng.uniform(-1, 1);
    const Vec3 v = vec3(x, y, planar ? Real(0) : z);
    if (dot(v, v) > Real(0.01) && dot(v, v) <= 1) return v / length(v);
  }
}

}  // namespace feder
