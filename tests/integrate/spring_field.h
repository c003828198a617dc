// A small naive force field for the integrator tests: springs between points, springs to the origin, gravity.
// Written apart from runtime/springs on purpose.
#pragma once
#include <cmath>
#include <vector>

#include "integrate/integrator.h"

namespace feder::test {

inline constexpr bool kFloat = sizeof(Real) == 4;

struct TestSpring {
  std::uint32_t i, j;  // j == kNone: to the origin
  Real stiffness, damping, rest_length;
};

class SpringField final : public ForceField {
 public:
  std::vector<Real> masses, inv_masses;
  std::vector<TestSpring> springs;
  Vec3 gravity = Vec3::Zero();

  std::uint32_t add_point(Real mass, bool pinned = false) {
    masses.push_back(mass);
    inv_masses.push_back(pinned ? Real(0) : 1 / mass);
    return static_cast<std::uint32_t>(masses.size() - 1);
  }

  std::size_t count() const override { return masses.size(); }
  std::span<const Real> inv_mass() const override { return inv_masses; }
  std::span<const Real> mass() const override { return masses; }

  void eval(std::span<const Vec3> x, std::span<const Vec3> v, double, std::span<Vec3> force) override {
    for (std::size_t i = 0; i < masses.size(); ++i) force[i] = masses[i] * gravity;
    for (const TestSpring& s : springs) {
      const Vec3 d = separation(s, x), u = separation(s, v);
      const Real len = length(d);
      if (len == 0) continue;
      const Vec3 n = d / len;
      const Vec3 f = n * (s.stiffness * (len - s.rest_length) + s.damping * dot(u, n));
      force[s.i] += f;
      if (s.j != kNone) force[s.j] -= f;
    }
  }
  bool damped() const override {
    for (const TestSpring& s : springs)
      if (s.damping != 0) return true;
    return false;
  }
  bool stiff_damping(Real h) const override {
    Real worst = 0;
    for (std::size_t i = 0; i < masses.size(); ++i) {
      Real stiff = 0, damp = 0;
      for (const TestSpring& s : springs)
        if (s.i == i || s.j == i) {
          const Real rows = s.j == kNone ? Real(1) : Real(2);
          stiff += rows * s.stiffness, damp += rows * s.damping;
        }
      worst = std::max(worst, (h * h * stiff + 2 * h * damp) * inv_masses[i]);
    }
    return worst > 4;
  }
  void damping(std::span<const Vec3> x, std::span<const Vec3>, double, BlockSparse& d) override {
    d.set_zero();
    for (std::size_t k = 0; k < springs.size(); ++k) {
      const Vec3d n = normalized_or(separation(springs[k], x), Vec3(1, 0, 0)).cast<double>().normalized();
      add(d, k, static_cast<double>(springs[k].damping) * n * n.transpose());
    }
  }
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) override {
    damping(x, v, t, d);
    k.set_zero();
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const Vec3d arm = separation(springs[s], x).cast<double>();
      const double len = arm.norm(), rest = springs[s].rest_length;
      const Vec3d n = len > 0 ? Vec3d(arm / len) : Vec3d(1, 0, 0);
      const double across = len > rest ? 1 - rest / len : 0;
      const Mat3d nn = n * n.transpose();
      const Mat3d block = static_cast<double>(springs[s].stiffness) * (nn + across * (Mat3d::Identity() - nn));
      add(k, s, block);
    }
  }
  void pattern(std::vector<BlockIndex>& blocks) const override {
    for (const TestSpring& s : springs)
      if (s.j != kNone) blocks.push_back({std::min(s.i, s.j), std::max(s.i, s.j)});
  }
  std::uint64_t pattern_version() const override { return springs.size(); }

 private:
  static Vec3 separation(const TestSpring& s, std::span<const Vec3> a) {
    return s.j == kNone ? Vec3(-a[s.i]) : Vec3(a[s.j] - a[s.i]);
  }
  // Springs to the origin come without an off-diagonal block.
  void add(BlockSparse& m, std::size_t spring, const Mat3d& block) const {
    const TestSpring& s = springs[spring];
    m.diagonal[s.i] -= block;
    if (s.j == kNone) return;
    m.diagonal[s.j] -= block;
    std::size_t at = 0;
    for (std::size_t k = 0; k < spring; ++k) at += springs[k].j != kNone;
    m.off[at] += block;
  }
};

// x'' = -stiffness x - damping x', mass 1, along the x axis.
inline SpringField oscillator(Real stiffness, Real damping = 0) {
  SpringField f;
  f.springs.push_back({f.add_point(1), kNone, stiffness, damping, 0});
  return f;
}

struct State {
  std::vector<Vec3> x, v;
};

inline void run(Integrator& method, ForceField& field, State& s, double t_end, int steps) {
  const double h = t_end / steps;
  for (int k = 0; k < steps; ++k) method.step(field, k * h, static_cast<Real>(h), s.x, s.v);
}

}  // namespace feder::test
