// Which study a report belongs to: shards and stopped runs go together only when every field is equal.
#pragma once
#include <string>
#include <vector>

#include "feder/study.h"
#include "report/json_fields.h"

namespace feder::report {

// The hash of all planned points, of a shard or not: method, rung and settings of each.
std::string plan_hash(const std::vector<PlannedPoint>& plan);
// Of a file's bytes. std::runtime_error when it cannot be read.
std::string file_hash(const std::string& file);

// The key `study` of a report: {hash, problem, params, t_end, threads, overrides, real, git, tool, build, scene_hash,
// plan_hash, points}. `hash` is that of all other fields (FNV-1a, 16 hex digits).
Json identity_json(const StudyResult& r);
void fields(auto& p, auto& v, const Provenance*) {
  v("overrides", p.overrides)("real", p.real)("git", p.git)("tool", p.tool)("build", p.build);
  v("scene_hash", p.scene_hash)("plan_hash", p.plan_hash);
}

// What the identity says against the other parts of the same report (they are written twice): the names of fields that
// were altered. Empty when all is well.
std::vector<std::string> altered_fields(const Json& report);
// "real is double, expected float" for each field in which the two keys `study` differ.
std::vector<std::string> identity_differences(const Json& expected, const Json& found);

}  // namespace feder::report
