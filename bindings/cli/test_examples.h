// Counter-examples of property tests, kept in a file beside the scene: later runs try them first, and drop those that
// pass, as Hypothesis does with its database (MacIver et al. 2019). Where CI is set the file is read, not written.
#pragma once
#include <filesystem>
#include <vector>

#include "cli/test_file.h"

namespace feder::cli {

struct SavedExample {
  std::vector<std::string> given;  // words of the command line that change the run: --dt 1/240
  std::string seed;                // of --seed; empty: not given
  std::vector<std::string> set;    // NAME=VALUE, drawn and shrunk
  bool operator==(const SavedExample&) const = default;
};

class SavedExamples {
 public:
  // Those of the scene, NAME.counterexamples.json. Failure when the file is something else.
  explicit SavedExamples(const std::string& scene);

  // Those of runs with these options: the same words, and the same seed or none.
  std::vector<SavedExample> of(const TestCase& test, const Options& options) const;
  static SavedExample make(const TestCase& test, const Options& options, const Draw& draw);
  // Each changes the file, and says so; why not, where it cannot be written.
  std::string add(const SavedExample& example);
  std::string drop(const SavedExample& example);

 private:
  std::string write(const std::string& done) const;
  std::filesystem::path file_;
  std::vector<SavedExample> all_;
};

void fields(auto& e, auto& v, const SavedExample*) { v("given", e.given)("seed", e.seed)("set", e.set); }

}  // namespace feder::cli
