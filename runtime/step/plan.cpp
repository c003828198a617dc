// The step plan: passes sorted by rank, loops put around them, and a run from top to bottom with clocks per pass.
#include "feder/plan.h"

#include <algorithm>
#include <cstring>

#include "feder/error.h"

namespace feder {
namespace {

bool same(const PlanNode& a, const PlanNode& b) {
  return a.is_loop == b.is_loop && !std::strcmp(a.name, b.name) && !std::strcmp(a.system, b.system);
}

Loop loop_around(const PlanNode& n) { return n.is_loop ? kLoops[static_cast<int>(n.loop)].parent : n.loop; }

}  // namespace

void StepPlan::clear() {
  old_ = std::move(nodes_);
  nodes_.clear();
  step_end_ = 0;
}

void StepPlan::add(Place place, const char* name, const char* system, PassFunction function, void* self) {
  FEDER_ASSERT(function && self && *name && *system);
  PlanNode pass;
  pass.place = place, pass.loop = loop_of(place.rank);
  pass.name = name, pass.system = system;
  pass.run = function, pass.self = self;
  nodes_.push_back(pass);
}

void StepPlan::finish() {
  const auto earlier = [](const PlanNode& a, const PlanNode& b) { return a.place < b.place; };
  std::stable_sort(nodes_.begin(), nodes_.end(), earlier);
  // a loop goes before its first pass, the outer one first; one without passes is not there
  for (int i = kLoopCount - 1; i > 0; --i) {
    const LoopSpan& span = kLoops[i];
    const auto inside = [&](const PlanNode& n) { return n.place.rank >= span.first && n.place.rank <= span.last; };
    const auto first = std::find_if(nodes_.begin(), nodes_.end(), inside);
    if (first == nodes_.end()) continue;
    PlanNode loop;
    loop.place = before(span.first), loop.is_loop = true, loop.loop = static_cast<Loop>(i), loop.name = span.name;
    nodes_.insert(first, loop);
  }
  for (std::uint32_t k = 0; k < nodes_.size(); ++k) {
    PlanNode& n = nodes_[k];
    for (const PlanNode& was : old_)
      if (same(was, n)) n.counter = was.counter;
    if (!n.is_loop) continue;
    n.end = k + 1;
    while (n.end < nodes_.size() && nodes_[n.end].place.rank <= kLoops[static_cast<int>(n.loop)].last) ++n.end;
  }
  const auto of_step = [](const PlanNode& n) { return !(Rank::finish < n.place.rank); };
  step_end_ = static_cast<std::size_t>(std::partition_point(nodes_.begin(), nodes_.end(), of_step) - nodes_.begin());
  old_.clear();
}

void StepPlan::run(StepContext& c) {
  FEDER_ASSERT(c.substeps >= 1 && old_.empty());  // finished
  c.loops = counts_;
  counts_[static_cast<int>(Loop::substep)].count.assign(1, c.substeps);
  run_nodes(0, static_cast<std::uint32_t>(step_end_), c, true);
}

void StepPlan::run_queries(Rank last, StepContext& c) {
  FEDER_ASSERT(old_.empty() && last > Rank::finish);
  for (std::size_t k = step_end_; k < nodes_.size() && nodes_[k].place.rank <= last; ++k)
    nodes_[k].run(nodes_[k].self, c);
}

void StepPlan::run_nodes(std::uint32_t first, std::uint32_t end, StepContext& c, bool clocked) {
  std::uint64_t clock = clocked ? clock_nanoseconds() : 0;
  for (std::uint32_t k = first; k < end; ++k) {
    PlanNode& n = nodes_[k];
    if (n.is_loop) {
      run_loop(n, k + 1, c);
      k = n.end - 1;
      if (clocked) clock = clock_nanoseconds();
      continue;
    }
    n.run(n.self, c);
    ++n.counter.calls;
    if (!clocked) continue;
    const std::uint64_t now = clock_nanoseconds();
    n.counter.nanoseconds += now - clock;
    ++n.counter.clocked;
    clock = now;
  }
}

void StepPlan::run_loop(PlanNode& loop, std::uint32_t first, StepContext& c) {
  const std::uint64_t start = clock_nanoseconds();
  const bool substeps = loop.loop == Loop::substep;
  const std::vector<int>& counts = counts_[static_cast<int>(loop.loop)].count;
  int& idle = idle_[static_cast<int>(loop.loop)];
  FEDER_ASSERT(first < loop.end && loop.end <= nodes_.size());
  for (std::size_t g = 0; g < counts.size(); ++g)
    for (int k = 0; k < counts[g]; ++k) {
      if (substeps)
        c.substep = k;
      else
        c.inner = {static_cast<int>(g), k, counts[g]};
      const bool clocked = --idle < 0;
      // uneven, or loops of a multiple of kClockEvery would always show the same iterations; by a multiplicative hash
      // (Knuth, TAOCP 3, 6.4), which follows no multiple either
      const auto mixed = static_cast<std::uint32_t>(loop.counter.calls) * 2654435769u;
      if (clocked) idle = clock_every_ == 1 ? 0 : clock_every_ - 1 + static_cast<int>((mixed >> 16) % 3);
      run_nodes(first, loop.end, c, clocked);
      ++loop.counter.calls;
    }
  if (substeps)
    c.substep = 0;
  else
    c.inner = {};
  loop.counter.clocked = loop.counter.calls;
  loop.counter.nanoseconds += clock_nanoseconds() - start;
}

std::string StepPlan::path(const PlanNode& node) {
  Loop loops[kLoopCount];
  int count = 0;
  for (Loop l = loop_around(node); l != Loop::step; l = kLoops[static_cast<int>(l)].parent) loops[count++] = l;
  std::string path = kLoops[0].name;
  while (count > 0) path += '/', path += kLoops[static_cast<int>(loops[--count])].name;
  return path;
}

int StepPlan::depth(const PlanNode& node) {
  int depth = 0;
  for (Loop l = loop_around(node); l != Loop::step; l = kLoops[static_cast<int>(l)].parent) ++depth;
  return depth;
}

double StepPlan::total_nanoseconds() const {
  double sum = 0;
  for (const PlanNode& n : nodes())
    if (loop_around(n) == Loop::step) sum += n.counter.total_nanoseconds();
  return sum;
}

void StepPlan::reset_counters() {
  for (PlanNode& n : nodes_) n.counter = {};
}

}  // namespace feder
