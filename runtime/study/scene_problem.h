// Any world as a problem: a factory makes runs, the reference is the same run refined. What a run is made from (a Lua
// scene, an embedder's function) stays outside.
#pragma once
#include <functional>
#include <map>

#include "study/problem.h"
#include "world/world.h"

namespace feder {

// One world in progress, made for a spec.
class SceneWorld {
 public:
  virtual ~SceneWorld() = default;
  virtual World& world() = 0;
  virtual void step() = 0;                    // the world's step and what the scene does after it
  virtual double own_error() { return NAN; }  // the scene's own measure, asked once at t_end
};

struct SceneDescription {
  std::string name, summary;
  double t_end = 1;
  double dt = 1.0 / 60;              // the scene's own step, s
  int threads = 1;                   // worker threads of its world
  std::vector<MethodInfo> methods;   // the first is the scene's own
  std::vector<int> steps;            // of the ladder; empty: about dt, from 2 dt to dt/8
  std::vector<int> substeps;         // likewise; empty: the scene's own
  std::vector<ProblemParam> params;  // values for listings
  // Every combination is run: name and values.
  std::vector<std::pair<std::string, std::vector<std::string>>> axes;
  bool has_error = false;    // own_error() is the error: nothing is refined
  std::string error_source;  // in words, for has_error
  // Observed points to be at t_end, in the order of observe_world(); empty: refined.
  std::vector<double> reference;
  std::function<std::unique_ptr<SceneWorld>(const RunSpec&)> make;
};

// Moving bodies and net points, in the order they were made.
void observe_world(World& world, Observation& out);

// The reference is a run with a step 64 times finer than the finest rung (at most kReferenceSteps in all), once by
// the first method and once by another one, or by itself twice as coarse: their difference is the uncertainty.
class SceneProblem final : public StudyProblem {
 public:
  static constexpr int kReferenceSteps = 200000;
  explicit SceneProblem(SceneDescription description);
  std::vector<MethodInfo> methods() const override { return scene_.methods; }
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  // The reference is that of the settings of the last run started.
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;
  void reference(double t, Observation& out) const override;
  double reference_energy(double t) const override;

 private:
  struct Refined {
    std::vector<Observation> states;  // at the 257 times
    std::vector<double> energy;
    double kinetic = 0;   // largest
    std::string failure;  // of the run, empty when it reached the end
  };
  Refined run_refined(const std::string& method, int steps, const Settings& settings) const;
  const Refined& refined() const;
  void measure(const Refined& best, const Refined& other, int factor) const;

  SceneDescription scene_;
  mutable Settings settings_;
  mutable std::map<Settings, Refined> references_;
};

}  // namespace feder
