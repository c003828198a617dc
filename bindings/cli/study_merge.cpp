// Shards of a study put together: what belongs to another study, what was altered and what is missing is refused by
// name.
#include <algorithm>

#include "cli/command.h"
#include "cli/study_parts.h"
#include "feder/study.h"
#include "report/study_identity.h"
#include "report/study_text.h"

namespace feder::cli {
namespace {

using report::Json;

// The report of one shard, whole and unaltered.
Json read_shard(const std::string& file) {
  Json json = report::read_json(file);
  if (json.is_object() && json.value("schema", "") == "accuracy/1") {
    const auto altered = report::altered_fields(json);
    if (!altered.empty())
      throw Failure(kFailed, "{}: no longer what the study wrote: {} does not fit", file, fmt::join(altered, ", "));
  }
  return json;
}

// Shard numbers (from 1) whose points are not there.
std::string missing_shards(const StudyResult& whole, int shards) {
  std::vector<bool> there(whole.planned, false);
  for (const StudyPoint& p : whole.points)
    if (p.index < there.size()) there[p.index] = true;
  const auto n = static_cast<std::size_t>(shards);
  std::vector<int> missing;
  for (std::size_t k = 0; k < there.size(); ++k)
    if (!there[k]) missing.push_back(static_cast<int>((k + n - 1) % n) + 1);  // shard I holds index % N == I, 0 is N
  std::ranges::sort(missing);
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  return fmt::format("{}", fmt::join(missing, ", "));
}

}  // namespace

StudyResult merge_reports(const std::vector<std::string>& files, report::MachineInfo& machine) {
  std::vector<StudyResult> shards;
  Json first;
  int count = 1;
  for (const std::string& file : files) {
    try {
      const Json json = read_shard(file);
      shards.push_back(report::study_from_json(json));
      if (shards.size() == 1) {
        // measured there, not here
        machine = report::read_as<report::MachineInfo>(json.at("run"));
        first = json.at("study"), count = shards[0].shards;
        continue;
      }
      auto differs = report::identity_differences(first, json.at("study"));
      if (shards.back().shards != count)
        differs.push_back(fmt::format("shards are {}, expected {}", shards.back().shards, count));
      if (!differs.empty())
        throw Failure(kFailed, "{}: a shard of another study than {}: {}", file, files[0], fmt::join(differs, "; "));
    } catch (const Failure&) {
      throw;
    } catch (const std::exception& e) {
      const std::string what = e.what();
      throw Failure(kUsage, what.starts_with(file) ? what : file + ": " + what);
    }
  }
  StudyResult whole;
  try {
    whole = merge_shards(std::move(shards));
  } catch (const SceneError& e) {
    throw Failure(kUsage, "feder study: {}", e.what());
  }
  if (whole.points.size() < whole.planned)
    throw Failure(kFailed, "feder study: --merge: {} of {} points; missing: shard {} of {}", whole.points.size(),
                  whole.planned, missing_shards(whole, count), count);
  return whole;
}

}  // namespace feder::cli
