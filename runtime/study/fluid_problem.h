// Problems of fluids, run through a World by every particle solver. A problem has its own measure of error (pressure,
// front, draught, profile, period), which stands for err_end. Private to the module.
#pragma once
#include "fluid/fluid.h"
#include "study/options.h"
#include "world/world.h"

namespace feder {

// What a running problem looks at.
struct FluidScene {
  World* world = nullptr;
  Fluid* fluid = nullptr;
  ObjectId water, body;
  std::vector<Vec3> positions, velocities;  // of the particles now
  double spacing = 0.05;                    // m
  double start = 0;                         // a measure as it is when the particles are in place
  std::vector<double> kept;                 // by the problem, over the steps
};

class FluidProblem : public StudyProblem {
 public:
  FluidProblem() {
    info_.family = "fluid";
    info_.dense = false;
    info_.own_measure = true;
  }
  std::vector<MethodInfo> methods() const override;
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;

  // Fills the world; `desc` has solver, spacing and what the spec says already.
  virtual void build(FluidScene& s, FluidDesc desc) const = 0;
  virtual void observe(const FluidScene& s, Observation& out) const = 0;
  virtual double start_measure(const FluidScene&) const { return 0; }  // FluidScene::start
  virtual void after_step(FluidScene&) const {}
  virtual double error(FluidScene& s) const = 0;  // at t_end
  virtual Vec3 gravity() const { return Vec3(0, static_cast<Real>(-kGravity), 0); }

  static constexpr double kGravity = 9.81;  // m/s^2

 protected:
  // The parameters all problems have; `per_length` particles along the length the problem is about.
  void common(ProblemOptions& o, int per_length, double t_end);
  // `uncertainty`: of the reference; `spacings`: that the measure is off whatever the steps.
  void scales(double length, double speed, ReferenceKind kind, double uncertainty, double spacings, const char* source);
  static void add_wall(World& w, const Vec3& normal, double distance);
  // A block of the fluid's lattice from `from`, flat in z.
  static void add_water(FluidScene& s, double width, double height, double x, double y);

  friend class FluidRun;
  double spacing_ = 0.05;      // m
  double stiffness_ = 0;       // bulk modulus, Pa; 0: as stiff as the solver can
  double compression_ = 0.01;  // that solvers without iterations aim at
  int rate_ = 60;              // steps a second of the ladder
};

}  // namespace feder
