// Problems of one point, x'' = f(x, v, t)/m with up to three coordinates (angles count as coordinates), run by every
// integrator. Private to the module.
#pragma once
#include "base/rng.h"
#include "integrate/integrator.h"
#include "study/options.h"

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
  virtual Mat3 stiffness(const Vec3& x, const Vec3& v, double t) const = 0;
  virtual Mat3 damping(const Vec3& x, const Vec3& v, double t) const = 0;
  virtual Invariants invariants(const Vec3& x, const Vec3& v) const = 0;
  // What the errors are measured on, given the state; positions and velocities as they are unless said otherwise.
  virtual void observe(const Vec3& x, const Vec3& v, double t, Observation& out) const;
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

class OdeProblem : public StudyProblem {
 public:
  OdeProblem() { info_.family = "ode"; }
  std::vector<MethodInfo> methods() const override;
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;
  bool has_twins() const override { return true; }

 protected:
  std::unique_ptr<PointEquation> equation_;
  Vec3 x0_ = Vec3::Zero(), v0_ = Vec3::Zero();
  std::vector<int> steps_;    // of the ladder, coarse to fine
  int tolerance_steps_ = 32;  // calls adaptive methods get
};

// first, 2 first, 4 first ... `rungs` of them.
std::vector<int> doubling(int first, int rungs);

// One to four last places away, in each coordinate that is not 0.
Vec3 nearby(const Vec3& x, Rng& rng);

// All integrators, as a study sees them.
std::vector<MethodInfo> integrator_methods();
std::unique_ptr<Integrator> make_integrator(Arena& arena, const RunSpec& spec);
StudyCounters counters_of(const IntegratorStats& stats, bool adaptive, std::int64_t steps);

}  // namespace feder
