// What a study hands out: plain data for tables, drawings and gates. NaN (or -1 in counts) stands for "does not apply";
// fields are named like the columns of points.csv.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace feder {

struct ProblemParam {
  std::string name, value, fallback, help;  // numbers print with the shortest digits that read back
  double lo = NAN, hi = NAN;                // range of numbers; NaN: none
  std::vector<std::string> choices;
};

enum class ReferenceKind : std::uint8_t { closed, quad, published, self };
const char* name_of(ReferenceKind kind);  // "closed", "quad" ...

struct ReferenceInfo {
  ReferenceKind kind = ReferenceKind::closed;
  int digits = 15;         // correct decimal digits
  double uncertainty = 0;  // of err_end: of the reference itself
  double rounding = 0;     // of err_end: what one rounding of the step size or of a force to Real does by t_end
  std::string source;      // formula, paper, or how it was computed
  double resolution = 0;   // of err_end: what the spacing of particles leaves, however short the steps; 0: nothing
  // Below this an error says nothing about the method.
  double floor() const { return 3 * (uncertainty > rounding ? uncertainty : rounding); }
};

struct ProblemInfo {
  std::string name, summary;
  std::string family;  // "ode", "net", "rigid", "scene"
  std::vector<ProblemParam> params;
  double t_end = 1;                 // s
  int dof = 1;                      // degrees of freedom
  double x_scale = 1, v_scale = 1;  // what errors are divided by
  double energy_scale = NAN;        // J: max(|E0|, peak kinetic energy of the reference)
  double energy_start = NAN;        // J
  double frequency = 0;             // fastest angular frequency, 1/s; 0: not known
  bool chaotic = false;             // err_horizon_s counts instead of err_end
  bool conserves_momentum = false, conserves_angular = false;
  bool own_measure = false;  // err_end is the problem's own measure, told in the reference's source
  int threads = 1;           // that worlds of the problem step with
  bool dense = true;         // false: errors along the run are taken at the steps, not interpolated between
  ReferenceInfo reference;
};

struct MethodInfo {
  std::string name, summary;
  int order = 0;  // 0: no order is claimed
  int evals_per_step = 1;
  double limit_hw = NAN;  // h*omega on the undamped oscillator; infinity: always stable; NaN: not known
  bool implicit = false, adaptive = false;
};

struct StudyCounters {
  std::int64_t steps = 0, rejected = 0;  // steps taken, inner ones of adaptive methods included
  std::int64_t force_evals = 0, jac_evals = 0, linear_solves = 0, cg_iters = 0;
  std::int64_t sweeps = 0;       // of contact solvers
  std::int64_t unconverged = 0;  // solves that ended at their cap
};

// ok and slow points reach t_end. diverged ones may: then their errors are there to see.
enum class PointStatus : std::uint8_t { ok, diverged, nan, refused, slow };
const char* name_of(PointStatus status);

using Settings = std::vector<std::pair<std::string, std::string>>;

struct StudyPoint {
  std::size_t index = 0;  // in the whole plan, whatever shard ran it
  std::string method;
  int order = 0;
  // rung
  double h_s = 0, tol = NAN;  // step asked for; tolerance of adaptive methods
  int iters = -1, substeps = -1;
  Settings settings;    // scene parameters of this rung
  std::string way;      // RunSpec::way
  std::string machine;  // processor that ran it; shards of one study may have different ones
  // outcome
  PointStatus status = PointStatus::ok;
  double status_t_s = NAN;   // when it went wrong
  std::string reason;        // in words, with what the run warned of; empty when ok and not warned
  bool completed = false;    // reached t_end
  bool below_floor = false;  // err_end is below the floor: no fits, no fronts beyond it
  double noise = NAN;        // of positions, scaled: what rounding did to this run, from its twin; NaN: not known
  double floor(const ReferenceInfo& r) const { return noise > 0 ? std::max(r.floor(), 3 * noise) : r.floor(); }
  StudyCounters count;
  double work = NAN;   // in force evaluations, see WorkWeights
  double instr = NAN;  // instructions, when somebody counted
  // timing pass
  double t_min_s = NAN, t_med_s = NAN, t_p90_s = NAN, rtf = NAN;  // rtf: simulated by real time
  int n_rep = 0;
  bool noisy = false;  // median / minimum above 1.15
  // error pass
  double err_end = NAN, err_end_v = NAN;          // positions, velocities at t_end; rms over points, scaled
  double err_traj_rms = NAN, err_traj_max = NAN;  // positions over the 257 times
  double err_orient_rad = NAN;                    // largest angle at t_end
  double err_energy_max = NAN, err_energy_drift_per_s = NAN;
  double err_mom = NAN, err_angmom = NAN, err_constraint = NAN, err_event_s = NAN;
  double err_horizon_s = NAN;  // first time the trajectory error exceeds 1e-3; t_end: never
  double mescd = NAN;          // correct digits of the worst component
  std::int64_t peak_bytes = -1;
  bool on_front_time = false, on_front_work = false;
};

// Force evaluations one Jacobian, one step of conjugate gradient, one direct solve count as.
struct WorkWeights {
  double jacobian = 2, cg_iteration = 1, direct_solve = 4;
};

// Order (error against step) or exponent (error against tolerance) by least squares in log-log.
struct OrderFit {
  std::string method, axis;  // "h", "tol", "substeps", "iters"
  double slope = NAN, expected = NAN, rms = NAN;
  double lo = NAN, hi = NAN;  // range of the axis used
  int points = 0;
  Settings settings;     // of a scene; orders are fitted for each
  std::string way = {};  // of the points, likewise
  // Does a step's order miss theory? Then rounding, resonance or too coarse rungs speak, not the method.
  bool off() const { return axis == "h" && std::fabs(slope - expected) > kOrderMargin; }
  static constexpr double kOrderMargin = 0.25;
};

// Cheapest way of one method to an error, log-log between two of its own points, never beyond them. Settings of a scene
// are not the method's choice: it has to get there with each of them, and the dearest is named.
struct CostToAccuracy {
  double target = 0;
  std::string method;
  double h_s = NAN, tol = NAN, force_evals = NAN, work = NAN, time_s = NAN;
  bool cheapest_work = false, cheapest_time = false;  // among the methods
};

// A run at the 257 times.
struct StudySeries {
  std::size_t point = 0;                                 // StudyPoint::index
  std::vector<double> t, err, energy, momentum, angmom;  // err scaled; the others relative to their scale and start
};

// What all points of a study have in common besides the problem: reports of shards go together when this is equal.
struct Provenance {
  std::string overrides;        // --set, --world, --dt, --seed, --budget as given: "stiffness=2; dt=1/30"
  std::string real, git, tool;  // float or double; commit; program and version
  std::string build;            // compiler and flags
  std::string scene_hash;       // of the scene's file; empty for built-in problems
  std::string plan_hash;        // of all points planned: methods, rungs, settings
};

struct StudyResult {
  ProblemInfo problem;
  std::vector<MethodInfo> methods;
  std::size_t planned = 0;  // points of the whole plan
  int shard = 0, shards = 1;
  Provenance provenance;
  WorkWeights weights;
  std::vector<StudyPoint> points;  // by index
  std::vector<StudySeries> series;
  // made by evaluate()
  std::vector<OrderFit> fits;
  std::vector<std::size_t> front_time, front_work;  // places in `points`, by cost
  std::vector<CostToAccuracy> cost_to_accuracy;
};

}  // namespace feder
