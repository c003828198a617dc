// Studies: problems with known ends, the methods that run them, and their error against run time. In the library
// feder::study. SceneError says what a plan or problem lacks. A study runs on the calling thread in worlds of its own;
// several may run at once, a problem in one of them.
#pragma once
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "feder/params.h"

namespace feder {

// What a study hands out: plain data for tables, drawings and gates. NaN (or -1 in counts) stands for "does not apply";
// fields are named like the columns of points.csv.
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
  bool own_measure = false;  // err_end is the problem's own measure, described in the reference's source
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
  Settings settings;            // scene parameters of this rung
  std::string refinement_axis;  // RunSpec::refinement_axis
  std::string machine;          // processor that ran it; shards of one study may have different ones
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
  Settings settings;                 // of a scene; orders are fitted for each
  std::string refinement_axis = {};  // of the points, likewise
  // Does a step's order miss theory? Then rounding, resonance or too coarse rungs speak, not the method.
  bool off() const { return axis == "h" && std::fabs(slope - expected) > kOrderMargin; }
  static constexpr double kOrderMargin = 0.25;
};

// Least cost of an error with one method, log-log between two of its own points, never beyond them. Settings of a scene
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
  bool interrupted = false;        // RunLimits::stop: points are missing, or were timed less often
  std::vector<StudyPoint> points;  // by index
  std::vector<StudySeries> series;
  // made by evaluate()
  std::vector<OrderFit> fits;
  std::vector<std::size_t> front_time, front_work;  // indices in `points`, by cost
  std::vector<CostToAccuracy> cost_to_accuracy;
};

// Problems of a study: a start, methods that can run it, and a reference the runs are measured against. One file per
// family, one feder_variant(study <problem>) line. Contract, checked for every row by
// tests/study/test_problem_contract.cpp: each method starts at the reference's start, a refined run comes closer to the
// reference, equal specs give equal bits, parameters refuse values out of range.
// Errors along a run are measured at these many equidistant times, 0 and t_end among them.
inline constexpr int kStudySamples = 257;

// The observed part of a state, in double whatever Real is: what the error norms compare.
struct Observation {
  std::vector<double> x, v;  // three numbers per observed point, in the problem's units of length
  std::vector<double> q;     // orientations of observed bodies, x y z w; may be empty
};

// What should be conserved, or held. NaN: the problem has no such thing.
struct Invariants {
  double energy = NAN;                   // J, kinetic, potential and elastic
  double momentum[3] = {NAN, NAN, NAN};  // kg m/s
  double angular[3] = {NAN, NAN, NAN};   // kg m^2/s, components that are conserved; others 0
  double momentum_scale = NAN;           // sum of m |v|
  double angular_scale = NAN;            // sum of m |r| |v|
  double constraint = NAN;               // largest violation or penetration, by the size of what is violated
};

// How to run a problem: a method and a rung of its ladder.
struct RunSpec {
  std::string method;
  int steps = 0;         // of t_end / steps each; adaptive methods divide them further
  double tolerance = 0;  // adaptive methods, and fluids: the compression aimed at; 0: their default
  int iterations = 0;    // of the solver; 0: its default
  int substeps = 0;      // of worlds; 0: the problem's default
  Settings settings;
  // What this part of a ladder refines: "substeps", "steps" ...; empty: it has one part.
  std::string refinement_axis = {};
  bool twin = false;  // points start some last places away: two such runs differ by what rounding does to them
};

// A run in progress. Used as: start, then step() as often as the spec says, reading in between at will.
class StudyRun {
 public:
  virtual ~StudyRun() = default;
  virtual void step() = 0;                     // one of spec.steps
  virtual void observe(Observation& out) = 0;  // the state now
  virtual Invariants invariants() = 0;
  virtual StudyCounters counters() const = 0;
  virtual std::size_t bytes() const { return 0; }         // of the systems that take part
  virtual bool gave_up() const { return false; }          // the library holds a non-finite object back
  virtual std::string warning() const { return {}; }      // what the library warned of so far, in words
  virtual double event_error() const { return NAN; }      // s, of the event the problem is about; NaN: none so far
  virtual double own_error() const { return NAN; }        // a scene's own measure at t_end: stands for err_end
  virtual bool measures_itself() const { return false; }  // own_error() must be a number at t_end
};

class StudyProblem {
 public:
  virtual ~StudyProblem() = default;
  const ProblemInfo& info() const { return info_; }
  virtual std::vector<MethodInfo> methods() const = 0;
  // The rungs a study runs by default, coarse to fine.
  virtual std::vector<RunSpec> ladder(const MethodInfo& method) const = 0;
  // A fresh run. SceneError: refused.
  virtual std::unique_ptr<StudyRun> start(const RunSpec& spec) const = 0;
  // Does start() know twins?
  virtual bool has_twins() const { return false; }
  // Reference at time t; at the times of the 257 samples at least. Not thread-safe: may be computed on first use.
  virtual void reference(double t, Observation& out) const = 0;
  // Energy the exact solution has at t: less than at the start where the model dissipates. NaN: none.
  virtual double reference_energy(double) const { return info_.energy_start; }

 protected:
  friend std::unique_ptr<StudyProblem> make_study_problem(std::string_view name, const Params& options);
  // Once the scales and t_end are known.
  void set_reference(ReferenceKind kind, int digits, double uncertainty, std::string source);

  mutable ProblemInfo info_;  // scenes learn their scales with their first reference
};

std::span<const Variant<StudyProblem>> study_problems();

// The problem `name` with options set; SceneError names what is unknown. Keeps no memory in an arena.
std::unique_ptr<StudyProblem> make_study_problem(std::string_view name, const Params& options);

// "stiffness=1e8" into options: numbers as numbers, true and false as flags, the rest as text.
void set_option(Params& options, std::string_view assignment);

// The error pass of one point: run it, record it, check it.
struct RunLimits {
  double budget_work = 4e7;  // force evaluations times points; more: slow, and stopped
  bool series = true;        // keep the curves over time
  // Set by others, may be null: the run ends within a step, and a sweep returns the points that are finished.
  const std::atomic<bool>* stop = nullptr;
  bool stopped() const { return stop && *stop; }
};

// A sweep: every method of a problem up its ladder. First the error pass, point by point; then the timing pass on the
// points that reached the end, interleaved. A plan gives each point an index that does not depend on
// the shard that runs it, so results of shards merge to the whole.
struct TimingOptions {
  bool enabled = true;
  int warm_ups = 2, min_repeats = 5, max_repeats = 50;
  double min_total_s = 0.3;   // per point, unless max_repeats came first
  double budget_s = 25;       // for the whole sweep; every point is timed once whatever it says
  double noisy_ratio = 1.15;  // of median to minimum
};

struct Ladder {
  std::string axis;  // "h", "tol", "iters", "substeps", "steps"
  std::vector<double> values;
};

// A point of the error pass and its curves.
struct FinishedPoint {
  StudyPoint point;
  StudySeries series;
};

struct SweepOptions {
  std::vector<std::string> methods;  // empty: all
  std::vector<Ladder> ladders;       // empty: the problem's own; several axes: all combinations
  RunLimits limits;
  TimingOptions timing;
  WorkWeights weights;
  int shard = 0, shards = 1;  // points with index % shards == shard
  std::string machine;        // written into each point that is run here
  // Points of the same study that ran before it was stopped: taken over instead of run. Timed anew with the others.
  std::vector<FinishedPoint> done;
  // The problem as the last of them knew it (references of scenes are learned in runs); used when nothing is left to
  // run.
  std::optional<ProblemInfo> learned;
  // Called with each point that was run, as soon as its errors are known; may be empty.
  std::function<void(const FinishedPoint&, const ProblemInfo&)> finished;
  // Called between points with what is done, from 0 to 1, and where; may be empty.
  std::function<void(double done, const std::string& where)> progress;
};

struct PlannedPoint {
  std::size_t index = 0;
  MethodInfo method;
  RunSpec spec;
};

// "h:1e-1..1e-5:x2", "tol:1e-2..1e-12:x10", "iters:1..256:x2", "steps:60,600,6000". SceneError says what is wrong.
Ladder parse_ladder(std::string_view text);

// All points, whatever the shard. SceneError on unknown methods or ladders no method can use.
std::vector<PlannedPoint> plan_sweep(const StudyProblem& problem, const SweepOptions& options);

// The points of the shard, run, timed and evaluated.
StudyResult run_sweep(const StudyProblem& problem, const SweepOptions& options);

// From points to statements: fronts, orders, the least cost of an error. Pure functions of the points.
// Fills fits, fronts (also the points' flags) and cost_to_accuracy.
void evaluate(StudyResult& result);

// The results of shards of one plan as one result, evaluated. SceneError when they do not belong together.
StudyResult merge_shards(std::vector<StudyResult> shards);

// The error a point is ranked by: err_end; of chaotic problems the share of t_end beyond the horizon.
double ranking_error(const ProblemInfo& problem, const StudyPoint& point);

// Stability maps: a method on a problem over two axes, a verdict for each cell, and the boundary found by bisection
// beside the one that theory predicts. Plain data for tables and drawings; NaN stands for "does not apply". Runs on the
// calling thread.

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
