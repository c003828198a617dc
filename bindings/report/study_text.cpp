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

std::string settings_text(const Settings& settings) {
  std::string out;
  for (const auto& [name, value] : settings) out += (out.empty() ? "" : "; ") + name + "=" + value;
  return out;
}

std::string listed_settings(const Settings& settings) {
  std::string out;
  for (const auto& [name, value] : settings) out += fmt::format(", {} = {}", name, value);
  return out;
}

std::string csv_cell(const Settings& settings) { return csv_cell(settings_text(settings)); }

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
  return out + listed_settings(p.settings);
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

bool succeeded(const StudyPoint& p) { return p.status == PointStatus::ok || p.status == PointStatus::slow; }

bool has_times(const StudyResult& r) {
  return std::ranges::any_of(r.points, [](const StudyPoint& p) { return std::isfinite(p.t_min_s); });
}

}  // namespace feder::report
