// Ladders as text, the plan of a sweep, its error pass, and its timing pass: runs of all points in turn, so that a slow
// spell of the machine meets all alike. Weak spot: minima of few repeats where the budget is short.
#include <algorithm>
#include <charconv>
#include <chrono>

#include "feder/study.h"
#include "study/options.h"
#include "study/run.h"

namespace feder {
namespace {

constexpr double kShortest = 1e-3;  // s: shorter runs are repeated within one measurement

double parse_number(std::string_view text, std::string_view whole) {
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size() || !(x > 0) || !std::isfinite(x))
    throw SceneError("ladder '" + std::string(whole) + "': expected a number above 0, got '" + std::string(text) + "'");
  return x;
}

std::vector<double> parse_range(std::string_view range, std::string_view text) {
  const std::size_t dots = range.find(".."), by = range.find(":x");
  if (by == std::string_view::npos || by < dots)
    throw SceneError("ladder '" + std::string(text) + "': expected FROM..TO:xFACTOR");
  const double from = parse_number(range.substr(0, dots), text);
  const double to = parse_number(range.substr(dots + 2, by - dots - 2), text);
  const double factor = parse_number(range.substr(by + 2), text);
  if (!(factor > 1)) throw SceneError("ladder '" + std::string(text) + "': expected a factor above 1");
  std::vector<double> values;
  const bool up = to > from;
  for (double x = from; up ? x <= to * (1 + 1e-9) : x >= to * (1 - 1e-9); x = up ? x * factor : x / factor) {
    values.push_back(x);
    if (values.size() > 1000) throw SceneError("ladder '" + std::string(text) + "': more than 1000 rungs");
  }
  return values;
}

void apply(const Ladder& ladder, double value, double t_end, RunSpec& spec) {
  const auto whole = [](double x) { return static_cast<int>(std::min(2e9, std::max(1.0, std::round(x)))); };
  if (ladder.axis == "h")
    spec.steps = whole(t_end / value);
  else if (ladder.axis == "steps")
    spec.steps = whole(value);
  else if (ladder.axis == "tol")
    spec.tolerance = value;
  else if (ladder.axis == "iters")
    spec.iterations = whole(value);
  else if (ladder.axis == "substeps")
    spec.substeps = whole(value);
}

// A tolerance means nothing to fixed steps, and a step nothing to methods that choose their own.
bool uses(const MethodInfo& m, const Ladder& ladder) {
  if (ladder.axis == "tol") return m.adaptive;
  return !m.adaptive || (ladder.axis != "h" && ladder.axis != "steps");
}

std::vector<RunSpec> rungs_of(const StudyProblem& problem, const MethodInfo& m, const SweepOptions& options) {
  std::vector<RunSpec> rungs = problem.ladder(m);
  if (rungs.empty()) return rungs;
  bool given = false;
  for (const Ladder& l : options.ladders) given = given || uses(m, l);
  if (!given) return rungs;
  // combinations of the given axes; what they leave open stays as in the finest rung of the problem's own
  RunSpec base = rungs[rungs.size() / 2];
  rungs.assign(1, base);
  for (const Ladder& l : options.ladders) {
    if (!uses(m, l)) continue;
    std::vector<RunSpec> next;
    for (const RunSpec& r : rungs)
      for (const double value : l.values) {
        next.push_back(r);
        apply(l, value, problem.info().t_end, next.back());
      }
    rungs = std::move(next);
  }
  return rungs;
}

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

// Seconds of one run, recording off, the making of fresh states apart.
double measure(const StudyProblem& problem, const RunSpec& spec, int loops) {
  std::vector<std::unique_ptr<StudyRun>> fresh;
  for (int i = 0; i < loops; ++i) fresh.push_back(problem.start(spec));
  const auto start = Clock::now();
  for (const auto& run : fresh)
    for (int k = 0; k < spec.steps; ++k) run->step();
  return seconds_since(start) / loops;
}

// False, also for the exception of a script that was interrupted, when the sweep has to stop.
template <class F>
bool run_unless_stopped(const RunLimits& limits, F&& run) {
  if (limits.stopped()) return false;
  try {
    run();
  } catch (...) {
    if (!limits.stopped()) throw;
  }
  return !limits.stopped();
}

struct Timed {
  const PlannedPoint* planned;
  StudyPoint* point;
  int loops = 1, warm = 0;
  double total = 0;
  std::vector<double> samples;
};

bool satisfied(const Timed& t, const TimingOptions& o) {
  const int n = static_cast<int>(t.samples.size());
  return n >= o.max_repeats || (n >= o.min_repeats && t.total >= o.min_total_s);
}

void record_times(Timed& t, const TimingOptions& o, double t_end) {
  if (t.samples.empty()) return;
  std::sort(t.samples.begin(), t.samples.end());
  const auto rank = [&](double q) {
    return t.samples[static_cast<std::size_t>(std::lround(q * static_cast<double>(t.samples.size() - 1)))];
  };
  StudyPoint& p = *t.point;
  p.t_min_s = t.samples.front(), p.t_med_s = rank(0.5), p.t_p90_s = rank(0.9);
  p.n_rep = static_cast<int>(t.samples.size());
  p.noisy = p.t_med_s > o.noisy_ratio * p.t_min_s;
  p.rtf = t_end / p.t_min_s;
}

}  // namespace

Ladder parse_ladder(std::string_view text) {
  const std::size_t colon = text.find(':');
  Ladder ladder;
  ladder.axis = std::string(text.substr(0, colon));
  static const char* const known[] = {"h", "tol", "iters", "substeps", "steps"};
  if (colon == std::string_view::npos || std::find(std::begin(known), std::end(known), ladder.axis) == std::end(known))
    throw SceneError("ladder '" + std::string(text) +
                     "': expected h:, steps:, tol:, iters: or substeps:, then "
                     "FROM..TO:xFACTOR or a list");
  std::string_view rest = text.substr(colon + 1);
  if (rest.find("..") != std::string_view::npos) {
    ladder.values = parse_range(rest, text);
    return ladder;
  }
  for (std::size_t comma; !rest.empty(); rest = comma == std::string_view::npos ? "" : rest.substr(comma + 1)) {
    comma = rest.find(',');
    ladder.values.push_back(parse_number(rest.substr(0, comma), text));
  }
  if (ladder.values.empty()) throw SceneError("ladder '" + std::string(text) + "': expected values");
  return ladder;
}

std::vector<PlannedPoint> plan_sweep(const StudyProblem& problem, const SweepOptions& options) {
  const std::vector<MethodInfo> methods = problem.methods();
  std::vector<MethodInfo> chosen;
  for (const std::string& name : options.methods)
    chosen.push_back(find_variant(std::span<const MethodInfo>(methods), name, "method"));
  if (options.methods.empty()) chosen = methods;
  std::vector<PlannedPoint> plan;
  for (const MethodInfo& m : chosen)
    for (RunSpec& spec : rungs_of(problem, m, options)) plan.push_back({plan.size(), m, std::move(spec)});
  return plan;
}

void time_points(const StudyProblem& problem, std::span<const PlannedPoint> plan, const SweepOptions& options,
                 std::vector<StudyPoint>& points) {
  const TimingOptions& o = options.timing;
  std::vector<Timed> timed;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].completed) timed.push_back({&plan[i], &points[i], 1, 0, 0, {}});
  const auto begun = Clock::now();
  bool more = true, stopped = false;
  for (int round = 0; more && !stopped; ++round) {
    more = false;
    for (std::size_t i = 0; i < timed.size() && !stopped; ++i) {
      Timed& t = timed[i];
      const bool late = seconds_since(begun) > o.budget_s;
      if (satisfied(t, o) || (late && !t.samples.empty())) continue;
      double s = 0;
      stopped = !run_unless_stopped(options.limits, [&] { s = measure(problem, t.planned->spec, t.loops); });
      if (stopped) break;
      if (round == 0) t.loops = s < kShortest ? static_cast<int>(std::ceil(kShortest / std::max(s, 1e-7))) : 1;
      // long runs need no warming up
      if (t.warm < o.warm_ups && s < 0.05 && !late) {
        ++t.warm;
      } else {
        t.samples.push_back(s);
        t.total += s * t.loops;
      }
      more = more || !satisfied(t, o);
      if (options.progress && round == 0)
        options.progress(0.5 + 0.5 * static_cast<double>(i + 1) / static_cast<double>(timed.size()), "timing");
    }
  }
  for (Timed& t : timed) record_times(t, o, problem.info().t_end);
}

StudyResult run_sweep(const StudyProblem& problem, const SweepOptions& options) {
  if (options.shards < 1 || options.shard < 0 || options.shard >= options.shards)
    throw SceneError("shard: expected I/N with I from 0 to N-1, got " + std::to_string(options.shard) + "/" +
                     std::to_string(options.shards));
  const std::vector<PlannedPoint> whole = plan_sweep(problem, options);
  StudyResult r;
  r.problem = problem.info();
  r.planned = whole.size();
  r.shard = options.shard, r.shards = options.shards;
  r.weights = options.weights;
  std::vector<PlannedPoint> plan;
  for (const PlannedPoint& p : whole) {
    if (r.methods.empty() || r.methods.back().name != p.method.name) r.methods.push_back(p.method);
    if (p.index % static_cast<std::size_t>(options.shards) == static_cast<std::size_t>(options.shard))
      plan.push_back(p);
  }
  bool any_run = false;
  std::vector<PlannedPoint> finished;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    FinishedPoint now;
    const auto before = std::find_if(options.done.begin(), options.done.end(),
                                     [&](const FinishedPoint& d) { return d.point.index == plan[i].index; });
    if (before != options.done.end()) {
      now = *before;
    } else {
      now.point.index = now.series.point = plan[i].index;
      now.point.machine = options.machine;
      const bool done = run_unless_stopped(options.limits, [&] {
        run_point(problem, plan[i].method, plan[i].spec, options.limits, options.weights, now.point, &now.series);
      });
      if (!done) continue;  // those that were done before are taken over
      any_run = true;
      if (options.finished) options.finished(now, problem.info());
    }
    finished.push_back(plan[i]);
    r.points.push_back(std::move(now.point));
    if (!now.series.t.empty()) r.series.push_back(std::move(now.series));
    if (options.progress)
      options.progress(
          (options.timing.enabled ? 0.5 : 1.0) * static_cast<double>(i + 1) / static_cast<double>(plan.size()),
          plan[i].method.name);
  }
  // a self-refined reference knows its uncertainty by now
  r.problem = any_run || !options.learned ? problem.info() : *options.learned;
  if (options.timing.enabled) time_points(problem, finished, options, r.points);
  r.interrupted = options.limits.stopped();
  evaluate(r);
  return r;
}

}  // namespace feder
