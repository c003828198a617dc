// run --csv and --track: what a run was, step by step: time, energy, every feder.plot, and the state of named objects.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "cli/csv_table.h"
#include "cli/session.h"
#include "report/states.h"

namespace feder::cli {

class Trace {
 public:
  // `names`: of objects, with * and ? for any text and any character.
  Trace(const std::string& file, std::vector<std::string> names);

  // The state now; the row is written by the next call, so that it has what scripts plot until then.
  void record(Session& session, World& world);
  // The rest of the file. Returns what went wrong with the names ("--track: nothing is called ..."), or "".
  std::string close(Session& session);

 private:
  struct Tracked {
    ObjectId object;
    const report::StateReader* reader;
    std::size_t column;  // its first one
  };

  void find_objects(World& world);
  void track(World& world, ObjectId object);
  void put_objects(World& world);
  void put_plots(Session& session);
  void end_row(Session& session);

  CsvTable table_;
  std::vector<std::string> names_;
  std::vector<bool> found_;                   // by name
  std::map<std::string, int> titles_;         // of objects, how often
  std::map<std::string, std::size_t> plots_;  // columns
  std::vector<std::uint32_t> seen_;           // by slot: generation that was looked at, plus 1
  const World* world_ = nullptr;              // that those are of
  std::vector<Tracked> tracked_;
  std::vector<std::string> others_;  // names of objects that were not asked for
  report::ObjectState state_;
  double time_ = 0;
  bool open_ = false;  // a row is waiting
};

}  // namespace feder::cli
