// A small study made up by hand: every status, names that need escaping, and errors known by formula.
#pragma once
#include <cmath>
#include <string>

#include "feder/study.h"

namespace feder::test {

inline const char* const kNasty = "a<b>&\"c'd";

inline StudyPoint synthetic_point(const std::string& method, int order, int rung, double error, PointStatus status) {
  StudyPoint p;
  p.method = method;
  p.order = order;
  p.h_s = std::ldexp(0.125, -rung);
  p.status = status;
  p.completed = status == PointStatus::ok || status == PointStatus::slow;
  p.count.steps = 8 << rung;
  p.count.force_evals = order * (8 << rung);
  p.work = static_cast<double>(p.count.force_evals);
  if (p.completed)
    p.err_end = error, p.err_traj_rms = error / 2, p.t_min_s = p.work * 1e-6, p.t_med_s = p.t_min_s * 1.25,
    p.t_p90_s = p.t_min_s * 1.5, p.n_rep = 5;
  if (p.completed && error < 3e-7) p.below_floor = true;
  if (!p.completed) p.reason = "left every bound", p.status_t_s = 0.5;
  return p;
}

// Three methods with 4 rungs each: order 1, order 2 whose coarse rungs fail in three ways, and order 4 that ends below
// the certainty of the reference.
inline StudyResult synthetic_study() {
  StudyResult r;
  r.problem.name = "made_up";
  r.problem.summary = "a <made up> problem & its \"numbers\"";
  r.problem.family = "ode";
  r.problem.params = {{"stiffness", "100", "1", "k, N/m", 0, 1e9, {}},
                      {"mode", "x", "x", "which", NAN, NAN, {"x", "y"}}};
  r.problem.t_end = 1;
  r.problem.energy_scale = 0.5;
  r.problem.reference = {ReferenceKind::closed, 15, 1e-7, 1e-8, "formula"};
  r.methods = {{"first", "order 1", 1, 1, 0, false, false},
               {kNasty, "order 2", 2, 2, 2, false, false},
               {"fourth", "order 4", 4, 4, INFINITY, true, false}};
  const PointStatus bad[] = {PointStatus::nan, PointStatus::refused, PointStatus::diverged};
  for (int m = 0; m < 3; ++m) {
    const MethodInfo& info = r.methods[static_cast<std::size_t>(m)];
    for (int k = 0; k < 5; ++k) {
      const PointStatus status = m == 1 && k < 3 ? bad[k] : m == 2 && k == 0 ? PointStatus::slow : PointStatus::ok;
      StudyPoint p = synthetic_point(info.name, info.order, k, std::pow(std::ldexp(0.125, -k), info.order), status);
      p.index = r.points.size();
      r.points.push_back(p);
      StudySeries s;
      s.point = p.index;
      for (int i = 0; i <= 4; ++i) {
        s.t.push_back(i * 0.25);
        s.err.push_back(i * 1e-3);
        s.energy.push_back(1e-3 * i / (m + 1));
        s.momentum.push_back(NAN);
        s.angmom.push_back(NAN);
      }
      r.series.push_back(s);
    }
  }
  r.planned = r.points.size();
  r.shards = 1;
  evaluate(r);
  return r;
}

}  // namespace feder::test
