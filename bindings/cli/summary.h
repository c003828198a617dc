// What a run ended with, as text and as JSON.
#pragma once
#include <string>

#include "cli/session.h"
#include "report/json.h"

namespace feder::cli {

struct Summary {
  std::string title, file;
  double seconds = 0;  // simulated
  std::uint64_t steps = 0;
  double ms_per_step = 0;
  int threads = 1;
  std::vector<KindCount> counts;
  std::string hash;  // 16 hex digits; empty without a world
  Energy energy;
  bool finite = true;
  bool interrupted = false;
  std::vector<Warning> warnings;
  std::vector<lua::HandlerError> handler_errors;
  std::vector<lua::HandlerProfile> handlers;
};

Summary summarize(Session& session);
std::string summary_text(const Summary& s);
report::Json summary_json(const Summary& s);

std::string hash_text(std::uint64_t hash);
// Passes of the step plan and Lua handlers with their time over `steps` steps.
std::string profile_text(Session& session, std::uint64_t steps);

}  // namespace feder::cli
