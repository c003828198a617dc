#include "cli/recording.h"

#include <sstream>

#include "report/build_info.h"

namespace feder::cli {

RecordFile::RecordFile(const std::string& file, const std::string& scene, const Options& options, int hash_every)
    : name_(file) {
  RecordingFacts facts = {{"feder", FEDER_VERSION},
                          {"commit", report::build_commit()},
                          {"compiler", report::build_compiler()},
                          {"simd", report::simd_path()},
                          {"scene", scene}};
  // what a user has put in
  for (const std::string& s : options.set) facts.emplace_back("--set", s);
  for (const std::string& s : options.world) facts.emplace_back("--world", s);
  if (!options.dt.empty()) facts.emplace_back("--dt", options.dt);
  if (!options.seed.empty()) facts.emplace_back("--seed", options.seed);
  if (options.threads > 0) facts.emplace_back("--threads", std::to_string(options.threads));
  try {
    file_ = std::make_unique<report::OutputFile>(file);
  } catch (const std::runtime_error& e) {
    throw Failure(kFailed, e.what());
  }
  recorder_ = std::make_unique<Recorder>(
      [out = &file_->stream()](std::string_view bytes) {
        out->write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      },
      facts, hash_every);
}

void RecordFile::close(const std::vector<std::filesystem::path>& files, const std::string& how) {
  RecordingFacts texts;
  for (const auto& path : files) texts.emplace_back("file " + path.string(), read_text(path.string()));
  recorder_->add_facts(texts);
  recorder_->finish(how);
  try {
    file_->close();
  } catch (const std::runtime_error& e) {
    throw Failure(kFailed, e.what());
  }
}

namespace {

// What a recording refuses, with the file's name.
template <class F>
auto with_name(const std::string& file, F&& f) {
  try {
    return f();
  } catch (const SceneError& e) {
    throw Failure(kLoadError, file + ": " + e.what());
  }
}

}  // namespace

Recording read_recording(const std::string& file) {
  std::string bytes = read_text(file, "a recording", 4096);
  return with_name(file, [&] { return Recording(std::move(bytes)); });
}

std::unique_ptr<Replay> make_replay(const std::string& file, const Recording& recording, std::size_t world,
                                    const Options& options) {
  return with_name(file,
                   [&] { return std::make_unique<Replay>(recording, world, options.build.systems, options.threads); });
}

bool step_replay(const std::string& file, Replay& replay, std::vector<RecordedCommand>* commands) {
  return with_name(file, [&] { return replay.step(commands); });
}

std::string recorded_by(const Recording& recording) {
  std::string text = "feder " + recording.fact("feder");
  for (const std::string& more : {recording.fact("commit"), recording.fact("compiler"), recording.real()})
    if (!more.empty()) text += (more == recording.fact("commit") ? " " : ", ") + more;
  return text;
}

}  // namespace feder::cli
