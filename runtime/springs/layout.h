// Layout of a net's springs in the order in which the kernels read them, and its points as rows of four. Follows from
// the spring arrays: built anew when the pattern changes, edited when a spring is removed. Private to the module.
#pragma once
#include <span>

#include "base/jobs.h"
#include "feder/error.h"
#include "feder/memory.h"
#include "feder/types.h"
#include "springs/spring_batch.h"

namespace feder {

struct SpringArrays;

class SpringLayout {
 public:
  explicit SpringLayout(Arena& a) : arena_(a) {}

  void choose(const SpringKernels& kernels) { kernels_ = &kernels; }
  // Allocates when springs or points outnumber every earlier call.
  void build(const SpringArrays& springs, std::uint32_t points);
  void remove(std::uint32_t k);  // the spring keeps its lanes, without stiffness and damping

  std::size_t spring_count() const { return lane_of_.size() / 2; }
  bool damped() const { return !damping_.empty(); }

  // force = outside(i) + spring forces; `jobs` may be null. Returns the number of spring ends without a direction.
  template <class Outside>
  unsigned eval(std::span<const Vec3> x, std::span<const Vec3> v, JobPool* jobs, Outside&& outside,
                std::span<Vec3> force);

  // True when springs are longer than the square root of their limit: snapped() has one bit each.
  bool find_snapped(std::span<const Vec3> x, const SpringArrays& springs, JobPool* jobs);
  std::span<const std::uint8_t> snapped() const { return snapped_; }

 private:
  struct alignas(4 * sizeof(Real)) PointRow {
    Real x = 0, y = 0, z = 0, unused = 0;
  };
  // slices of eight points per job, and groups of eight springs
  static constexpr JobGrain kPackGrain{32, 2'500}, kForceGrain{32, 15'000}, kSnapGrain{256, 4'000};

  std::uint32_t slices() const { return static_cast<std::uint32_t>(force_.size()); }
  static PointRow row_of(const Vec3& a) { return {a[0], a[1], a[2], 0}; }
  void pack(std::span<const Vec3> x, std::span<const Vec3> v, std::uint32_t first, std::uint32_t last);
  unsigned add_forces(std::uint32_t first, std::uint32_t last);
  void check_built(const SpringArrays& springs) const;  // validate.cpp

  template <class Body>
  static void blocks(JobPool* jobs, std::uint32_t count, JobGrain grain, Body&& body) {
    if (jobs)
      jobs->for_blocks(count, grain, [&](std::uint32_t first, std::uint32_t last, int) { body(first, last); });
    else if (count > 0)
      body(std::uint32_t{0}, count);
  }

  Arena& arena_;
  const SpringKernels* kernels_ = &kSpringKernelsPlain;
  Array<unsigned> row_begin_{&arena_};  // by slice of eight points, one more than slices
  Array<SpringRow> rows_{&arena_};
  Array<Lane8> damping_{&arena_}, slack_{&arena_}, power_{&arena_};  // by row; empty when no spring has such a thing
  Array<std::uint64_t> lane_of_{&arena_};  // by spring: row * 8 + lane of either end, two each
  Array<PointRow> position_{&arena_}, velocity_{&arena_};
  Array<Lane8x3> force_{&arena_};         // by slice
  Array<std::uint8_t> snapped_{&arena_};  // by group of eight springs
};

template <class Outside>
unsigned SpringLayout::eval(std::span<const Vec3> x, std::span<const Vec3> v, JobPool* jobs, Outside&& outside,
                            std::span<Vec3> force) {
  const auto count = static_cast<std::uint32_t>(x.size());
  FEDER_ASSERT(slices() == (count + kLanes - 1) / kLanes && force.size() == count);
  const auto end_of = [&](std::uint32_t slice) { return slice * kLanes < count ? slice * kLanes : count; };
  blocks(jobs, slices(), kPackGrain, [&](std::uint32_t first, std::uint32_t last) {
    pack(x, v, first * kLanes, end_of(last));
    for (std::uint32_t i = first * kLanes; i < end_of(last); ++i) {
      const Vec3 f = outside(i);
      Lane8x3& to = force_[i / kLanes];
      to.x.v[i % kLanes] = f[0], to.y.v[i % kLanes] = f[1], to.z.v[i % kLanes] = f[2];
    }
  });
  std::atomic<unsigned> found{0};
  blocks(jobs, slices(), kForceGrain, [&](std::uint32_t first, std::uint32_t last) {
    if (const unsigned here = add_forces(first, last)) found.fetch_add(here, std::memory_order_relaxed);
    for (std::uint32_t i = first * kLanes; i < end_of(last); ++i) {
      const Lane8x3& from = force_[i / kLanes];
      force[i] = Vec3(from.x.v[i % kLanes], from.y.v[i % kLanes], from.z.v[i % kLanes]);
    }
  });
  return found.load(std::memory_order_relaxed);
}

}  // namespace feder
