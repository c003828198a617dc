#include "bounds/depth_views.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {
constexpr JobGrain kViewGrain{1, 100'000};

// Is [near, far] in front of all nearest depths of a row, or behind all farthest?
struct Seen {
  bool front = true, back = true;
};
void look(const Real* nearest, const Real* farthest, std::uint32_t count, Real near, Real far, Seen& seen) {
  unsigned hidden = 0, covering = 0;
  for (std::uint32_t k = 0; k < count; ++k)
    hidden |= static_cast<unsigned>(!(far < nearest[k])), covering |= static_cast<unsigned>(!(near > farthest[k]));
  seen.front = seen.front && !hidden, seen.back = seen.back && !covering;
}
void cover(Real* nearest, Real* farthest, std::uint32_t count, Real near, Real far) {
  for (std::uint32_t k = 0; k < count; ++k)
    nearest[k] = std::min(nearest[k], near), farthest[k] = std::max(farthest[k], far);
}
}  // namespace

std::uint32_t DepthViews::pixel(int axis, Real x) const {
  const double at = (static_cast<double>(x) - lo_[axis]) * per_[axis];
  return static_cast<std::uint32_t>(std::fmin(std::fmax(at, 0), pixels_ - 1));
}

// A view along an axis, from the first of the set to the last or the other way.
void DepthViews::draw(const Array<Aabb>& boxes, const Array<std::uint32_t>& set, int task) {
  const int along = task / 2, u = (along + 1) % 3, v = (along + 2) % 3;
  const bool forwards = task % 2 == 0;
  const auto side = static_cast<std::size_t>(pixels_), area = side * side;
  Real* nearest = depth_.data() + 2 * area * static_cast<std::size_t>(task);
  Real* farthest = nearest + area;
  std::fill(nearest, nearest + area, kInfinity), std::fill(farthest, farthest + area, -kInfinity);
  unsigned char* seen = seen_.data() + set.size() * static_cast<std::size_t>(task);
  for (std::size_t n = 0; n < set.size(); ++n) {
    const std::size_t at = forwards ? n : set.size() - 1 - n;
    const Aabb& box = boxes[set[at]];
    const std::uint32_t left = pixel(u, box.lo[u]), count = pixel(u, box.hi[u]) - left + 1;
    const std::uint32_t first = pixel(v, box.lo[v]), last = pixel(v, box.hi[v]);
    const Real near = box.lo[along], far = box.hi[along];
    Seen all;
    for (std::size_t row = first; row <= last; ++row) {
      const std::size_t from = row * side + left;
      if (all.front || all.back) look(nearest + from, farthest + from, count, near, far, all);
      cover(nearest + from, farthest + from, count, near, far);
    }
    seen[at] = all.front || all.back;
  }
}

std::uint64_t DepthViews::cull(const Array<Aabb>& boxes, int pixels, Array<std::uint32_t>& set, JobPool& jobs) {
  FEDER_ASSERT(pixels > 0 && pixels % 8 == 0);
  pixels_ = pixels;
  Aabb all;
  for (const std::uint32_t i : set) all.include(boxes[i]);
  for (int k = 0; k < 3 && !set.empty(); ++k) {
    const double wide = static_cast<double>(all.hi[k]) - static_cast<double>(all.lo[k]);
    lo_[k] = static_cast<double>(all.lo[k]), per_[k] = wide > 0 ? pixels / wide : 0;
  }
  depth_.resize(2 * kTasks * static_cast<std::size_t>(pixels) * static_cast<std::size_t>(pixels));
  seen_.resize(kTasks * set.size());
  std::uint64_t drawn = 0;
  for (std::size_t before = set.size() + 1; set.size() < before && set.size() > 1;) {
    before = set.size();
    drawn += before;
    jobs.for_blocks(kTasks, kViewGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t task = first; task < last; ++task) draw(boxes, set, static_cast<int>(task));
    });
    std::size_t stays = 0;
    for (std::size_t n = 0; n < before; ++n) {
      const auto seen = [&](std::size_t task) { return seen_[task * before + n] != 0; };
      const bool apart = (seen(0) || seen(2) || seen(4)) && (seen(1) || seen(3) || seen(5));
      if (!apart) set[stays++] = set[n];
    }
    set.resize(stays);
  }
  if (set.size() == 1) set.clear();
  return drawn;
}

}  // namespace feder
