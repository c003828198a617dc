// Time integrators for x'' = f(x, v, t)/m. The integrator drives: it asks for forces as often as it wants.
// One file per method, one feder_variant(integrate <method>) line. Contract, checked for every row by the tests in
// tests/integrate: convergence order, stability limits h*w on the oscillator, momentum of free systems, pinned points
// stay, no allocation after the first step of a size. What a method remembers from step to step is in `memory` and
// nowhere else: with it saved and loaded the run goes on bit for bit, and a state written from outside (by a contact, a
// script) is noticed and continues like a fresh start. Most remember nothing.
#pragma once
#include <span>

#include "base/compensated.h"
#include "base/jobs.h"
#include "base/registry.h"
#include "feder/integrator.h"
#include "feder/memory.h"
#include "feder/params.h"
#include "feder/types.h"
#include "linear/block_sparse.h"

namespace feder {

// Second-order system over `count` points; implemented by owners (springs).
class ForceField {
 public:
  virtual ~ForceField() = default;
  virtual std::size_t count() const = 0;
  virtual std::span<const Real> inv_mass() const = 0;  // 0 = pinned: neither x nor v change
  virtual std::span<const Real> mass() const = 0;
  // f(x, v, t), N. Replaces `force`.
  virtual void eval(std::span<const Vec3> x, std::span<const Vec3> v, double t, std::span<Vec3> force) = 0;
  // Does f depend on v?
  virtual bool damped() const = 0;
  // May a step of h with explicit damping be unstable? False where (h w)^2 + 2 h g <= 4 holds for upper bounds of the
  // frequencies w and decay rates g; then methods need not solve for the damping.
  virtual bool stiff_damping(Real h) const = 0;
  // D = df/dv as symmetric negative semidefinite 3x3 blocks. Fills it (its pattern is set).
  virtual void damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) = 0;
  // K = df/dx and D = df/dv likewise, for implicit methods: negative semidefinite, the other part is dropped.
  virtual void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) = 0;
  virtual void pattern(std::vector<BlockIndex>& blocks) const = 0;  // off-diagonal blocks (i < j)
  virtual std::uint64_t pattern_version() const = 0;                // changes when the pattern does
  // The low parts of the positions, m: state beside x, zero at first, that integrators keep (base/compensated.h).
  // Empty: the owner has none, and positions are what x holds.
  virtual std::span<Vec3> position_low() { return {}; }
  // Threads for loops over points (for_points below); null: there are none to share.
  virtual JobPool* jobs() const { return nullptr; }
};

// body(first, last) for runs of points that cover [0, count), on the field's threads. Points must not see each other.
template <class Body>
void for_points(const ForceField& field, std::size_t count, Body&& body) {
  constexpr JobGrain kGrain{1024, 4'000};
  const auto n = static_cast<std::uint32_t>(count);
  if (JobPool* jobs = field.jobs())
    jobs->for_blocks(n, kGrain, [&](std::uint32_t first, std::uint32_t last, int) { body(first, last); });
  else
    body(std::uint32_t{0}, n);
}

// x += h v for the free points, compensated.
inline void drift(const ForceField& field, Real h, std::span<const Vec3> v, std::span<Vec3> x, std::span<Vec3> low) {
  const Real* const inv_mass = field.inv_mass().data();
  for_points(field, x.size(), [&](std::uint32_t first, std::uint32_t last) {
    std::uint32_t i = first;
    const auto one = [&] {
      if (inv_mass[i] != 0) add_compensated(x[i], low[i], h * v[i]);
      ++i;
    };
    while (i + 4 <= last) {
      const Real* const m = inv_mass + i;
      if ((m[0] != 0) & (m[1] != 0) & (m[2] != 0) & (m[3] != 0)) {
        add_compensated<12>(x[i].data(), low[i].data(), v[i].data(), h);
        i += 4;
      } else {
        for (int k = 0; k < 4; ++k) one();
      }
    }
    while (i < last) one();
  });
}

// State of a multi-step method as plain data: part of snapshots and of the state hash. Empty for one-step methods.
struct IntegratorMemory {
  explicit IntegratorMemory(Arena& a) : points(&a), numbers(&a) {}
  Array<Vec3> points;
  Array<double> numbers;
};

// No allocation after the first step of a size.
class Integrator {
 public:
  explicit Integrator(Arena& a) : memory(a), low_(&a) {}
  virtual ~Integrator() = default;
  virtual IntegratorInfo info() const = 0;
  // Advances x and v by h from time t, in place.
  virtual void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) = 0;
  IntegratorStats stats;
  IntegratorMemory memory;

 protected:
  // The field's low parts of positions; zeros where it has none.
  std::span<Vec3> low_of(ForceField& field) {
    const std::span<Vec3> own = field.position_low();
    if (!own.empty()) return own;
    low_.assign(field.count(), Vec3(0, 0, 0));
    return low_;
  }

 private:
  Array<Vec3> low_;
};

std::span<const Variant<Integrator>> integrators();

}  // namespace feder
