// One run against the reference. The observed state is read at the steps that enclose a sample time, and watched on at
// least 2048 others; diverged and non-finite runs end where they are found out, except that one that
// only has too much energy goes on: its errors are worth seeing.
#include "study/run.h"

#include <algorithm>

#include "feder/study.h"
#include "study/norms.h"

namespace feder {
namespace {

constexpr int kWatched = 2048;
constexpr double kFar = 1e6, kFast = 1e3, kHot = 1e3;  // x_scale, v_scale, energy_scale
constexpr double kHorizon = 1e-3;
constexpr double kSlowShare = 0.01;                             // of the solves may miss their tolerance
constexpr double kTwinBelow = sizeof(Real) == 4 ? 1e-2 : 1e-7;  // larger errors are not rounding's

bool finite(const Observation& o) {
  const auto all = [](const std::vector<double>& a) {
    return std::all_of(a.begin(), a.end(), [](double x) { return std::isfinite(x); });
  };
  return all(o.x) && all(o.v) && all(o.q);
}

double largest(const std::vector<double>& a) {
  double m = 0;
  for (const double x : a) m = std::max(m, std::fabs(x));
  return m;
}

double distance(const double (&a)[3], const double (&b)[3]) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

// max that keeps NaN out: NaN stands for "nothing yet"
void raise(double& worst, double x) {
  if (std::isfinite(x) && !(worst >= x)) worst = x;
}

class RunWatch {
 public:
  RunWatch(const StudyProblem& problem, const MethodInfo& method, const RunSpec& spec, StudyPoint& point,
           StudySeries* series)
      : problem_(problem), info_(problem.info()), h_(info_.t_end / spec.steps), dense_(info_.dense && !method.adaptive),
        point_(point), series_(series) {}

  void start(StudyRun& run) {
    run.observe(now_);
    first_ = run.invariants();
    problem_.reference(0, reference_);
    momentum_scale_ = first_.momentum_scale, angular_scale_ = first_.angular_scale;
    sample(0, now_);
    invariants(run, 0, true);
  }

  // Must the state after step k be read? k counts from 1.
  bool wants(std::int64_t k, std::int64_t steps) const {
    const std::int64_t stride = std::max<std::int64_t>(1, steps / kWatched);
    return k % stride == 0 || k >= steps || next_time() <= static_cast<double>(k + 1) * h_ + 1e-9 * h_;
  }

  // False: the run is over.
  bool record(StudyRun& run, std::int64_t k, std::int64_t steps) {
    const double t = k == steps ? info_.t_end : static_cast<double>(k) * h_;
    std::swap(before_, now_);
    std::swap(t_before_, t_now_);
    run.observe(now_);
    t_now_ = t;
    if (problem_.has_twins() && next_ < kStudySamples && next_time() <= t + 1e-9 * h_) seen_.push_back({k, now_.x});
    if (run.gave_up() || !finite(now_)) return fail(PointStatus::nan, t, "a state that is no number");
    if (largest(now_.x) > kFar * info_.x_scale) return fail(PointStatus::diverged, t, "position");
    if (largest(now_.v) > kFast * info_.v_scale) return fail(PointStatus::diverged, t, "velocity");
    bool sampled = false;
    while (next_ < kStudySamples && next_time() <= t + 1e-9 * h_) {
      take_sample(t);
      sampled = true;
    }
    invariants(run, t, sampled);
    return true;
  }

  void finish(StudyRun& run) {
    if (samples_ == kStudySamples) {
      point_.err_traj_rms = std::sqrt(squares_ / samples_);
      point_.completed = true;
      problem_.reference(info_.t_end, reference_);
      point_.err_end = rms_distance(now_.x, reference_.x) / info_.x_scale;
      point_.err_end_v = rms_distance(now_.v, reference_.v) / info_.v_scale;
      point_.err_orient_rad = largest_angle(now_.q, reference_.q);
      point_.mescd = correct_digits(now_, reference_, info_.x_scale, info_.v_scale);
      point_.err_event_s = run.event_error();
      if (run.measures_itself() && !std::isfinite(run.own_error()) && point_.status == PointStatus::ok)
        fail(PointStatus::nan, info_.t_end, "the scene's own error is no number");
      if (std::isfinite(run.own_error())) point_.err_end = run.own_error();
      if (std::isnan(point_.err_horizon_s)) point_.err_horizon_s = info_.t_end;
      if (energy_t_.size() > 2) point_.err_energy_drift_per_s = fit_line(energy_t_, energy_).slope;
    }
    if (momentum_scale_ > 0) point_.err_mom /= momentum_scale_;
    if (angular_scale_ > 0) point_.err_angmom /= angular_scale_;
    if (!series_) return;
    for (double& p : series_->momentum) p /= momentum_scale_;
    for (double& l : series_->angmom) l /= angular_scale_;
  }

  // Largest distance of a twin from this run, where it was sampled.
  void compare(StudyRun& twin) {
    std::int64_t k = 0;
    double worst = 0;
    for (const Seen& seen : seen_) {
      for (; k < seen.step; ++k) twin.step();
      twin.observe(between_);
      raise(worst, rms_distance(between_.x, seen.x) / info_.x_scale);
    }
    point_.noise = worst;
  }

  bool fail(PointStatus status, double t, const char* what) {
    point_.status = status;
    point_.status_t_s = t;
    point_.reason = what;
    return false;
  }

 private:
  double next_time() const { return info_.t_end * next_ / (kStudySamples - 1); }

  void take_sample(double t) {
    const double wanted = next_time();
    // not dense: the nearer of the two steps, against the reference at its own time
    if (dense_ && t - wanted > 1e-9 * h_) {
      interpolate(t_before_, before_, t, now_, wanted, between_);
      sample(wanted, between_);
    } else if (t - wanted > h_ / 2) {
      sample(t_before_, before_);
    } else {
      sample(dense_ ? wanted : t, now_);
    }
  }

  void sample(double t, const Observation& state) {
    problem_.reference(t, reference_);
    const double error = rms_distance(state.x, reference_.x) / info_.x_scale;
    squares_ += error * error;
    raise(point_.err_traj_max, error);
    if (error > kHorizon && std::isnan(point_.err_horizon_s)) point_.err_horizon_s = t;
    ++next_, ++samples_;
    if (series_) series_->t.push_back(t), series_->err.push_back(error);
  }

  void invariants(StudyRun& run, double t, bool sampled) {
    const Invariants i = run.invariants();
    const double off = (i.energy - problem_.reference_energy(t)) / info_.energy_scale;
    raise(point_.err_energy_max, std::fabs(off));
    if (std::isfinite(off)) {
      energy_t_.push_back(t), energy_.push_back(off);
      if (off > kHot && point_.status == PointStatus::ok) fail(PointStatus::diverged, t, "energy");
    }
    raise(momentum_scale_, i.momentum_scale), raise(angular_scale_, i.angular_scale);
    const double momentum = info_.conserves_momentum ? distance(i.momentum, first_.momentum) : NAN;
    const double angular = info_.conserves_angular ? distance(i.angular, first_.angular) : NAN;
    raise(point_.err_mom, momentum), raise(point_.err_angmom, angular), raise(point_.err_constraint, i.constraint);
    if (!sampled || !series_) return;
    // a step may pass several samples: each gets the values at its end
    while (series_->energy.size() < series_->t.size())
      series_->energy.push_back(off), series_->momentum.push_back(momentum), series_->angmom.push_back(angular);
  }

  struct Seen {
    std::int64_t step;
    std::vector<double> x;
  };

  const StudyProblem& problem_;
  const ProblemInfo& info_;
  std::vector<Seen> seen_;
  double h_;
  bool dense_;  // cubic Hermite between steps; adaptive methods take steps too long for that
  StudyPoint& point_;
  StudySeries* series_;
  Observation before_, now_, between_, reference_;
  double t_before_ = 0, t_now_ = 0;
  Invariants first_;
  int next_ = 0, samples_ = 0;
  double squares_ = 0, momentum_scale_ = NAN, angular_scale_ = NAN;
  std::vector<double> energy_t_, energy_;
};

}  // namespace

double work_of(const StudyCounters& c, const WorkWeights& w) {
  const double direct = c.cg_iters > 0 ? 0 : w.direct_solve * static_cast<double>(c.linear_solves);
  return static_cast<double>(c.force_evals) + w.jacobian * static_cast<double>(c.jac_evals) +
         w.cg_iteration * static_cast<double>(c.cg_iters) + direct;
}

void run_point(const StudyProblem& problem, const MethodInfo& method, const RunSpec& spec, const RunLimits& limits,
               const WorkWeights& weights, StudyPoint& point, StudySeries* series) {
  point.method = method.name;
  point.order = method.order;
  point.h_s = problem.info().t_end / spec.steps;
  point.tol = spec.tolerance > 0 ? spec.tolerance : NAN;
  point.iters = spec.iterations > 0 ? spec.iterations : -1;
  point.substeps = spec.substeps > 0 ? spec.substeps : -1;
  point.settings = spec.settings;
  point.refinement_axis = spec.refinement_axis;
  std::unique_ptr<StudyRun> run;
  try {
    run = problem.start(spec);
  } catch (const SceneError& e) {
    point.status = PointStatus::refused;
    point.status_t_s = 0;
    point.reason = e.what();
    return;
  }
  RunWatch watch(problem, method, spec, point, limits.series ? series : nullptr);
  watch.start(*run);
  const double size = std::max(1, problem.info().dof);
  for (std::int64_t k = 1; k <= spec.steps; ++k) {
    if (limits.stopped()) return;
    run->step();
    if (!watch.wants(k, spec.steps)) continue;
    if (!watch.record(*run, k, spec.steps)) break;
    if (work_of(run->counters(), weights) * size > limits.budget_work && k < spec.steps) {
      watch.fail(PointStatus::slow, static_cast<double>(k) * point.h_s, "work budget");
      break;
    }
  }
  watch.finish(*run);
  // an adaptive method takes other steps for a twin: their distance would be what it truncates
  if (problem.has_twins() && !method.adaptive && point.completed && point.err_traj_rms < kTwinBelow) {
    RunSpec other = spec;
    other.twin = true;
    watch.compare(*problem.start(other));
  }
  point.below_floor = point.completed && ranking_error(problem.info(), point) < point.floor(problem.info().reference);
  point.count = run->counters();
  point.work = work_of(point.count, weights);
  point.peak_bytes = static_cast<std::int64_t>(run->bytes());
  const auto solves = static_cast<double>(std::max<std::int64_t>(1, point.count.linear_solves));
  if (point.status == PointStatus::ok && static_cast<double>(point.count.unconverged) > kSlowShare * solves)
    watch.fail(PointStatus::slow, NAN, "solver missed its tolerance");
  if (const std::string warned = run->warning(); !warned.empty())
    point.reason += (point.reason.empty() ? "warned: " : "; warned: ") + warned;
}

}  // namespace feder
