// Middles of boxes, which trees of boxes are divided by.
#pragma once
#include <algorithm>
#include <span>

#include "feder/types.h"

namespace feder {

struct BoxMiddle {
  Real at[3];  // m
  std::uint32_t item;
};

// Puts the `half` lowest along the axis on which they extend farthest first, equal ones by item; returns that axis.
inline int divide_middles(std::span<BoxMiddle> middles, std::size_t half) {
  Real lo[3], hi[3];
  for (int k = 0; k < 3; ++k) lo[k] = kInfinity, hi[k] = -kInfinity;
  for (const BoxMiddle& m : middles)
    for (int k = 0; k < 3; ++k) lo[k] = std::min(lo[k], m.at[k]), hi[k] = std::max(hi[k], m.at[k]);
  const Real size[3] = {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]};
  const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  std::nth_element(middles.begin(), middles.begin() + static_cast<std::ptrdiff_t>(half), middles.end(),
                   [axis](const BoxMiddle& a, const BoxMiddle& b) {
                     return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.item < b.item;
                   });
  return axis;
}

}  // namespace feder
