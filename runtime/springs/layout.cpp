// Building the layout: a sliced ELLPACK format. Slices of eight points in index order; in a slice, row r holds the r-th
// spring of each point, and a point's springs come in index order, so its sum is that of a loop over the springs. A
// slice has as many rows as the largest degree in it. Weak spot: a hub with thousands of springs pads seven neighbours.
#include "springs/layout.h"

#include <algorithm>

#include "springs/net.h"

namespace feder {

void SpringLayout::build(const SpringArrays& s, std::uint32_t points) {
  const std::uint32_t slice_count = (points + kLanes - 1) / kLanes;
  // behind the last slice, one row away from the origin, for lanes without a point
  position_.assign(slice_count * kLanes + 1, PointRow{});
  position_.back().x = 1;
  force_.assign(slice_count, Lane8x3{});
  snapped_.assign((s.size() + kLanes - 1) / kLanes, 0);
  lane_of_.assign(std::size_t{2} * s.size(), 0);

  // springs of each point, then rows of each slice
  bool damped = false, slack = false, power = false;
  std::vector<std::uint32_t> degree(slice_count * kLanes, 0);
  for (std::uint32_t k = 0; k < s.size(); ++k) {
    if (!s.alive[k]) continue;
    ++degree[s.i[k]], ++degree[s.j[k]];
    damped = damped || s.damping[k] > 0;
    slack = slack || s.tension_only[k];
    power = power || s.power[k] != 1;
  }
  row_begin_.assign(slice_count + 1, 0);
  FEDER_ASSERT(std::all_of(degree.begin() + points, degree.end(), [](std::uint32_t d) { return d == 0; }));
  for (std::uint32_t c = 0; c < slice_count; ++c)
    row_begin_[c + 1] =
        row_begin_[c] + *std::max_element(degree.begin() + c * kLanes, degree.begin() + (c + 1) * kLanes);
  const std::size_t row_count = row_begin_[slice_count];
  rows_.assign(row_count, SpringRow{});
  damping_.assign(damped ? row_count : 0, Lane8{});
  slack_.assign(slack ? row_count : 0, Lane8{});
  power_.assign(power ? row_count : 0, Lane8{});
  velocity_.assign(damped ? slice_count * kLanes + 1 : 0, PointRow{});

  std::fill(degree.begin(), degree.end(), 0);  // from here on: rows filled
  for (std::uint32_t k = 0; k < s.size(); ++k) {
    if (!s.alive[k]) continue;
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t self = end ? s.j[k] : s.i[k], other = end ? s.i[k] : s.j[k], lane = self % kLanes;
      const std::size_t row = row_begin_[self / kLanes] + degree[self]++;
      rows_[row].stiffness.v[lane] = s.stiffness[k];
      rows_[row].rest_length.v[lane] = s.rest_length[k];
      rows_[row].other[lane] = other;
      if (damped) damping_[row].v[lane] = s.damping[k];
      if (slack) slack_[row].v[lane] = s.tension_only[k];
      if (power) power_[row].v[lane] = s.power[k];
      lane_of_[std::size_t{2} * k + static_cast<std::size_t>(end)] = row * kLanes + lane;
    }
  }
  // padding: lanes without a spring read the last neighbour again, and those without a point the row behind all, since
  // a point at distance zero would take the slow path of the kernel
  for (std::uint32_t i = 0; i < slice_count * kLanes; ++i) {
    const std::uint32_t begin = row_begin_[i / kLanes], end = row_begin_[i / kLanes + 1], lane = i % kLanes;
    for (std::uint32_t r = begin + degree[i]; r < end; ++r)
      rows_[r].other[lane] = degree[i] > 0 ? rows_[r - 1].other[lane] : i < points ? i : slice_count * kLanes;
  }
  if constexpr (kAsserts) check_built(s);
}

void SpringLayout::remove(std::uint32_t k) {
  if (std::size_t{2} * k >= lane_of_.size()) return;  // newer than the last build
  for (std::size_t end = 0; end < 2; ++end) {
    const std::uint64_t at = lane_of_[std::size_t{2} * k + end];
    const std::size_t row = at / kLanes, lane = at % kLanes;
    FEDER_ASSERT(row < rows_.size());
    rows_[row].stiffness.v[lane] = 0;
    if (!damping_.empty()) damping_[row].v[lane] = 0;
  }
}

void SpringLayout::pack(std::span<const Vec3> x, std::span<const Vec3> v, std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t i = first; i < last; ++i) position_[i] = row_of(x[i]);
  if (damped())
    for (std::uint32_t i = first; i < last; ++i) velocity_[i] = row_of(v[i]);
}

unsigned SpringLayout::add_forces(std::uint32_t first, std::uint32_t last) {
  FEDER_ASSERT(first <= last && last <= slices());
  SpringPass p;
  p.position = &position_.data()->x;
  p.velocity = damped() ? &velocity_.data()->x : nullptr;
  p.row_begin = row_begin_.data();
  p.rows = rows_.data();
  p.damping = damped() ? damping_.data() : nullptr;
  p.slack = slack_.empty() ? nullptr : slack_.data();
  p.power = power_.empty() ? nullptr : power_.data();
  p.force = force_.data();
  p.first = first, p.last = last;
  return kernels_->add_forces(p);
}

bool SpringLayout::find_snapped(std::span<const Vec3> x, const SpringArrays& s, JobPool* jobs) {
  blocks(jobs, slices(), kPackGrain, [&](std::uint32_t first, std::uint32_t last) {
    const auto count = static_cast<std::uint32_t>(x.size());
    for (std::uint32_t i = first * kLanes; i < std::min(last * kLanes, count); ++i) position_[i] = row_of(x[i]);
  });
  FEDER_ASSERT(snapped_.size() == (s.size() + kLanes - 1) / kLanes);  // built since springs were added
  std::atomic<unsigned> found{0};
  blocks(jobs, static_cast<std::uint32_t>(snapped_.size()), kSnapGrain, [&](std::uint32_t first, std::uint32_t last) {
    SnapPass p;
    p.position = &position_.data()->x;
    p.i = s.i.data(), p.j = s.j.data(), p.limit = s.limit.data();
    p.snapped = snapped_.data();
    p.count = s.size();
    p.first = first, p.last = last;
    if (const unsigned here = kernels_->find_snapped(p)) found.fetch_add(here, std::memory_order_relaxed);
  });
  return found.load(std::memory_order_relaxed) > 0;
}

}  // namespace feder
