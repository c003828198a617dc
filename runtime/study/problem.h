// Problems of a study: a start, methods that can run it, and a reference the runs are measured against. One file per
// family, one feder_variant(study <problem>) line. Contract, checked for every row by
// tests/study/test_problem_contract.cpp: each method starts at the reference's start, a refined run comes closer to the
// reference, equal specs give equal bits, parameters refuse values out of range.
#pragma once
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/registry.h"
#include "feder/params.h"
#include "study/result.h"

namespace feder {

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

// One way to run a problem: a method and a rung of its ladder.
struct RunSpec {
  std::string method;
  int steps = 0;         // of t_end / steps each; adaptive methods divide them further
  double tolerance = 0;  // adaptive methods, and fluids: the compression aimed at; 0: their default
  int iterations = 0;    // of the solver; 0: its default
  int substeps = 0;      // of worlds; 0: the problem's default
  Settings settings;
  std::string way = {};  // what this part of a ladder refines: "substeps", "steps" ...; empty: it has one part
  bool twin = false;     // points start some last places away: two such runs differ by what rounding does to them
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
  // The rungs a study runs when it is not told otherwise, coarse to fine.
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

}  // namespace feder
