// Loops over coloured elements: a colour is a run of batches of which no two elements share a point.
#pragma once
#include "base/jobs.h"
#include "feder/error.h"

namespace feder {

// f(first, last, thread) over the batches of each colour, colour after colour; in one go where one thread runs, as
// batches lie in the order of their colours. `stages`: work memory, which outlives the call.
template <std::size_t kStages, class Colors, class F>
void for_colors(const Colors& colors, const JobGrain& grain, JobPool::Stage (&stages)[kStages], JobPool& jobs, F&& f) {
  if (colors.empty()) return;
  FEDER_ASSERT(colors.front().first == 0);
  if (jobs.threads() == 1) return f(colors.front().first, colors.back().last, 0);
  // one loop; colours beyond kStages follow in loops of their own
  std::size_t count = 0;
  for (const auto& color : colors) {
    stages[count++] = JobPool::stage(color.first, color.last, grain, f);
    if (count < kStages && &color != &colors.back()) continue;
    jobs.run_stages({stages, count});
    count = 0;
  }
}

}  // namespace feder
