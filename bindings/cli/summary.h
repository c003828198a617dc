// What a run ended with, as text and as JSON.
#pragma once
#include <string>

#include "cli/session.h"
#include "report/json.h"

namespace feder::cli {

// The world at the end; as it stands where there is none.
struct Summary {
  double seconds = 0;  // simulated
  int threads = 1;
  std::vector<KindCount> counts;
  std::string hash;  // 16 hex digits; empty without a world
  Energy energy;
  bool finite = true;
  bool interrupted = false;
};

Summary summarize(Session& session);
std::string summary_text(Session& session, const Summary& s);
report::Json summary_json(Session& session, const Summary& s);
report::Json handlers_json(Session& session);

std::string hash_text(std::uint64_t hash);
// Passes of the step plan and Lua handlers with their time over `steps` steps.
std::string profile_text(Session& session, std::uint64_t steps);

}  // namespace feder::cli
