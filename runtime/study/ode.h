// Problems of one point, x'' = f(x, v, t)/m with up to three coordinates (angles count as coordinates), run by every
// integrator. Private to the module.
#pragma once
#include "study/integrator_problem.h"

namespace feder {

// What a problem of this kind is; the field below gives it to the integrators.
class PointEquation {
 public:
  virtual ~PointEquation() = default;
  Real mass = 1;
  bool damped = false;         // f depends on v
  double rate = 0, decay = 0;  // bounds of frequencies and decay rates, 1/s
  virtual Vec3 force(const Vec3& x, const Vec3& v, double t) const = 0;
  // df/dx and df/dv as they are; the field drops what is not symmetric negative semidefinite.
  virtual Mat3 stiffness(const Vec3&, const Vec3&, double) const { return Mat3::Zero(); }
  virtual Mat3 damping(const Vec3&, const Vec3&, double) const { return Mat3::Zero(); }
  virtual Invariants invariants(const Vec3&, const Vec3&) const { return {}; }
  // What the errors are measured on, given the state; positions and velocities as they are unless said otherwise.
  virtual void observe(const Vec3& x, const Vec3& v, double t, Observation& out) const;

 protected:
  // A matrix of one coordinate.
  static Mat3 along_x(Real a) {
    Mat3 m = Mat3::Zero();
    m(0, 0) = a;
    return m;
  }
};

class PointField final : public ForceField {
 public:
  explicit PointField(const PointEquation& e) : equation_(e), mass_(e.mass), inv_mass_(1 / e.mass) {}
  std::size_t count() const override { return 1; }
  std::span<const Real> inv_mass() const override { return {&inv_mass_, 1}; }
  std::span<const Real> mass() const override { return {&mass_, 1}; }
  void eval(std::span<const Vec3> x, std::span<const Vec3> v, double t, std::span<Vec3> force) override {
    force[0] = equation_.force(x[0], v[0], t);
  }
  bool damped() const override { return equation_.damped; }
  bool stiff_damping(Real h) const override;
  void damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) override;
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) override;
  void pattern(std::vector<BlockIndex>&) const override {}
  std::uint64_t pattern_version() const override { return 1; }
  std::span<Vec3> position_low() override { return {&low_, 1}; }

 private:
  const PointEquation& equation_;
  Real mass_, inv_mass_;
  Vec3 low_ = Vec3::Zero();
};

class OdeProblem : public IntegratorProblem {
 public:
  OdeProblem() : IntegratorProblem("ode", 32, 1e-12) {}
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;
  // Unless said otherwise by extrapolation, see below.
  void reference(double t, Observation& out) const override;

 protected:
  // y' = rhs(t, y) in long double, y being the coordinates and then their rates.
  void use_extrapolation(OdeReference::Rhs rhs, std::vector<Wide> start);

  std::unique_ptr<PointEquation> equation_;
  Vec3 x0_ = Vec3::Zero(), v0_ = Vec3::Zero();

 private:
  std::unique_ptr<OdeReference> extrapolated_;
};

}  // namespace feder
