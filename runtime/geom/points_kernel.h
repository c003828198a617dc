// The kernels of points_wide.h. Included by points_plain.cpp and points_avx2.cpp, which differ in compiler flags only
// and give the same bits: each product is summed in the order of dot(), and a maximum does not depend on the order in
// which it is sought.
#pragma once
#include "geom/points_wide.h"

namespace feder {
namespace {

using namespace lanes;

[[gnu::always_inline]] inline Lanes along(const Lane8x3& p, Lanes x, Lanes y, Lanes z) {
  return load(p.x) * x + load(p.y) * y + load(p.z) * z;
}

unsigned farthest_point(const Lane8x3* groups, unsigned count, WideReal dx, WideReal dy, WideReal dz) {
  const Lanes x = all_lanes(dx), y = all_lanes(dy), z = all_lanes(dz);
  // each lane keeps its first best group
  Lanes best = along(groups[0], x, y, z);
  LaneMask in{};
  for (unsigned g = 1; g < count; ++g) {
    const Lanes h = along(groups[g], x, y, z);
    const LaneMask better = h > best;
    best = better ? h : best;
    in = better ? LaneMask{} + static_cast<WideIndex>(g) : in;
  }
  // of the lanes the best, and of equal ones the lowest index
  Lanes most = max(best, __builtin_shufflevector(best, best, 4, 5, 6, 7, 0, 1, 2, 3));
  most = max(most, __builtin_shufflevector(most, most, 2, 3, 0, 1, 6, 7, 4, 5));
  most = max(most, __builtin_shufflevector(most, most, 1, 0, 3, 2, 5, 4, 7, 6));
  const LaneMask lane{0, 1, 2, 3, 4, 5, 6, 7}, none = LaneMask{} + WideIndex(1 << 20);
  LaneMask index = best == most ? in * kLanes + lane : none;
  const auto lower = [](LaneMask a, LaneMask b) { return a < b ? a : b; };
  index = lower(index, __builtin_shufflevector(index, index, 4, 5, 6, 7, 0, 1, 2, 3));
  index = lower(index, __builtin_shufflevector(index, index, 2, 3, 0, 1, 6, 7, 4, 5));
  index = lower(index, __builtin_shufflevector(index, index, 1, 0, 3, 2, 5, 4, 7, 6));
  return index[0] < (1 << 20) ? static_cast<unsigned>(index[0]) : 0u;  // a direction that is not a number: the first
}

void rotated_bounds(const Lane8x3* groups, unsigned count, const WideReal* rotation, WideReal* lo, WideReal* hi) {
  for (int axis = 0; axis < 3; ++axis, rotation += 3) {
    const Lanes x = all_lanes(rotation[0]), y = all_lanes(rotation[1]), z = all_lanes(rotation[2]);
    Lanes low = along(groups[0], x, y, z), high = low;
    for (unsigned g = 1; g < count; ++g) {
      const Lanes h = along(groups[g], x, y, z);
      low = min(low, h), high = max(high, h);
    }
    low = min(low, __builtin_shufflevector(low, low, 4, 5, 6, 7, 0, 1, 2, 3));
    low = min(low, __builtin_shufflevector(low, low, 2, 3, 0, 1, 6, 7, 4, 5));
    high = max(high, __builtin_shufflevector(high, high, 4, 5, 6, 7, 0, 1, 2, 3));
    high = max(high, __builtin_shufflevector(high, high, 2, 3, 0, 1, 6, 7, 4, 5));
    lo[axis] = low[0] < low[1] ? low[0] : low[1];
    hi[axis] = high[0] > high[1] ? high[0] : high[1];
  }
}

}  // namespace
}  // namespace feder
