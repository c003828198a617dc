#include "report/study_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "report/table.h"
#include "report/xml.h"

namespace feder::report {
namespace {

constexpr ErrorNorm kNorms[] = {
    {"end", "err_end", "end error, relative", &StudyPoint::err_end},
    {"traj", "err_traj_rms", "trajectory error (rms), relative", &StudyPoint::err_traj_rms},
    {"max", "err_traj_max", "largest trajectory error, relative", &StudyPoint::err_traj_max},
    {"energy", "err_energy_max", "largest energy error, relative", &StudyPoint::err_energy_max},
    {"drift", "err_energy_drift_per_s", "energy drift, relative, 1/s", &StudyPoint::err_energy_drift_per_s},
    {"momentum", "err_mom", "momentum error, relative", &StudyPoint::err_mom},
    {"angular", "err_angmom", "angular momentum error, relative", &StudyPoint::err_angmom},
    {"constraint", "err_constraint", "largest violation, relative", &StudyPoint::err_constraint},
    {"event", "err_event_s", "time error of the event, s", &StudyPoint::err_event_s},
    {"orient", "err_orient_rad", "orientation error at the end, rad", &StudyPoint::err_orient_rad},
    {"horizon", "err_horizon_s", "time until the trajectory error exceeds 1e-3, s", &StudyPoint::err_horizon_s, true},
};
constexpr CostAxis kAxes[] = {
    {"time", "run time (least of the repeats)", [](const StudyPoint& p) { return p.t_min_s; }, true},
    {"force", "work, in force evaluations", [](const StudyPoint& p) { return p.work; }, false},
    {"instr", "instructions", [](const StudyPoint& p) { return p.instr; }, false},
};

// "" where something does not apply.
std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }
std::string cell(std::int64_t value) { return value < 0 ? "" : fmt::format("{}", value); }
std::string cell(int value) { return value < 0 ? "" : fmt::format("{}", value); }
std::string cell(bool value) { return value ? "1" : "0"; }

// RFC 4180.
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

}  // namespace

bool ErrorNorm::ranks(const ProblemInfo& problem) const {
  if (problem.chaotic) return value == &StudyPoint::err_horizon_s;
  return value == (problem.own_measure ? &StudyPoint::err_end : &StudyPoint::err_traj_rms);
}

const ErrorNorm* find_norm(const std::string& name) {
  for (const ErrorNorm& n : kNorms)
    if (name == n.name) return &n;
  return nullptr;
}

std::vector<std::string> norm_names() {
  std::vector<std::string> out;
  for (const ErrorNorm& n : kNorms) out.emplace_back(n.name);
  return out;
}

const CostAxis* find_axis(const std::string& name) {
  for (const CostAxis& a : kAxes)
    if (name == a.name) return &a;
  return nullptr;
}

std::string csv_header() {
  return "problem,method,order,h_s,tol,iters,substeps,status,status_t_s,steps,rejected,force_evals,jac_evals,linear_"
         "solves,"
         "cg_iters,sweeps,instr,t_min_s,t_med_s,t_p90_s,n_rep,noisy,rtf,err_end,err_traj_rms,err_traj_max,err_energy_"
         "max,"
         "err_energy_drift_per_s,err_mom,err_angmom,err_constraint,err_event_s,mescd,peak_bytes,on_front_time,on_front_"
         "work,settings,overrides,threads,real,git,scene_hash,machine";
}

std::string settings_text(const Settings& settings) {
  std::string out;
  for (const auto& [name, value] : settings) out += (out.empty() ? "" : "; ") + name + "=" + value;
  return out;
}

std::string csv_measured(const std::string& problem, const StudyPoint& p) {
  std::string row = quoted(problem);
  const auto add = [&](const std::string& text) { row += "," + text; };
  const auto numbers = [&](auto... values) { (add(cell(values)), ...); };
  add(quoted(p.method));
  numbers(p.order, p.h_s, p.tol, p.iters, p.substeps);
  add(name_of(p.status));
  numbers(p.status_t_s, p.count.steps, p.count.rejected, p.count.force_evals, p.count.jac_evals, p.count.linear_solves,
          p.count.cg_iters, p.count.sweeps, p.instr, p.t_min_s, p.t_med_s, p.t_p90_s, p.n_rep, p.noisy, p.rtf,
          p.err_end, p.err_traj_rms, p.err_traj_max, p.err_energy_max, p.err_energy_drift_per_s, p.err_mom,
          p.err_angmom, p.err_constraint, p.err_event_s, p.mescd, p.peak_bytes, p.on_front_time, p.on_front_work);
  add(quoted(settings_text(p.settings)));
  return row;
}

std::string csv_row(const std::string& problem, const StudyResult& r, const StudyPoint& p) {
  std::string row = csv_measured(problem, p);
  const auto add = [&](const std::string& text) { row += "," + text; };
  const Provenance& from = r.provenance;
  add(quoted(from.overrides));
  add(cell(r.problem.threads));
  for (const std::string* text : {&from.real, &from.git, &from.scene_hash, &p.machine}) add(quoted(*text));
  return row;
}

std::string points_csv(const StudyResult& r) {
  std::string out = csv_header() + "\n";
  for (const StudyPoint& p : r.points) out += csv_row(r.problem.name, r, p) + "\n";
  return out;
}

std::string reference_text(const ReferenceInfo& reference) {
  static const char* const kinds[] = {"closed form", "high-precision run", "published digits", "self-refined run"};
  const std::string digits = reference.digits > 0 ? fmt::format(", {} digits", reference.digits) : "";
  return kinds[static_cast<int>(reference.kind)] + digits;
}

std::string rung_text(const StudyPoint& p) {
  std::string out =
      std::isfinite(p.tol) && p.tol > 0 ? "tol = " + number_text(p.tol, 3) : "h = " + number_text(p.h_s, 4) + " s";
  if (p.substeps >= 0) out += fmt::format(", {} substeps", p.substeps);
  if (p.iters >= 0) out += fmt::format(", {} iterations", p.iters);
  for (const auto& [name, value] : p.settings) out += fmt::format(", {} = {}", name, value);
  return out;
}

std::string value_text(const std::string& value) {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  return error == std::errc() && end == value.data() + value.size() ? number_text(number, 6) : value;
}

std::string problem_label(const ProblemInfo& problem) {
  std::string list;
  for (const ProblemParam& p : problem.params)
    if (p.value != p.fallback) list += (list.empty() ? "" : ", ") + p.name + " = " + value_text(p.value);
  return list.empty() ? problem.name : problem.name + " (" + list + ")";
}

std::string file_name(const std::string& label) {
  std::string out;
  for (const char c : label) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
    if (plain)
      out += c;
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out.empty() || out[0] == '.' ? "_" + out : out;
}

bool has_times(const StudyResult& r) {
  return std::any_of(r.points.begin(), r.points.end(), [](const StudyPoint& p) { return std::isfinite(p.t_min_s); });
}

}  // namespace feder::report
