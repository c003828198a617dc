#include "cli/point_log.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "cli/command.h"
#include "report/study_identity.h"
#include "report/study_text.h"

namespace feder::cli {

using report::Json;

PointLog::PointLog(const std::string& folder, const Json& identity, bool resume) : file_(folder + "/points.jsonl") {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const bool there = resume && std::filesystem::exists(file_, error);
  const std::string kept = there ? read(file_, identity) : "";
  // without the line that was cut off
  if (!kept.empty()) std::filesystem::resize_file(file_, kept.size(), error);
  out_.reset(error ? nullptr : std::fopen(file_.c_str(), kept.empty() ? "wb" : "ab"));
  if (!out_) throw Failure(kFailed, "feder study: {}: cannot be written", file_);
  if (kept.empty()) write({{"schema", "points/1"}, {"study", identity}});
}

// The whole lines of the file.
std::string PointLog::read(const std::string& file, const Json& identity) {
  std::string text = report::read_bytes(file);
  text.resize(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    try {
      const Json json = Json::parse(line);
      if (++number == 1) {
        const auto differs = report::identity_differences(identity, json.at("study"));
        if (!differs.empty())
          throw Failure(kFailed, "feder study: --resume: {} holds another study: {}", file, fmt::join(differs, "; "));
        continue;
      }
      ProblemInfo problem;
      FinishedPoint point = report::finished_from_json(json, problem);
      const bool again =
          std::ranges::any_of(done_, [&](const FinishedPoint& d) { return d.point.index == point.point.index; });
      if (again) continue;
      done_.push_back(std::move(point));
      learned_ = std::move(problem);
    } catch (const Json::exception& e) {
      throw Failure(kFailed, "{}:{}: no point of a study: {}", file, number, e.what());
    } catch (const std::runtime_error& e) {
      if (dynamic_cast<const Failure*>(&e)) throw;
      throw Failure(kFailed, "{}:{}: {}", file, number, e.what());
    }
  }
  return text;
}

void PointLog::attach(SweepOptions& options) {
  options.done = std::move(done_);
  options.learned = std::move(learned_);
  options.finished = [this](const FinishedPoint& point, const ProblemInfo& problem) {
    write(report::finished_json(point, problem));
  };
}

void PointLog::write(const Json& line) {
  const std::string text = line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  if (std::fwrite(text.data(), 1, text.size(), out_.get()) != text.size() || std::fflush(out_.get()) != 0)
    throw Failure(kFailed, "feder study: {}: cannot be written", file_);
}

}  // namespace feder::cli
