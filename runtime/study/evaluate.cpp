// Points of one setting of a scene are compared with each other only; another setting is another problem.
// Points are ranked by their error along the run: the error at t_end alone may vanish by luck of the phase. An error is
// reached where all finer points of the same ladder have it too, for the same reason.
// Fronts: points with no other both cheaper and better; by time, cheaper means below 0.9 of the cost.
// Orders: least squares over the finest straight stretch of points whose errors are small, yet above the floor of the
// reference and of the rounding of each point.
#include <algorithm>
#include <numeric>

#include "feder/error.h"
#include "feder/study.h"
#include "study/norms.h"

namespace feder {
namespace {

constexpr double kTimeMargin = 0.9;
constexpr double kStraight = 0.02;  // rms of log10(error) about the line
constexpr double kSmall = 0.05;     // errors above it are not in the regime an order speaks of
constexpr std::size_t kFitPoints = 4;
constexpr double kFinestTarget = 1e-11;

bool counts(const StudyPoint& p) {
  return p.completed && (p.status == PointStatus::ok || p.status == PointStatus::slow);
}

// Indices of the non-dominated points by (cost, error), cheapest first.
template <class Cost>
std::vector<std::size_t> front(const StudyResult& r, Cost cost, double margin) {
  std::vector<std::size_t> all, out;
  for (std::size_t i = 0; i < r.points.size(); ++i)
    if (counts(r.points[i]) && std::isfinite(cost(r.points[i])) && std::isfinite(ranking_error(r.problem, r.points[i])))
      all.push_back(i);
  // below the floor of the reference and of rounding nobody is better
  const auto error = [&](std::size_t i) {
    return std::max(ranking_error(r.problem, r.points[i]), r.points[i].floor(r.problem.reference));
  };
  for (const std::size_t i : all) {
    const double c = cost(r.points[i]), e = error(i);
    const bool beaten = std::any_of(all.begin(), all.end(), [&](std::size_t j) {
      const double cj = cost(r.points[j]), ej = error(j);
      return j != i && cj <= margin * c && ej <= e && (cj < margin * c || ej < e) &&
             r.points[i].settings == r.points[j].settings;
    });
    if (!beaten) out.push_back(i);
  }
  std::stable_sort(out.begin(), out.end(),
                   [&](std::size_t a, std::size_t b) { return cost(r.points[a]) < cost(r.points[b]); });
  return out;
}

struct Axis {
  const char* name;
  double (*value)(const StudyPoint&);
};
constexpr Axis kAxes[] = {
    {"tol", [](const StudyPoint& p) { return p.tol; }},
    {"h", [](const StudyPoint& p) { return p.h_s; }},
    {"substeps", [](const StudyPoint& p) { return p.substeps > 0 ? double(p.substeps) : NAN; }},
    {"iters", [](const StudyPoint& p) { return p.iters > 0 ? double(p.iters) : NAN; }},
};

// Points of one method with one setting, in the order of the plan.
struct Case {
  const MethodInfo* method;
  Settings settings;
  std::vector<const StudyPoint*> points;
};

std::vector<Case> cases_of(const StudyResult& r) {
  std::vector<Case> out;
  for (const MethodInfo& m : r.methods) {
    const std::size_t first = out.size();
    for (const StudyPoint& p : r.points) {
      if (p.method != m.name) continue;
      auto at = std::find_if(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
                             [&](const Case& c) { return c.settings == p.settings; });
      if (at == out.end()) at = out.insert(out.end(), {&m, p.settings, {}});
      at->points.push_back(&p);
    }
  }
  return out;
}

// The one axis that varies, or null: with several there is no order to fit.
const Axis* varying_axis(const std::vector<const StudyPoint*>& points) {
  const Axis* found = nullptr;
  for (const Axis& a : kAxes) {
    bool varies = false;
    for (const StudyPoint* p : points) {
      const double x = a.value(*p), first = a.value(*points.front());
      varies = varies || (std::isfinite(x) && std::isfinite(first) && x != first);
    }
    if (!varies) continue;
    if (found) return nullptr;
    found = &a;
  }
  return found;
}

// The finest window of points on a line, or the straightest when none is straight. Finer points may sit on rounding.
Line straight_stretch(const std::vector<double>& x, const std::vector<double>& y, std::size_t& first,
                      std::size_t& count) {
  count = std::min(kFitPoints, x.size());
  Line best;
  for (std::size_t k = x.size() - count + 1; k-- > 0;) {
    const Line line = fit_line({&x[k], count}, {&y[k], count});
    if (!std::isnan(best.rms) && !(line.rms < best.rms)) continue;
    best = line;
    first = k;
    if (best.rms < kStraight) break;
  }
  return best;
}

// The parts of the ladder of a case.
std::vector<Case> parts_of(const Case& c) {
  std::vector<Case> out;
  for (const StudyPoint* p : c.points) {
    auto at = std::find_if(out.begin(), out.end(),
                           [&](const Case& o) { return o.points.front()->refinement_axis == p->refinement_axis; });
    if (at == out.end()) at = out.insert(out.end(), {c.method, c.settings, {}});
    at->points.push_back(p);
  }
  return out;
}

void fit_orders(StudyResult& r, const std::vector<Case>& parts) {
  for (const Case& c : parts) {
    const Axis* axis = varying_axis(c.points);
    if (!axis) continue;
    std::vector<double> x, y;
    const StudyPoint* before = nullptr;
    for (const StudyPoint* p : c.points) {
      // a tolerance that changes nothing says nothing: the step given was short enough already
      const bool same = before && p->count.force_evals == before->count.force_evals && p->err_end == before->err_end;
      before = p;
      if (same) continue;
      const double e = ranking_error(r.problem, *p);
      const double floor = std::max(p->floor(r.problem.reference), r.problem.reference.resolution);
      if (!counts(*p) || p->below_floor || !(e > floor) || !(e < kSmall)) continue;
      x.push_back(std::log10(axis->value(*p))), y.push_back(std::log10(e));
    }
    if (x.size() < 3) continue;
    std::size_t first = 0, count = 0;
    const Line line = straight_stretch(x, y, first, count);
    OrderFit fit{c.method->name,
                 axis->name,
                 line.slope,
                 NAN,
                 line.rms,
                 std::pow(10, x[first + count - 1]),
                 std::pow(10, x[first]),
                 static_cast<int>(count),
                 c.settings,
                 c.points.front()->refinement_axis};
    if (fit.axis == "h" && c.method->order > 0) fit.expected = c.method->order;
    if (fit.axis == "tol") fit.expected = 1;
    if (fit.lo > fit.hi) std::swap(fit.lo, fit.hi);
    r.fits.push_back(std::move(fit));
  }
}

// log-log between two points that enclose the target
double between(double e0, double e1, double a, double b, double target) {
  if (!(a > 0 && b > 0)) return NAN;
  const double s = e0 == e1 ? 0 : (std::log(target) - std::log(e0)) / (std::log(e1) - std::log(e0));
  return std::exp(std::log(a) + s * (std::log(b) - std::log(a)));
}

// Cheapest crossing of the target on the polyline of one part of a ladder, by work, behind which no finer point is
// above the target or failed. False: it never gets there.
bool crossing_of(const StudyResult& r, const Case& c, double target, CostToAccuracy& out) {
  std::vector<const StudyPoint*> own;
  for (const StudyPoint* p : c.points)
    if (p->status != PointStatus::refused && p->work > 0) own.push_back(p);
  std::stable_sort(own.begin(), own.end(), [](auto* a, auto* b) { return a->work < b->work; });
  const auto error = [&](const StudyPoint* p) {
    const double e = ranking_error(r.problem, *p);
    return counts(*p) && e >= 0 ? std::max(e, p->floor(r.problem.reference)) : INFINITY;
  };
  std::size_t i = own.size();
  while (i > 0 && error(own[i - 1]) <= target) --i;
  if (i < own.size()) {
    const StudyPoint *b = own[i], *a = i > 0 ? own[i - 1] : b;
    const double ea = error(a), eb = error(b);
    const auto at = [&](double x, double y) { return i > 0 && std::isfinite(ea) ? between(ea, eb, x, y, target) : y; };
    out = {target,
           c.method->name,
           at(a->h_s, b->h_s),
           at(a->tol, b->tol),
           at(double(a->count.force_evals), double(b->count.force_evals)),
           at(a->work, b->work),
           at(a->t_min_s, b->t_min_s),
           false,
           false};
    return true;
  }
  return false;
}

// The cheapest of its parts.
bool cost_of_case(const StudyResult& r, const Case& c, double target, CostToAccuracy& out) {
  bool any = false;
  for (const Case& part : parts_of(c)) {
    CostToAccuracy one;
    if (!crossing_of(r, part, target, one)) continue;
    const double time = std::fmin(any ? out.time_s : one.time_s, one.time_s);
    if (!any || one.work < out.work) out = std::move(one);
    out.time_s = time;
    any = true;
  }
  return any;
}

// What the cases of one method, [first, last), need for the target: the dearest of them, if all get there.
bool cost_of_method(const StudyResult& r, const Case* first, const Case* last, double target, CostToAccuracy& out) {
  for (const Case* c = first; c != last; ++c) {
    CostToAccuracy one;
    if (!cost_of_case(r, *c, target, one)) return false;
    const double time = std::fmax(c == first ? one.time_s : out.time_s, one.time_s);
    if (c == first || one.work > out.work) out = std::move(one);
    out.time_s = time;
  }
  return first != last;
}

void fill_costs(StudyResult& r, const std::vector<Case>& cases) {
  for (double target = 0.1; target > kFinestTarget && target > r.problem.reference.floor(); target /= 10) {
    const std::size_t first = r.cost_to_accuracy.size();
    const Case* const end = cases.data() + cases.size();
    for (const Case *c = cases.data(), *next = c; c != end; c = next) {
      while (next != end && next->method == c->method) ++next;
      CostToAccuracy cost;
      // 0.1, not 0.1 less rounding of the division
      if (cost_of_method(r, c, next, std::pow(10, std::round(std::log10(target))), cost))
        r.cost_to_accuracy.push_back(std::move(cost));
    }
    CostToAccuracy *work = nullptr, *time = nullptr;
    for (std::size_t i = first; i < r.cost_to_accuracy.size(); ++i) {
      CostToAccuracy& c = r.cost_to_accuracy[i];
      if (!work || c.work < work->work) work = &c;
      if (std::isfinite(c.time_s) && (!time || c.time_s < time->time_s)) time = &c;
    }
    if (work) work->cheapest_work = true;
    if (time) time->cheapest_time = true;
  }
}

}  // namespace

double ranking_error(const ProblemInfo& problem, const StudyPoint& p) {
  // chaos: how much of the run was beyond the horizon
  if (problem.chaotic) return std::isnan(p.err_horizon_s) ? NAN : 1 - p.err_horizon_s / problem.t_end;
  return problem.own_measure || std::isnan(p.err_traj_rms) ? p.err_end : p.err_traj_rms;
}

void evaluate(StudyResult& r) {
  r.fits.clear(), r.cost_to_accuracy.clear();
  for (StudyPoint& p : r.points) p.on_front_time = p.on_front_work = false;
  r.front_time = front(
      r, [](const StudyPoint& p) { return p.t_min_s; }, kTimeMargin);
  r.front_work = front(
      r, [](const StudyPoint& p) { return p.work; }, 1.0);
  for (const std::size_t i : r.front_time) r.points[i].on_front_time = true;
  for (const std::size_t i : r.front_work) r.points[i].on_front_work = true;
  const std::vector<Case> cases = cases_of(r);
  std::vector<Case> parts;
  for (const Case& c : cases)
    for (Case& part : parts_of(c)) parts.push_back(std::move(part));
  fit_orders(r, parts);
  fill_costs(r, cases);
}

StudyResult merge_shards(std::vector<StudyResult> shards) {
  if (shards.empty()) throw SceneError("merge: expected at least one result, got none");
  StudyResult all = std::move(shards.front());
  const auto params = [](const StudyResult& r) {
    std::string s = r.problem.name;
    for (const ProblemParam& p : r.problem.params) s += " " + p.name + "=" + p.value;
    return s;
  };
  for (std::size_t k = 1; k < shards.size(); ++k) {
    StudyResult& s = shards[k];
    if (params(s) != params(all) || s.planned != all.planned)
      throw SceneError("merge: expected shards of one study, got '" + params(all) + "' and '" + params(s) + "'");
    std::move(s.points.begin(), s.points.end(), std::back_inserter(all.points));
    std::move(s.series.begin(), s.series.end(), std::back_inserter(all.series));
  }
  std::stable_sort(all.points.begin(), all.points.end(), [](auto& a, auto& b) { return a.index < b.index; });
  std::stable_sort(all.series.begin(), all.series.end(), [](auto& a, auto& b) { return a.point < b.point; });
  for (std::size_t i = 0; i + 1 < all.points.size(); ++i)
    if (all.points[i].index == all.points[i + 1].index)
      throw SceneError("merge: point " + std::to_string(all.points[i].index) + " came twice");
  all.shard = 0, all.shards = 1;
  evaluate(all);
  return all;
}

}  // namespace feder
