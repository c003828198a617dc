#include "report/study_identity.h"

#include <fmt/format.h>

#include <stdexcept>

#include "base/hash.h"
#include "feder/snapshot.h"
#include "report/study_text.h"

namespace feder::report {
namespace {

std::string hex_hash(const std::string& text) {
  Hash hash;
  hash.bytes(text.data(), text.size());
  return fmt::format("{:016x}", hash.value());
}

std::string hash_of(Json fields) {
  fields.erase("hash");
  return hex_hash(to_text(fields));
}

std::string shown(const Json& fields, const std::string& key) {
  if (!fields.contains(key)) return "nothing";
  const Json& value = fields[key];
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

std::string plan_hash(const std::vector<PlannedPoint>& plan) {
  std::string text;
  for (const PlannedPoint& p : plan)
    text += fmt::format("{} {} {} {} {} {} {} {}\n", p.index, p.spec.method, p.spec.steps, p.spec.tolerance,
                        p.spec.iterations, p.spec.substeps, settings_text(p.spec.settings), p.spec.refinement_axis);
  return hex_hash(text);
}

std::string file_hash(const std::string& file) { return hex_hash(read_bytes(file)); }

Json identity_json(const StudyResult& r) {
  Json params = Json::object();
  for (const ProblemParam& param : r.problem.params) params[param.name] = param.value;
  Json out = {
      {"problem", r.problem.name}, {"params", params}, {"t_end", r.problem.t_end}, {"threads", r.problem.threads}};
  out.update(written(r.provenance));
  out["points"] = r.planned;
  out["hash"] = hash_of(out);
  return out;
}

std::vector<std::string> altered_fields(const Json& report) {
  std::vector<std::string> out;
  const Json study = report.value("study", Json::object()), run = report.value("run", Json::object());
  if (!study.contains("hash") || study["hash"] != hash_of(study)) out.emplace_back("study.hash");
  const auto same = [&](const char* key, const Json& beside, const std::string& where) {
    if (shown(study, key) != shown(beside, where.substr(where.rfind('.') + 1))) out.push_back(where);
  };
  const Json build = run.value("build", Json::object());
  same("git", run, "run.git"), same("tool", run, "run.tool"), same("real", build, "run.build.real");
  same("points", report.value("plan", Json::object()), "plan.points");
  same("problem", {{"name", report.value("problem", Json::object()).value("name", "")}}, "problem.name");
  return out;
}

std::vector<std::string> identity_differences(const Json& expected, const Json& found) {
  std::vector<std::string> out;
  for (const auto& item : expected.items())
    if (item.key() != "hash" && shown(found, item.key()) != shown(expected, item.key()))
      out.push_back(
          fmt::format("{} is {}, expected {}", item.key(), shown(found, item.key()), shown(expected, item.key())));
  if (out.empty() && shown(found, "hash") != shown(expected, "hash")) out.emplace_back("hash");
  return out;
}

}  // namespace feder::report
