// Problems of the stability maps: a file stability_<name>.cpp defines `StabilityProblems <name>_stability()`, and a
// line of the module's table lists it. Private to the module.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "feder/net.h"
#include "feder/stability.h"
#include "feder/world.h"

namespace feder {

struct StabilityScene {
  NetDesc net;
  std::vector<std::size_t> pins;
  Vec3 gravity = Vec3::Zero();
  double h = 1.0 / 60;  // s
  int steps = 200;
  int judged_step = 200;         // where the error is taken
  double length = 1, speed = 1;  // m, m/s: size of the motion
  double energy = 1;             // J, scale
  double energy_zero = 0;        // J, added to the world's energy: the rest state then has none
  double frequency = NAN;        // rad/s, the fastest
  double damping_ratio = 0;      // of that
};

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
};

// Energies and displacements of a run, step by step, and what they amount to.
struct StabilityTrace {
  std::vector<double> energy, exact_energy;  // J, above rest; exact_energy empty: not known
  double moved = 0, reference_moved = 0;     // m, largest displacement of a point
};
Verdict judge(const StabilityTrace& trace, double length, double energy, const StabilityThresholds& limits,
              const StabilityCell& cell);

// A world of a map, for cells that are judged by its energy and by where it ends.
struct StabilityRun {
  World& world;
  double seconds = 0;
  double energy = 1;                                  // J, scale
  std::function<void()> look = [] {};                 // after each step
  std::function<bool()> left = [] { return false; };  // has something left the scene?
  std::function<double()> error = {};                 // at the end, by the scene's length; NaN: not judged
  bool overflows = false;                             // non-finite is its divergence, which was warned of
};
StabilityCell judge_run(const StabilityRun& run, double x, double y, const StabilityThresholds& limits);

using StabilityProblems = std::vector<std::unique_ptr<StabilityProblem>>;

}  // namespace feder
