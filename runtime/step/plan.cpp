#include "step/plan.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace feder {
namespace {

// Advance rows and solve rows that run each substep form the inner loop; the others run outside it.
int phase(const StepRow& row) {
  if (row.stage < Stage::advance) return 0;
  if (row.stage == Stage::finish) return 4;
  return row.when == When::before_substeps ? 1 : row.when == When::each_substep ? 2 : 3;
}

// Runs the row; `clock`: when the row before it ended, and then when this one did.
void run_row(StepRow& row, StepContext& context, std::uint64_t& clock) {
  const std::uint64_t start = clock;
  row.run(row.self, context);
  clock = clock_nanoseconds();
  row.counter.nanoseconds += clock - start;
  ++row.counter.calls;
}

}  // namespace

const char* stage_name(Stage stage) {
  static const char* const names[] = {"begin", "bounds", "broad", "narrow", "advance", "solve", "finish"};
  return names[static_cast<int>(stage)];
}

void StepPlan::clear() {
  old_ = std::move(rows_);
  rows_.clear();
}

void StepPlan::add(const StepRow& row) {
  rows_.push_back(row);
  for (const StepRow& was : old_)
    if (!std::strcmp(was.name, row.name) && !std::strcmp(was.system, row.system)) rows_.back().counter = was.counter;
}

void StepPlan::finish() {
  std::stable_sort(rows_.begin(), rows_.end(), [](const StepRow& a, const StepRow& b) {
    return std::make_tuple(phase(a), a.stage, a.rank) < std::make_tuple(phase(b), b.stage, b.rank);
  });
  old_.clear();
}

void StepPlan::run(StepContext& context) {
  std::size_t i = 0;
  std::uint64_t clock = clock_nanoseconds();
  while (i < rows_.size() && phase(rows_[i]) < 2) run_row(rows_[i++], context, clock);
  const std::size_t first = i;
  while (i < rows_.size() && phase(rows_[i]) == 2) ++i;
  for (context.substep = 0; context.substep < context.substeps; ++context.substep)
    for (std::size_t k = first; k < i; ++k) run_row(rows_[k], context, clock);
  context.substep = 0;
  while (i < rows_.size()) run_row(rows_[i++], context, clock);
}

void StepPlan::reset_counters() {
  for (StepRow& row : rows_) row.counter = {};
}

}  // namespace feder
