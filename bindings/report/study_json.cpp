// report.json, schema "accuracy/1", and points.csv: written and read by the same lists of fields, so that a shard comes
// back whole.
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "feder/snapshot.h"
#include "report/json_fields.h"
#include "report/study_figures.h"
#include "report/study_identity.h"
#include "report/table.h"

namespace feder::report {

// Fields of a point, in the order of the columns of points.csv.
constexpr bool kNoColumn = true;  // in reports alone

void fields(auto& p, auto& v, const StudyPoint*) {
  v("index", p.index, kNoColumn)("method", p.method)("order", p.order)("h_s", p.h_s)("tol", p.tol);
  v("iters", p.iters)("substeps", p.substeps)("settings", p.settings, kNoColumn)("way", p.refinement_axis, kNoColumn);
  v("machine", p.machine, kNoColumn);
  v.named("status", p.status,
          {PointStatus::ok, PointStatus::diverged, PointStatus::nan, PointStatus::refused, PointStatus::slow});
  v("status_t_s", p.status_t_s)("reason", p.reason, kNoColumn)("completed", p.completed, kNoColumn);
  v("below_floor", p.below_floor, kNoColumn)("noise", p.noise, kNoColumn);
  v("steps", p.count.steps)("rejected", p.count.rejected)("force_evals", p.count.force_evals);
  v("jac_evals", p.count.jac_evals)("linear_solves", p.count.linear_solves)("cg_iters", p.count.cg_iters);
  v("sweeps", p.count.sweeps)("unconverged", p.count.unconverged, kNoColumn)("work", p.work, kNoColumn);
  v("instr", p.instr)("t_min_s", p.t_min_s)("t_med_s", p.t_med_s)("t_p90_s", p.t_p90_s)("n_rep", p.n_rep);
  v("noisy", p.noisy)("rtf", p.rtf)("err_end", p.err_end)("err_end_v", p.err_end_v, kNoColumn);
  v("err_traj_rms", p.err_traj_rms)("err_traj_max", p.err_traj_max);
  v("err_orient_rad", p.err_orient_rad, kNoColumn)("err_energy_max", p.err_energy_max);
  v("err_energy_drift_per_s", p.err_energy_drift_per_s)("err_mom", p.err_mom)("err_angmom", p.err_angmom);
  v("err_constraint", p.err_constraint)("err_event_s", p.err_event_s);
  v("err_horizon_s", p.err_horizon_s, kNoColumn)("mescd", p.mescd)("peak_bytes", p.peak_bytes);
  v("on_front_time", p.on_front_time)("on_front_work", p.on_front_work);
}
void fields(auto& m, auto& v, const MethodInfo*) {
  v("name", m.name)("summary", m.summary)("order", m.order)("evals_per_step", m.evals_per_step);
  v("limit_hw", m.limit_hw)("implicit", m.implicit)("adaptive", m.adaptive);
}
void fields(auto& p, auto& v, const ProblemParam*) {
  v("name", p.name)("value", p.value)("default", p.fallback)("help", p.help)("lo", p.lo)("hi", p.hi);
  v("choices", p.choices);
}
void fields(auto& r, auto& v, const ReferenceInfo*) {
  v.named("kind", r.kind, {ReferenceKind::closed, ReferenceKind::quad, ReferenceKind::published, ReferenceKind::self});
  v("digits", r.digits)("uncertainty", r.uncertainty)("rounding", r.rounding).derived("floor", r.floor());
  v("resolution", r.resolution)("source", r.source);
}
void fields(auto& p, auto& v, const ProblemInfo*) {
  v("name", p.name)("summary", p.summary)("family", p.family)("t_end", p.t_end)("dof", p.dof);
  v("x_scale", p.x_scale)("v_scale", p.v_scale)("E_scale", p.energy_scale)("E_start", p.energy_start);
  v("frequency", p.frequency)("chaotic", p.chaotic)("conserves_momentum", p.conserves_momentum);
  v("conserves_angular", p.conserves_angular)("dense", p.dense)("own_measure", p.own_measure);
  v("threads", p.threads).part("params", p.params).part("reference", p.reference);
}
void fields(auto& s, auto& v, const StudySeries*) {
  v("point", s.point)("t", s.t)("err", s.err)("energy", s.energy)("momentum", s.momentum)("angmom", s.angmom);
}
void fields(auto& f, auto& v, const FinishedPoint*) { v.part("point", f.point).part("series", f.series); }
void fields(auto& w, auto& v, const WorkWeights*) {
  v("jacobian", w.jacobian)("cg_iteration", w.cg_iteration)("direct_solve", w.direct_solve);
}
void fields(auto& f, auto& v, const OrderFit*) {
  v("method", f.method)("axis", f.axis)("slope", f.slope)("expected", f.expected)("rms", f.rms);
  v.derived("off", f.off()).derived("range", Json::array({json_value(f.lo), json_value(f.hi)}));
  v("points", f.points)("settings", f.settings);
}
void fields(auto& c, auto& v, const CostToAccuracy*) {
  v("target", c.target)("method", c.method)("h_s", c.h_s)("tol", c.tol)("force_evals", c.force_evals);
  v("work", c.work)("time_s", c.time_s)("cheapest_work", c.cheapest_work)("cheapest_time", c.cheapest_time);
}

namespace {

// The columns of points.csv that a point fills: their names, and its cells.
struct PointColumns {
  std::string names, cells;
  template <class T>
  PointColumns& operator()(const char* key, const T& v, bool no_column = false) {
    if (no_column) return *this;
    names += "," + std::string(key);
    cells += "," + csv_cell(v);
    return *this;
  }
  template <class E>
  PointColumns& named(const char* key, E v, std::initializer_list<E>) {
    return (*this)(key, name_of(v));
  }
};

PointColumns columns_of(const StudyPoint& p) {
  PointColumns columns;
  fields(p, columns, &p);
  return columns("settings", p.settings);
}

}  // namespace

std::string csv_header() { return "problem" + columns_of({}).names + ",overrides,threads,real,git,scene_hash,machine"; }

std::string csv_measured(const std::string& problem, const StudyPoint& p) {
  return csv_cell(problem) + columns_of(p).cells;
}

std::string csv_row(const std::string& problem, const StudyResult& r, const StudyPoint& p) {
  const Provenance& from = r.provenance;
  return csv_measured(problem, p) + "," +
         csv_line(from.overrides, r.problem.threads, from.real, from.git, from.scene_hash, p.machine);
}

std::string points_csv(std::span<const StudyResult> results, bool labelled) {
  std::string out = csv_header() + "\n";
  for (const StudyResult& r : results)
    for (const StudyPoint& p : r.points)
      out += csv_row(labelled ? problem_label(r.problem) : r.problem.name, r, p) + "\n";
  return out;
}

Json study_json(const StudyResult& r, const StudyContext& context) {
  // a shard keeps all curves, because only the whole knows which ones are drawn
  Json series = Json::array(), front_time = Json::array(), front_work = Json::array();
  if (r.points.size() < r.planned)
    series = written(r.series);
  else
    for (const StudySeries* s : drawn_series(r)) series.push_back(written(*s));
  for (const std::size_t k : r.front_time) front_time.push_back(r.points[k].index);
  for (const std::size_t k : r.front_work) front_work.push_back(r.points[k].index);
  Json plan = {{"points", r.planned}, {"shard", r.shard}, {"shards", r.shards}};
  if (r.interrupted) plan["interrupted"] = true;
  return {{"schema", "accuracy/1"},
          {"study", identity_json(r)},
          {"run", written(context.machine)},
          {"command", context.command},
          {"settings", context.settings},
          {"problem", written(r.problem)},
          {"methods", written(r.methods)},
          {"plan", plan},
          {"weights", written(r.weights)},
          {"points", written(r.points)},
          {"fits", written(r.fits)},
          {"front", {{"time", front_time}, {"force", front_work}}},
          {"cost_to_accuracy", written(r.cost_to_accuracy)},
          {"gate", context.gate.empty() ? Json{{"baseline", nullptr}, {"violations", Json::array()}} : context.gate},
          {"series", series}};
}

StudyResult study_from_json(const Json& j) {
  if (!j.is_object() || j.value("schema", "") != "accuracy/1")
    throw std::runtime_error("expected the schema accuracy/1");
  try {
    StudyResult r;
    read_into(j.at("problem"), r.problem);
    read_into(j.at("methods"), r.methods);
    const Json& plan = j.at("plan");
    r.planned = plan.at("points").get<std::size_t>();
    r.shard = plan.at("shard").get<int>();
    r.shards = plan.at("shards").get<int>();
    read_into(j.value("study", Json::object()), r.provenance);
    read_into(j.at("weights"), r.weights);
    read_into(j.at("points"), r.points);
    read_into(j.value("series", Json::array()), r.series);
    return r;
  } catch (const Json::exception& e) {
    throw std::runtime_error(std::string("no report of a study: ") + e.what());
  }
}

void round_series(StudyResult& r) {
  const auto round = [](std::vector<double>& values) {
    for (double& v : values)
      if (std::isfinite(v)) v = std::stod(fmt::format("{:.6g}", v));
  };
  for (StudySeries& s : r.series) round(s.t), round(s.err), round(s.energy), round(s.momentum), round(s.angmom);
}

Json finished_json(const FinishedPoint& f, const ProblemInfo& problem) {
  Json out = written(f);
  out["problem"] = written(problem);
  return out;
}

FinishedPoint finished_from_json(const Json& j, ProblemInfo& problem) {
  try {
    problem = read_as<ProblemInfo>(j.at("problem"));
    return read_as<FinishedPoint>(j);
  } catch (const Json::exception& e) {
    throw std::runtime_error(std::string("no point of a study: ") + e.what());
  }
}

}  // namespace feder::report
