// Stability maps: a method on a problem over two axes, a verdict for each cell, and the boundary found by bisection
// beside the one that theory predicts. Plain data for tables and drawings; NaN stands for "does not apply". In the
// library feder::study; runs on the calling thread.
#pragma once
#include <atomic>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace feder {

// Worst first: of several that apply, the first is the verdict.
enum class Verdict : std::uint8_t {
  nan,         // a state went non-finite (an explicit method's overflow within one step counts as diverged)
  diverged,    // left the scene, or has energy out of nothing
  growing,     // energy rises slowly
  stuck,       // does not move although it should: too few iterations give this
  damped,      // lost energy that the model keeps
  inaccurate,  // bounded, and wrong
  slow,        // solves missed their tolerance
  refused,     // input rejected with a message: right for malformed input
  stable,      // none of the above
};
const char* name_of(Verdict v);

struct StabilityThresholds {
  double far = 1e6;            // diverged: |x| by the scene's length
  double fast = 1e3;           // diverged: |v| by the reference's largest speed
  double energy = 1e3;         // diverged: energy gained, by the energy scale
  double growth = 1.5;         // growing: largest energy of the last quarter by that of the second
  double growth_start = 1.05;  // growing: and by the energy at the start
  double moves = 0.1;          // stuck: the reference moves that share of the scene's length ...
  double stuck = 0.2;          // ... and the run less than this share of that
  double damped = 0.1;         // damped: energy lost beyond the model's losses, by the energy scale
  double inaccurate = 0.1;     // inaccurate: error at the end, by the scene's length
  double constraint = 0.01;    // inaccurate: largest violation
  double penetration = 0.05;   // inaccurate: deepest contact at the end, by the size of the smallest body
  double slow = 0.01;          // slow: share of steps that missed the tolerance
};

struct StabilityAxis {
  std::string name;   // as in JSON: "kh2m", "zeta", "ratio", "links"
  std::string label;  // for drawings: "k h^2/m"
  std::string unit;   // "" = pure number
  bool logarithmic = true;
  std::vector<double> values;
  std::vector<double> core = {};  // those of the suite `core`; empty: every other value
};

struct StabilityCell {
  double x = NAN, y = NAN;  // on the map's axes
  Verdict verdict = Verdict::stable;
  double t_fail = NAN;                       // s, when nan or diverged was seen
  std::string entity;                        // what failed: "net 'chain', point 7"; the message where refused
  double error = NAN;                        // at the end, by the scene's length
  double energy_ratio = NAN;                 // largest energy of the run by the energy scale
  double constraint = NAN;                   // largest violation (stretch of springs that should hold)
  double iters_mean = NAN, iters_max = NAN;  // linear solves per step
  double missed = 0;                         // share of steps with a solve that missed its tolerance
};

// The step (as a value of the x axis) from which on a row of the map is unstable. Infinity: none.
struct StabilityLimit {
  double y = NAN;
  double predicted = NAN;                      // theory; NaN: none known
  double observed = NAN;                       // bisected
  double z_predicted = NAN, z_observed = NAN;  // the same as h times the fastest angular frequency
  double relative() const { return std::fabs(observed - predicted) / predicted; }
};

struct StabilityMap {
  std::string problem, method;
  int order = 0;
  bool implicit = false;
  StabilityAxis x, y;
  std::vector<StabilityCell> cells;    // by y, then x
  std::vector<StabilityLimit> limits;  // by y; empty unless bisected
  double stable_share = NAN;           // of the cells
  std::string limit_how;               // how `observed` was found, one sentence
};

struct StabilityPlan {
  std::string problem = "oscillator";
  std::vector<std::string> methods;  // empty: all
  bool cells = true, bisect = false;
  StabilityThresholds thresholds;
  std::vector<double> x_values, y_values;  // empty: the problem's ladders
  // Set by others, may be null: the cells and limits that are finished are returned.
  const std::atomic<bool>* stop = nullptr;
  bool stopped() const { return stop && *stop; }
};

struct StabilityResult {
  StabilityThresholds thresholds;
  std::vector<StabilityMap> maps;  // by method
  std::string real;                // "float" or "double"
  bool interrupted = false;        // StabilityPlan::stop: there would have been more
};

struct StabilityProblemInfo {
  std::string name, summary;
  StabilityAxis x, y;
  bool bisects = false;        // limits are known and can be bisected
  std::string family = "net";  // run by integrators; "rigid", "cloth", "fluid": by their solvers
};
std::vector<StabilityProblemInfo> stability_problem_infos();

// SceneError names what is unknown. Deterministic.
StabilityResult run_stability(const StabilityPlan& plan);

}  // namespace feder
