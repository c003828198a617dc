#include "cli/test_examples.h"

#include <algorithm>

#include "cli/command.h"
#include "cli/session.h"
#include "report/output_file.h"

namespace feder::cli {
namespace {

constexpr const char* kExampleSchema = "counterexamples/1";
constexpr std::size_t kKeptExamples = 100;

std::vector<std::string> given_words(const TestCase& test, Options options) {
  options.threads = 0;  // changes no result
  std::vector<std::string> words;
  add_scene_options(words, options);
  for (const std::string& set : test.set) add_options(words, {{"--set", set}});
  return words;
}

}  // namespace

SavedExamples::SavedExamples(const std::string& scene)
    : file_(std::filesystem::path(scene).replace_extension(".counterexamples.json")) {
  std::error_code ignored;
  if (!std::filesystem::exists(file_, ignored)) return;
  const report::Json json = report::Json::parse(read_text(file_.string()), nullptr, false);
  try {
    if (json.at("schema") != kExampleSchema) throw Failure(kFailed, "{}: another version", file_.string());
    report::read_into(json.at("examples"), all_);
  } catch (const report::Json::exception&) {
    throw Failure(kFailed, "{}: no counter-examples of a test; what cannot be read may be deleted", file_.string());
  }
}

std::vector<SavedExample> SavedExamples::of(const TestCase& test, const Options& options) const {
  const std::vector<std::string> given = given_words(test, options);
  std::vector<SavedExample> mine;
  std::ranges::copy_if(all_, std::back_inserter(mine), [&](const SavedExample& e) {
    return e.given == given && (options.seed.empty() || e.seed == options.seed);
  });
  return mine;
}

SavedExample SavedExamples::make(const TestCase& test, const Options& options, const Draw& draw) {
  return {given_words(test, options), options.seed, set_words(draw)};
}

std::string SavedExamples::add(const SavedExample& example) {
  std::erase(all_, example);
  all_.insert(all_.begin(), example);
  all_.resize(std::min(all_.size(), kKeptExamples));
  return write("kept in " + file_.string());
}

std::string SavedExamples::drop(const SavedExample& example) {
  std::erase(all_, example);
  return write(fmt::format("{} passes now", fmt::join(example.set, ", ")));
}

std::string SavedExamples::write(const std::string& done) const {
  if (runs_in_ci()) return "";
  try {
    if (all_.empty()) {
      std::filesystem::remove(file_);
      return done;
    }
    std::string text = fmt::format("{{\"schema\": \"{}\", \"examples\": [", kExampleSchema);
    for (const SavedExample& e : all_) text += (&e == all_.data() ? "\n" : ",\n") + report::written(e).dump();
    report::write_text(file_.string(), text + "\n]}\n");
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return done;
}

}  // namespace feder::cli
