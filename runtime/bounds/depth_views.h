// Which of many boxes may meet others, by what hides what: orthographic views of them along x, y and z. Drawn one after
// another, a box that is seen in full in some view, wholly in front of all that were drawn before it or wholly behind
// them, meets none of these. One that is so against those before it and, in the opposite order, against those behind it
// leaves the set; that is repeated until the set stops shrinking. Source: Govindaraju, Redon, Lin & Manocha, "CULLIDE:
// Interactive Collision Detection Between Complex Models in Large Environments using Graphics Hardware" (2003).
// No pair is lost at any resolution: a pixel is a range of coordinates, to which rounding maps in order, so that boxes
// that overlap share one; a box covers all pixels that it reaches into, with its near and far end as depth, and being
// in front is a strict comparison of these numbers as they are.
#pragma once
#include "base/jobs.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

class DepthViews {
 public:
  explicit DepthViews(Arena& arena) : depth_(&arena), seen_(&arena) {}

  // As many as there are boxes, four times as many along a side, up to 256 along it.
  static int pixels_for(std::size_t count) {
    int side = 16;
    while (side < 256 && static_cast<std::size_t>(side) * static_cast<std::size_t>(side) < 16 * count) side *= 2;
    return side;
  }
  // Takes out of `set`, ascending, those that overlap no other of it. `pixels`: of each view, along a side, a multiple
  // of 8. Finite boxes with lo <= hi. The same for any number of threads. Returns how many boxes were drawn.
  std::uint64_t cull(const Array<Aabb>& boxes, int pixels, Array<std::uint32_t>& set, JobPool& jobs);

 private:
  static constexpr int kTasks = 6;  // three views in two orders
  void draw(const Array<Aabb>& boxes, const Array<std::uint32_t>& set, int task);
  std::uint32_t pixel(int axis, Real x) const;

  int pixels_ = 0;
  double lo_[3] = {0, 0, 0}, per_[3] = {0, 0, 0};  // m; pixels per metre
  Array<Real> depth_;                              // by task: nearest and farthest by pixel, m
  Array<unsigned char> seen_;                      // by task and member of the set
};

}  // namespace feder
