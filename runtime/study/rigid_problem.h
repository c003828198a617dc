// Problems of rigid bodies, run through a World by every rigid solver. Private to the module.
#pragma once
#include <array>

#include "rigid/rigid.h"
#include "study/options.h"
#include "world/world.h"

namespace feder {

// The first observed body around a step, in double.
struct BodyNow {
  double t = 0;
  std::array<double, 3> x{}, v{}, w{};  // centre of mass; w in world axes
};

class RigidProblem : public StudyProblem {
 public:
  RigidProblem() { info_.family = "rigid"; }
  std::vector<MethodInfo> methods() const override;
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;
  double reference_energy(double t) const override;

  // Fills the world; the bodies the errors are measured on go into `observed`.
  virtual void build(World& world, std::vector<ObjectId>& observed) const = 0;
  // Centres of mass and their velocities, and orientations where `orientations_` says so.
  virtual void observe(const Rigid& rigid, std::span<const ObjectId> observed, Observation& out) const;
  // What the step did to the event the problem is about: raises `error` (NaN at first), s.
  virtual void event(const BodyNow& /*before*/, const BodyNow& /*now*/, int& /*count*/, double& /*error*/) const {}
  // Largest violation now, by the size of what is violated. NaN: the deepest contact by `size_`.
  virtual double constraint(World& /*world*/) const { return NAN; }

  double gravity() const { return gravity_; }
  double size() const { return size_; }
  bool has_event() const { return has_event_; }

 protected:
  // A body with friction mu against ground of the same; the pair has mu.
  static BodyDesc body(ShapePtr shape, const Vec3& position, double mass, double friction);
  static BodyDesc ground(double friction, const Vec3& normal = Vec3(0, 1, 0));
  // One translating mass: kinetic and potential energy of the reference.
  double energy_of_point(double t, double mass) const;

  std::vector<int> steps_;
  int substeps_ = 4;
  double gravity_ = 9.81, size_ = 1, point_mass_ = 0;  // point_mass_ > 0: the reference's energy is that of a point
  bool has_event_ = false, orientations_ = false;
};

}  // namespace feder
