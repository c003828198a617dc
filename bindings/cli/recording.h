// Recordings as files: what run --record writes, and what replay and diff read.
#pragma once
#include <memory>
#include <string>

#include "cli/session.h"
#include "feder/record.h"
#include "report/output_file.h"

namespace feder::cli {

// Written beside the file and put in its place by close(): without it nothing is left. Failure when it cannot be.
class RecordFile {
 public:
  RecordFile(const std::string& file, const std::string& scene, const Options& options, int hash_every);
  Recorder& recorder() { return *recorder_; }
  // `how`: "finished", or why the run ended early. The files go in by their content.
  void close(const std::vector<std::filesystem::path>& files, const std::string& how);

 private:
  std::string name_;
  std::unique_ptr<report::OutputFile> file_;
  std::unique_ptr<Recorder> recorder_;
};

// Failure (kLoadError) "file: why" when it is none, damaged, truncated or of another build.
Recording read_recording(const std::string& file);
// A replay of one of its worlds, and a step of it, with such failures.
std::unique_ptr<Replay> make_replay(const std::string& file, const Recording& recording, std::size_t world,
                                    const Options& options);
bool step_replay(const std::string& file, Replay& replay, std::vector<RecordedCommand>* commands = nullptr);
// "feder 0.4.0 ab12cd3, gcc 12.2, float"
std::string recorded_by(const Recording& recording);

}  // namespace feder::cli
