// report.json, schema "accuracy/1": written and read by the same lists of fields, so that a shard comes back whole.
// NaN is null; infinity, which JSON lacks, is the text "inf".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "feder/snapshot.h"
#include "report/study_figures.h"
#include "report/study_identity.h"

namespace feder::report {
namespace {

Json value_of(double v) {
  if (std::isnan(v)) return nullptr;
  if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
  return v;
}
template <class T>
Json value_of(const T& v) {
  return v;
}
Json value_of(const std::vector<double>& values) {
  Json out = Json::array();
  // a curve that does not apply is left out
  if (std::all_of(values.begin(), values.end(), [](double v) { return std::isnan(v); })) return out;
  for (const double v : values) out.push_back(value_of(v));
  return out;
}
Json value_of(PointStatus s) { return name_of(s); }

void read_value(const Json& j, double& v) {
  if (j.is_null())
    v = NAN;
  else if (j.is_string())
    v = j.get<std::string>() == "-inf" ? -INFINITY : INFINITY;
  else
    v = j.get<double>();
}
void read_value(const Json& j, std::vector<double>& values) {
  values.assign(j.size(), 0);
  for (std::size_t k = 0; k < j.size(); ++k) read_value(j[k], values[k]);
}
template <class T>
void read_value(const Json& j, T& v) {
  if (!j.is_null()) v = j.get<T>();
}
void read_value(const Json& j, PointStatus& s) {
  for (const PointStatus k :
       {PointStatus::ok, PointStatus::diverged, PointStatus::nan, PointStatus::refused, PointStatus::slow})
    if (j.get<std::string>() == name_of(k)) {
      s = k;
      return;
    }
  throw std::runtime_error("unknown status '" + j.get<std::string>() + "'");
}

struct Writer {
  Json out = Json::object();
  template <class T>
  void operator()(const char* key, const T& v) {
    out[key] = value_of(v);
  }
};
struct Reader {
  const Json& in;
  template <class T>
  void operator()(const char* key, T& v) {
    if (in.contains(key)) read_value(in[key], v);
  }
};

template <class P, class V>
void fields(P& p, V& v, const StudyPoint*) {
  v("index", p.index), v("method", p.method), v("order", p.order), v("h_s", p.h_s), v("tol", p.tol),
      v("iters", p.iters);
  v("substeps", p.substeps), v("settings", p.settings), v("way", p.refinement_axis), v("machine", p.machine),
      v("status", p.status), v("status_t_s", p.status_t_s), v("reason", p.reason);
  v("completed", p.completed), v("below_floor", p.below_floor), v("noise", p.noise), v("steps", p.count.steps),
      v("rejected", p.count.rejected);
  v("force_evals", p.count.force_evals), v("jac_evals", p.count.jac_evals), v("linear_solves", p.count.linear_solves);
  v("cg_iters", p.count.cg_iters), v("sweeps", p.count.sweeps), v("unconverged", p.count.unconverged),
      v("work", p.work);
  v("instr", p.instr), v("t_min_s", p.t_min_s), v("t_med_s", p.t_med_s), v("t_p90_s", p.t_p90_s), v("n_rep", p.n_rep);
  v("noisy", p.noisy), v("rtf", p.rtf), v("err_end", p.err_end), v("err_end_v", p.err_end_v),
      v("err_traj_rms", p.err_traj_rms);
  v("err_traj_max", p.err_traj_max), v("err_orient_rad", p.err_orient_rad), v("err_energy_max", p.err_energy_max);
  v("err_energy_drift_per_s", p.err_energy_drift_per_s), v("err_mom", p.err_mom), v("err_angmom", p.err_angmom);
  v("err_constraint", p.err_constraint), v("err_event_s", p.err_event_s), v("err_horizon_s", p.err_horizon_s);
  v("mescd", p.mescd), v("peak_bytes", p.peak_bytes), v("on_front_time", p.on_front_time),
      v("on_front_work", p.on_front_work);
}
template <class P, class V>
void fields(P& m, V& v, const MethodInfo*) {
  v("name", m.name), v("summary", m.summary), v("order", m.order), v("evals_per_step", m.evals_per_step),
      v("limit_hw", m.limit_hw);
  v("implicit", m.implicit), v("adaptive", m.adaptive);
}
template <class P, class V>
void fields(P& p, V& v, const ProblemParam*) {
  v("name", p.name), v("value", p.value), v("default", p.fallback), v("help", p.help), v("lo", p.lo), v("hi", p.hi);
  v("choices", p.choices);
}
template <class P, class V>
void fields(P& p, V& v, const ProblemInfo*) {
  v("name", p.name), v("summary", p.summary), v("family", p.family), v("t_end", p.t_end), v("dof", p.dof);
  v("x_scale", p.x_scale), v("v_scale", p.v_scale), v("E_scale", p.energy_scale), v("E_start", p.energy_start);
  v("frequency", p.frequency), v("chaotic", p.chaotic), v("conserves_momentum", p.conserves_momentum);
  v("conserves_angular", p.conserves_angular), v("dense", p.dense), v("own_measure", p.own_measure);
  v("threads", p.threads);
}
template <class P, class V>
void fields(P& s, V& v, const StudySeries*) {
  v("point", s.point), v("t", s.t), v("err", s.err), v("energy", s.energy), v("momentum", s.momentum),
      v("angmom", s.angmom);
}

template <class T>
Json written(const T& value) {
  Writer w;
  fields(value, w, static_cast<const T*>(nullptr));
  return w.out;
}
template <class T>
T read(const Json& j) {
  T value;
  Reader r{j};
  fields(value, r, static_cast<const T*>(nullptr));
  return value;
}
template <class T>
Json list(const std::vector<T>& values) {
  Json out = Json::array();
  for (const T& v : values) out.push_back(written(v));
  return out;
}

Json reference_json(const ReferenceInfo& r) {
  return {{"kind", name_of(r.kind)},
          {"digits", r.digits},
          {"uncertainty", value_of(r.uncertainty)},
          {"rounding", value_of(r.rounding)},
          {"floor", value_of(r.floor())},
          {"resolution", value_of(r.resolution)},
          {"source", r.source}};
}

ReferenceInfo read_reference(const Json& j) {
  ReferenceInfo r;
  for (const ReferenceKind k :
       {ReferenceKind::closed, ReferenceKind::quad, ReferenceKind::published, ReferenceKind::self})
    if (j.at("kind").get<std::string>() == name_of(k)) r.kind = k;
  r.digits = j.value("digits", 15);
  if (j.contains("uncertainty")) read_value(j["uncertainty"], r.uncertainty);
  if (j.contains("rounding")) read_value(j["rounding"], r.rounding);
  if (j.contains("resolution")) read_value(j["resolution"], r.resolution);
  r.source = j.value("source", "");
  return r;
}

Json problem_json(const ProblemInfo& p) {
  Json out = written(p);
  out["params"] = list(p.params);
  out["reference"] = reference_json(p.reference);
  return out;
}

ProblemInfo read_problem(const Json& j) {
  ProblemInfo p = read<ProblemInfo>(j);
  for (const Json& param : j.at("params")) p.params.push_back(read<ProblemParam>(param));
  p.reference = read_reference(j.at("reference"));
  return p;
}

Json derived_fits(const StudyResult& r) {
  Json out = Json::array();
  for (const OrderFit& f : r.fits)
    out.push_back({{"method", f.method},
                   {"axis", f.axis},
                   {"slope", value_of(f.slope)},
                   {"expected", value_of(f.expected)},
                   {"rms", value_of(f.rms)},
                   {"off", f.off()},
                   {"range", {value_of(f.lo), value_of(f.hi)}},
                   {"points", f.points},
                   {"settings", f.settings}});
  return out;
}

Json derived_costs(const StudyResult& r) {
  Json out = Json::array();
  for (const CostToAccuracy& c : r.cost_to_accuracy)
    out.push_back({{"target", c.target},
                   {"method", c.method},
                   {"h_s", value_of(c.h_s)},
                   {"tol", value_of(c.tol)},
                   {"force_evals", value_of(c.force_evals)},
                   {"work", value_of(c.work)},
                   {"time_s", value_of(c.time_s)},
                   {"cheapest_work", c.cheapest_work},
                   {"cheapest_time", c.cheapest_time}});
  return out;
}

}  // namespace

Json study_json(const StudyResult& r, const StudyContext& context) {
  Json series = Json::array(), front_time = Json::array(), front_work = Json::array();
  // a part keeps all curves, because only the whole knows which ones are drawn
  if (r.points.size() < r.planned)
    for (const StudySeries& s : r.series) series.push_back(written(s));
  else
    for (const StudySeries* s : drawn_series(r)) series.push_back(written(*s));
  for (const std::size_t k : r.front_time) front_time.push_back(r.points[k].index);
  for (const std::size_t k : r.front_work) front_work.push_back(r.points[k].index);
  return {{"schema", "accuracy/1"},
          {"study", identity_json(r)},
          {"run", machine_json(context.machine)},
          {"command", context.command},
          {"settings", context.settings},
          {"problem", problem_json(r.problem)},
          {"methods", list(r.methods)},
          {"plan", {{"points", r.planned}, {"shard", r.shard}, {"shards", r.shards}}},
          {"weights",
           {{"jacobian", r.weights.jacobian},
            {"cg_iteration", r.weights.cg_iteration},
            {"direct_solve", r.weights.direct_solve}}},
          {"points", list(r.points)},
          {"fits", derived_fits(r)},
          {"front", {{"time", front_time}, {"force", front_work}}},
          {"cost_to_accuracy", derived_costs(r)},
          {"gate", context.gate.empty() ? Json{{"baseline", nullptr}, {"violations", Json::array()}} : context.gate},
          {"series", series}};
}

StudyResult study_from_json(const Json& j) {
  if (!j.is_object() || j.value("schema", "") != "accuracy/1")
    throw std::runtime_error("expected the schema accuracy/1");
  try {
    StudyResult r;
    r.problem = read_problem(j.at("problem"));
    for (const Json& m : j.at("methods")) r.methods.push_back(read<MethodInfo>(m));
    const Json& plan = j.at("plan");
    r.planned = plan.at("points").get<std::size_t>();
    r.shard = plan.at("shard").get<int>();
    r.shards = plan.at("shards").get<int>();
    const Json& w = j.at("weights");
    read_identity(j.value("study", Json::object()), r.provenance);
    r.weights = {w.at("jacobian").get<double>(), w.at("cg_iteration").get<double>(),
                 w.at("direct_solve").get<double>()};
    for (const Json& p : j.at("points")) r.points.push_back(read<StudyPoint>(p));
    if (j.contains("series"))
      for (const Json& s : j.at("series")) r.series.push_back(read<StudySeries>(s));
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
  return {{"point", written(f.point)}, {"series", written(f.series)}, {"problem", problem_json(problem)}};
}

FinishedPoint finished_from_json(const Json& j, ProblemInfo& problem) {
  try {
    problem = read_problem(j.at("problem"));
    return {read<StudyPoint>(j.at("point")), read<StudySeries>(j.at("series"))};
  } catch (const Json::exception& e) {
    throw std::runtime_error(std::string("no point of a study: ") + e.what());
  }
}

}  // namespace feder::report
