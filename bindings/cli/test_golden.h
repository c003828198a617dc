// Golden runs: where objects were and what energies the world had, at moments of a run, in a file beside the scene. A
// later run is compared: equal where states have equal hashes, else by a tolerance per quantity. The file is written
// only by --update-golden.
#pragma once
#include "cli/session.h"
#include "report/test_report.h"

namespace feder::cli {

struct GoldenSample {
  double time = 0;  // s
  std::string hash;
  std::vector<double> energy;              // kinetic, potential, elastic, J
  std::vector<std::string> names;          // of objects, each once
  std::vector<std::vector<double>> poses;  // x y z, and x y z w of bodies
};

struct GoldenFile {
  std::vector<GoldenSample> samples;
  std::vector<std::string> hashes;  // of the state before the first step and after each
};

class GoldenRun {
 public:
  // Of the session's scene, which declares one.
  explicit GoldenRun(Session& session);
  // Before the first step and after each.
  void look();
  // At the end: what differs, as failures; a line about the rest in the notice. `update`: writes the file instead.
  void finish(bool update, report::TestResult& result);

 private:
  std::string file() const;
  void write(report::TestResult& result) const;

  Session& session_;
  lua::GoldenWish wish_;
  std::uint64_t every_ = 1;  // steps
  GoldenFile run_;
};

void fields(auto& s, auto& v, const GoldenSample*) {
  v("time", s.time)("hash", s.hash)("energy", s.energy)("names", s.names)("poses", s.poses);
}

}  // namespace feder::cli
