// Clipping of a convex loop by one half-space at a time (Sutherland and Hodgman 1974), with labels on its edges so that
// contact points keep their identity from step to step.
#pragma once
#include "feder/types.h"

namespace feder {

template <int kCapacity>
struct ClipLoop {
  int count = 0;
  Vec3 p[kCapacity];
  std::uint8_t edge[kCapacity];  // label of the edge from point i to i + 1
};

// Cuts off what has height(p) > 0; the edge that the cut leaves gets `label`. `closed`: a loop, else a segment.
template <int kCapacity, class Height>
void clip(ClipLoop<kCapacity>& loop, bool closed, std::uint8_t label, Height&& height) {
  Real h[kCapacity];
  bool any = false;
  for (int i = 0; i < loop.count; ++i) {
    h[i] = height(loop.p[i]);
    any = any || h[i] > 0;
  }
  if (!any) return;
  ClipLoop<kCapacity> cut;
  for (int i = 0; i < loop.count; ++i) {
    const int j = i + 1 < loop.count ? i + 1 : 0;
    const bool inside = h[i] <= 0, next_inside = h[j] <= 0;
    if (inside) {
      cut.p[cut.count] = loop.p[i];
      cut.edge[cut.count++] = loop.edge[i];
    }
    if (inside == next_inside || (!closed && j == 0) || cut.count == kCapacity) continue;
    cut.p[cut.count] = loop.p[i] + (h[i] / (h[i] - h[j])) * (loop.p[j] - loop.p[i]);
    cut.edge[cut.count++] = inside ? label : loop.edge[i];
  }
  // only what is in use
  loop.count = cut.count;
  for (int i = 0; i < cut.count; ++i) loop.p[i] = cut.p[i], loop.edge[i] = cut.edge[i];
}

}  // namespace feder
