// Any world as a problem: a factory makes runs, the reference is the scene's own or the same run refined. What a run is
// made from (a Lua scene, an embedder's function) stays outside.
#pragma once
#include <functional>
#include <map>

#include "feder/study.h"
#include "feder/world.h"

namespace feder {

// Moving bodies and net points, in the order they were made.
void observe_world(World& world, Observation& out);

// One world in progress, made for a spec, and what its scene says of it.
class SceneWorld {
 public:
  virtual ~SceneWorld() = default;
  virtual World& world() = 0;
  virtual void step() = 0;  // the world's step and what the scene does after it
  virtual void observe(Observation& out) { observe_world(world(), out); }
  // What errors at the end are made of; of a refined run it is the reference that own_error() gets.
  virtual std::vector<double> measure() {
    Observation o;
    observe(o);
    return o.x;
  }
  // The scene's own error, asked once at t_end. `refined`: the measure of the refined run, where there is one.
  virtual double own_error(std::span<const double> /*refined*/) { return NAN; }
  virtual double event_error() { return NAN; }             // StudyRun::event_error
  virtual double constraint() { return NAN; }              // Invariants::constraint
  virtual double sweeps() const { return 1; }              // evaluations in one call of a pass
  virtual void reference(double /*t*/, Observation&) {}    // of Reference::course
  virtual double reference_energy(double) { return NAN; }  // J
};

// Rungs, all combinations of the values; what is empty stays as the scene has it.
struct SceneLadder {
  std::vector<std::string> methods;  // that climb it; empty: all
  std::vector<int> steps, substeps, iterations;
  std::vector<double> tolerances;
  std::vector<std::pair<std::string, std::vector<std::string>>> settings;  // name and values: other problems
  std::string refinement_axis;                                             // RunSpec::refinement_axis
};

struct SceneDescription {
  SceneDescription() { info.x_scale = info.v_scale = 0; }

  ProblemInfo info;                  // scales that are 0 or NaN are measured; of the reference what the scene says
  double dt = 1.0 / 60;              // the scene's own step, s
  std::vector<MethodInfo> methods;   // the first is the scene's own
  std::vector<SceneLadder> ladders;  // empty: steps about dt, from 2 dt to dt/8
  // What runs are compared with: themselves refined, values at t_end in the order of observe(), SceneWorld::reference()
  // at any time, or nothing but their own error.
  enum class Reference { refined, stated, course, none } reference = Reference::refined;
  std::vector<double> stated;
  int refined_substeps = 0;  // of the refined run, with the scene's own steps; 0: finer steps
  bool has_error = false;    // own_error() stands for the error at t_end
  double rounding = 1;       // by how much more than the rounding of the step alone
  std::function<std::unique_ptr<SceneWorld>(const RunSpec&)> make;
};

// A refined reference is a run with a step 64 times finer than the finest rung (at most kReferenceSteps in all), once
// by the first method and once by another one, or by itself twice as coarse: their difference is the uncertainty.
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
  using Reference = SceneDescription::Reference;
  struct Refined {
    std::vector<Observation> states;  // at equal distances, the start among them
    std::vector<double> energy;
    std::vector<double> measure;  // at the end
    double kinetic = 0;           // largest
    std::string failure;          // of the run, empty when it reached the end
  };
  Refined run_refined(const RunSpec& spec) const;
  const Refined& refined() const;
  void measure(const Refined& best, const Refined& other) const;
  void describe_reference();
  RunSpec own_spec() const;
  SceneWorld& referee() const;  // a world of the same settings at t = 0, which knows the reference

  SceneDescription scene_;
  mutable Settings settings_;
  mutable std::map<Settings, Refined> references_;
  mutable std::unique_ptr<SceneWorld> referee_;
  mutable Settings referee_settings_;
};

}  // namespace feder
