// Problems of the stability maps: a file stability_<name>.cpp defines `StabilityProblems <name>_stability()`, and a
// line of the module's table lists it. Private to the module.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "feder/net.h"
#include "feder/study.h"
#include "study/worlds.h"

namespace feder {

struct StabilityScene {
  NetDesc net;
  std::vector<std::size_t> pins;
  Vec3 gravity = Vec3::Zero();
  double h = 1.0 / 60;  // s
  int substeps = 1;
  int steps = 200;
  int error_step = 200;          // where the error is taken
  double length = 1, speed = 1;  // m, m/s: size of the motion
  double energy = 1;             // J, scale
  double energy_zero = 0;        // J, added to the world's energy: the rest state then has none
  double frequency = NAN;        // rad/s, the fastest
  double damping_ratio = 0;      // of that
};

inline WorldDesc net_world(const StabilityScene& scene) {
  WorldDesc d = awake_world(0, scene.h, scene.substeps);
  d.gravity = scene.gravity;
  return d;
}

struct StabilityMethod {
  std::string name;
  int order = 0;
  bool implicit = false;
};

// A table of cells. Nets are run by integrators, others by the solvers of their systems.
class StabilityProblem {
 public:
  virtual ~StabilityProblem() = default;
  virtual StabilityProblemInfo info() const = 0;
  virtual std::vector<StabilityMethod> methods() const = 0;
  virtual StabilityCell cell(const std::string& method, double x, double y,
                             const StabilityThresholds& limits) const = 0;
  // Only where info().bisects.
  virtual StabilityLimit limit(const std::string& /*method*/, double /*y*/) const { return {}; }
  virtual std::string limit_how() const { return ""; }
};

// A map's cell at (x, y), filled by `run`; refused where that throws a SceneError.
template <class Run>
StabilityCell checked_cell(double x, double y, Run&& run) {
  StabilityCell cell;
  cell.x = x, cell.y = y;
  try {
    run(cell);
  } catch (const SceneError& e) {
    cell.verdict = Verdict::refused;
    cell.entity = e.what();
  }
  return cell;
}

// What failed in the step just taken: as the warning of a non-finite state names it, or else `object`.
std::string failed_entity(World& w, std::string object);

using StabilityProblems = std::vector<std::unique_ptr<StabilityProblem>>;

// A map whose cells a function of the method and of the values on both axes fills.
using StabilityCells =
    std::function<StabilityCell(const std::string& method, double x, double y, const StabilityThresholds& limits)>;
std::unique_ptr<StabilityProblem> stability_table(const char* family, StabilityProblemInfo info,
                                                  std::vector<StabilityMethod> methods, StabilityCells cells);

// The rows of a table of solvers as methods.
template <class Solver>
std::vector<StabilityMethod> solver_methods(std::span<const Variant<Solver>> solvers) {
  std::vector<StabilityMethod> all;
  for (const Variant<Solver>& row : solvers) all.push_back({row.name});
  return all;
}

// 10^lo to 10^hi, values of an axis.
std::vector<double> decades(double lo, double hi, int per_decade = 1);

class NetStability : public StabilityProblem {
 public:
  std::vector<StabilityMethod> methods() const override;
  StabilityCell cell(const std::string& method, double x, double y, const StabilityThresholds& limits) const override;
  StabilityLimit limit(const std::string& method, double y) const override;
  std::string limit_how() const override;

  // For a cell of the map; for_limit: linear, around the origin, started on the fastest mode with amplitude 1.
  virtual StabilityScene scene(double x, double y, bool for_limit) const = 0;
  // Exact positions and energy (above rest) at t of the scene for (x, y). False: not known.
  virtual bool reference(double x, double y, double t, std::vector<Vec3d>& positions, double& energy) const = 0;
  // The x at which h times the fastest frequency is z. Only where limits are bisected.
  virtual double x_of(double z, double y) const = 0;
  // Is it one oscillator, so that the limit can be read off the matrix of a step?
  virtual bool single_oscillator() const { return false; }

 private:
  void run(const StabilityScene& scene, const std::string& method, const StabilityThresholds& limits,
           StabilityCell& cell) const;
};

// Energies and displacements of a run, step by step, and what they amount to.
struct StabilityTrace {
  std::vector<double> energy, exact_energy;             // J, above rest; exact_energy empty: not known
  double displacement = 0, reference_displacement = 0;  // m, the largest of a point
};
Verdict verdict_of(const StabilityTrace& trace, double length, double energy, const StabilityThresholds& limits,
                   const StabilityCell& cell);

// A world of a map whose verdict follows from its energy and from where it ends.
struct StabilityRun {
  World& world;
  double seconds = 0;
  double energy = 1;                                  // J, scale
  std::function<void()> record = [] {};               // after each step
  std::function<bool()> left = [] { return false; };  // has something left the scene?
  std::function<double()> error = {};                 // at the end, by the scene's length; NaN: not known
  bool overflows = false;                             // non-finite is its divergence, which was warned of
};
StabilityCell run_cell(const StabilityRun& run, double x, double y, const StabilityThresholds& limits);

}  // namespace feder
