// feder.plot(name, value): keeps the last values per name in a small ring, whether somebody watches or not, so that a
// scene does the same in the viewer and without.
#include "lua/plot.h"

#include <algorithm>

#include "lua/options.h"
#include "lua/records.h"

namespace feder::lua {
namespace {
constexpr std::size_t kSeries = 64;    // different names
constexpr std::size_t kPoints = 1200;  // values kept per name: 20 s at 60 steps per second
}  // namespace

int feder_plot(lua_State* L) {
  State& s = state(L);
  const std::string name = check_text(L, 1, "feder.plot: name");
  if (name.empty() || name.size() > 64) fail_here(L, "expected a name of 1 to 64 characters, got " + describe(L, 1));
  const double value = check_number(L, 2, "feder.plot(\"" + name + "\")");
  auto series = std::find_if(s.plots.begin(), s.plots.end(), [&](const PlotSeries& p) { return p.name == name; });
  if (series == s.plots.end()) {
    if (s.plots.size() == kSeries) fail_here(L, "at most " + std::to_string(kSeries) + " different names");
    s.plots.push_back({name, {}});
    series = s.plots.end() - 1;
  }
  const WorldRecord* r = s.current();
  series->points.push_back({r && r->world ? r->world->time() : 0, value});
  if (series->points.size() > kPoints) series->points.pop_front();
  return 0;
}

}  // namespace feder::lua
