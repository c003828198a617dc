// Problems of cloth, run through a World by every cloth solver. Of those at rest the start is the equilibrium of the
// vertices themselves (no mesh error is in it), so what a run departs from it is the solver's. Private to the module.
#pragma once
#include "cloth/cloth.h"
#include "study/options.h"
#include "world/world.h"

namespace feder {

class ClothProblem : public StudyProblem {
 public:
  ClothProblem() { info_.family = "cloth"; }
  std::vector<MethodInfo> methods() const override;
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;
  void reference(double t, Observation& out) const override;

  virtual void add_bodies(World&) const {}
  virtual void observe(const Cloth& cloth, ObjectId id, Observation& out) const;  // all vertices
  // A measure of its own at t_end, from what was observed after each step; NaN: none.
  virtual double own_error(const std::vector<double>& /*heights*/) const { return NAN; }

  const ClothDesc& desc() const { return desc_; }
  const std::vector<double>& rest() const { return rest_; }
  const std::vector<double>& pull() const { return pull_; }
  static constexpr double kGravity = 9.81;  // m/s^2
  static constexpr double kRate = 60;       // steps a second, in the middle of the ladder

 protected:
  // Once desc_, rest_ and substeps_ stand: scales, energy, reference.
  void measure(double length, const char* source);

  ClothDesc desc_;
  std::vector<double> rest_;  // three per vertex, m; empty: as the desc says, and the energy is not kept
  std::vector<double> pull_;  // force of a script on each vertex, downwards, N; empty: none
  std::vector<int>
      substeps_;  // of the world, 60 steps a second: one small step each (mass_spring: as many as it needs)
};

}  // namespace feder
