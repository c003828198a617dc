// What feder.advise and `feder explain` say about a world before it runs: one row per net.
#pragma once
#include <string>
#include <vector>

#include "lua/state.h"
#include "springs/springs.h"
#include "world/world.h"

namespace feder::lua {

struct AdviceRow {
  NetAdvice numbers;
  std::string object;        // "net 'rope'"
  const char* verdict = "";  // "stable", "unstable", "never stable"
  int substeps = 0;          // suggested; 0: those there are do
  std::string integrator;    // suggested
  std::string error_class;   // "1e-2": the decade above the error of the fastest mode per period; "exact", "tolerance"
  std::string text;          // all of it in a sentence
};

std::vector<AdviceRow> advise(World& world);

int feder_advise(lua_State* L);

}  // namespace feder::lua
