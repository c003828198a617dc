// Force fields of one point with known solutions, beside the springs of spring_field.h.
#pragma once
#include <cmath>

#include "integrate/integrator.h"

namespace feder::test {

// Undamped, mass 1, no neighbours.
class PointField : public ForceField {
 public:
  std::size_t count() const override { return 1; }
  std::span<const Real> inv_mass() const override { return {&one_, 1}; }
  std::span<const Real> mass() const override { return {&one_, 1}; }
  bool damped() const override { return false; }
  bool stiff_damping(Real) const override { return false; }
  void damping(std::span<const Vec3>, std::span<const Vec3>, double, BlockSparse& d) override { d.set_zero(); }
  void pattern(std::vector<BlockIndex>&) const override {}
  std::uint64_t pattern_version() const override { return 1; }

 private:
  Real one_ = 1;
};

// x'' = -x / |x|^3
class KeplerField final : public PointField {
 public:
  void eval(std::span<const Vec3> x, std::span<const Vec3>, double, std::span<Vec3> force) override {
    const Real r = length(x[0]);
    force[0] = -x[0] / (r * r * r);
  }
  // -1/r^3 (1 - 3 n n^T): the part along n pulls apart and is dropped
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) override {
    damping(x, v, t, d);
    const Vec3d a = x[0].cast<double>();
    const double r = a.norm();
    const Vec3d n = a / r;
    k.diagonal[0] = -(Mat3d::Identity() - n * n.transpose()) / (r * r * r);
  }
};

// theta'' = -sin theta, theta in x[0][0]
class PendulumField final : public PointField {
 public:
  void eval(std::span<const Vec3> x, std::span<const Vec3>, double, std::span<Vec3> force) override {
    force[0] = Vec3(-std::sin(x[0][0]), 0, 0);
  }
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) override {
    damping(x, v, t, d);
    k.set_zero();
    k.diagonal[0](0, 0) = -std::max(0.0, std::cos(static_cast<double>(x[0][0])));
  }
};

}  // namespace feder::test
