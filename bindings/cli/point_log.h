// points.jsonl: the points of a study as they finish, a whole line each, so that a study that is stopped loses nothing
// and --resume goes on. The first line names the study; a last line that was cut off is dropped.
#pragma once
#include <cstdio>
#include <memory>
#include <string>

#include "feder/study.h"
#include "report/json.h"

namespace feder::cli {

class PointLog {
 public:
  // In `folder`, for the study with this identity (report/study_identity.h). With `resume` the points of a file that is
  // there are read; Failure (1) when it belongs to another study, naming what differs.
  PointLog(const std::string& folder, const report::Json& identity, bool resume);

  // Hands what was read to the sweep, and takes what it runs.
  void attach(SweepOptions& options);
  std::size_t restored() const { return done_.size(); }

 private:
  struct Close {
    void operator()(std::FILE* f) const { std::fclose(f); }
  };
  std::string read(const std::string& file, const report::Json& identity);
  void write(const report::Json& line);

  std::string file_;
  std::unique_ptr<std::FILE, Close> out_;
  std::vector<FinishedPoint> done_;
  std::optional<ProblemInfo> learned_;
};

}  // namespace feder::cli
