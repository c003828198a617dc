// Problems of volumes and hierarchies: thin boxes at random, each drifting on its line, whose pairs are looked for in
// every step. What is measured is no error of a motion but of an answer: err_end is the share of what was found that
// does not touch, err_constraint the share of what touches that was missed (there must be none), force_evals are tests
// of volumes. The truth is that of the convex hulls, all pairs. Private to the module.
#pragma once
#include "bounds/volume.h"
#include "study/options.h"

namespace feder {

using ItemPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

class VolumeProblem : public StudyProblem {
 public:
  VolumeProblem() { info_.family = "collision", info_.own_measure = true, info_.dense = false; }
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  void reference(double t, Observation& out) const override;
  // Corners of all items at time t, eight each.
  void place(double t, std::vector<Vec3>& points) const;
  const ItemPairs& truth(double t) const;  // ascending
  std::size_t items() const { return centers_.size(); }

 protected:
  // Adds the options and makes the items.
  void set_items(ProblemOptions& o);
  std::string rung_name_;  // of the setting that the ladder varies
  std::vector<std::string> rungs_;

 private:
  std::vector<Vec3> centers_, velocities_;
  std::vector<Mat3> edges_;  // half of each, in columns
  mutable std::vector<std::pair<double, ItemPairs>> known_;
};

// Its steps: places the items, and has pairs found by find(items, out, tests).
class VolumeRun : public StudyRun {
 public:
  VolumeRun(const VolumeProblem& problem, int steps) : problem_(problem), h_(problem.info().t_end / steps) {}
  void step() override;
  void observe(Observation& out) override;
  Invariants invariants() override;
  StudyCounters counters() const override { return count_; }
  double own_error() const override;
  bool measures_itself() const override { return true; }

 protected:
  virtual void find(ItemPoints items, ItemPairs& out, std::int64_t& tests) = 0;

 private:
  const VolumeProblem& problem_;
  double h_, t_ = 0;
  std::vector<Vec3> points_;
  ItemPairs found_;
  StudyCounters count_;
  std::int64_t tests_ = 0;
  std::size_t in_all_ = 0;
  std::vector<std::pair<double, std::size_t>> counts_;
};

}  // namespace feder
