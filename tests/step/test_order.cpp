// The tree of loops: order, nesting, groups, counters.
#include "feder/plan.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::vector<std::string> order;

void write(void* self, StepContext& c) {
  order.push_back(static_cast<const char*>(self) + std::string(" ") + std::to_string(c.inner.group) +
                  std::to_string(c.inner.index) + (c.inner.last() ? "!" : ""));
}
void choose(void*, StepContext& c) { c.counts(Loop::surface).count = {2, 0, 1}; }

void add(StepPlan& plan, Place place, const char* name) {
  plan.add(place, name, "test", &write, const_cast<char*>(name));
}

std::size_t find(const StepPlan& plan, const std::string& name) {
  for (std::size_t k = 0; k < plan.nodes().size(); ++k)
    if (plan.nodes()[k].name == name) return k;
  return plan.nodes().size();
}

}  // namespace

TEST_CASE("loops are runs of ranks that nest", "[step][order]") {
  for (int i = 1; i < kLoopCount; ++i) {
    const LoopSpan& span = kLoops[i];
    const LoopSpan& around = kLoops[static_cast<int>(span.parent)];
    CAPTURE(span.name);
    CHECK(span.first <= span.last);
    CHECK(around.first <= span.first);
    CHECK(span.last <= around.last);
    CHECK(static_cast<int>(span.parent) < i);  // loop_of takes the last that fits
    CHECK(loop_of(span.first) == static_cast<Loop>(i));
    for (int k = i + 1; k < kLoopCount; ++k)
      CHECK((kLoops[k].parent == static_cast<Loop>(i) || kLoops[k].first > span.last || kLoops[k].last < span.first));
  }
}

TEST_CASE("a plan runs its ranks in order, each group its whole loop before the next", "[step][order]") {
  StepPlan plan;
  add(plan, Rank::surface_rows, "rows");
  add(plan, Rank::finish, "finish");
  add(plan, Rank::cloth_integrate, "advance");
  add(plan, after(Rank::body_forces), "after");
  add(plan, Rank::body_forces, "forces");
  add(plan, before(Rank::body_forces), "before");
  plan.add(Rank::cloth_forces, "choose", "test", &choose, &order);
  plan.finish();
  StepContext c;
  c.substeps = 2;
  order.clear();
  plan.run(c);
  const std::vector<std::string> substep = {"before 00!",  "forces 00!", "after 00!",   "advance 00", "rows 00",
                                            "advance 01!", "rows 01!",   "advance 20!", "rows 20!"};
  std::vector<std::string> expected = substep;
  expected.insert(expected.end(), substep.begin(), substep.end());
  expected.push_back("finish 00!");
  CHECK(order == expected);

  const auto nodes = plan.nodes();
  const PlanNode& loop = nodes[find(plan, "surface substeps")];
  CHECK(loop.is_loop);
  CHECK(loop.counter.calls == 6);
  CHECK(StepPlan::path(loop) == "step/substep");
  CHECK(StepPlan::depth(loop) == 1);
  const PlanNode& rows = nodes[find(plan, "rows")];
  CHECK(rows.counter.calls == 6);
  CHECK(StepPlan::path(rows) == "step/substep/surface substeps");
  CHECK(StepPlan::path(nodes[find(plan, "finish")]) == "step");
  CHECK(find(plan, "fluid substeps") == nodes.size());  // no passes, no loop
}

TEST_CASE("passes of loops are counted always and clocked sometimes; counters outlive a new plan", "[step][order]") {
  StepPlan plan;
  const auto fill = [&] {
    plan.clear();
    plan.add(
        Rank::cloth_forces, "choose", "test", [](void*, StepContext& c) { c.counts(Loop::surface).count = {100}; },
        &order);
    plan.add(
        Rank::surface_rows, "rows", "test", [](void*, StepContext&) {}, &order);
    plan.finish();
  };
  fill();
  StepContext c;
  plan.run(c);
  fill();
  plan.run(c);
  const PlanNode& rows = plan.nodes()[find(plan, "rows")];
  CHECK(rows.counter.calls == 200);
  CHECK(rows.counter.clocked > 20);
  CHECK(rows.counter.clocked < 40);
  plan.reset_counters();
  plan.clock_every(1);
  plan.run(c);
  CHECK(rows.counter.clocked == 100);
}

TEST_CASE("the clock shows first iterations as often as others, whatever the number of iterations", "[step][order]") {
  // contact searches in the first iteration of a loop: bench shows its cost by its share of the clocked ones
  const int iterations = GENERATE(2, 3, 6, 7, 8, 9, 11, 14, 16, 21, 56);
  StepPlan plan;
  static const PlanNode* rows;
  static int count;
  static std::uint64_t before, first_clocked;
  count = iterations, first_clocked = 0;
  plan.add(
      Rank::cloth_forces, "choose", "test", [](void*, StepContext& c) { c.counts(Loop::surface).count = {count}; },
      &order);
  plan.add(
      Rank::surface_rows, "rows", "test",
      [](void*, StepContext& c) {  // a pass is counted behind it
        if (c.inner.index == 0) before = rows->counter.clocked;
        if (c.inner.index == 1) first_clocked += rows->counter.clocked - before;
      },
      &order);
  plan.finish();
  rows = &plan.nodes()[find(plan, "rows")];
  StepContext c;
  for (int k = 0; k < 20000 / iterations; ++k) plan.run(c);
  const double share = double(first_clocked) / double(rows->counter.clocked) * iterations;
  CAPTURE(iterations, first_clocked, rows->counter.clocked);
  CHECK(share > 0.8);
  CHECK(share < 1.25);
}

TEST_CASE("passes between steps run when asked for, up to the rank that was asked", "[step][order]") {
  StepPlan plan;
  add(plan, Rank::query_boundary, "walls");
  add(plan, Rank::begin, "begin");
  add(plan, Rank::query_colliders, "colliders");
  plan.finish();
  CHECK(plan.nodes().size() == 1);  // of a step
  StepContext c;
  order.clear();
  plan.run(c);
  CHECK(order == std::vector<std::string>{"begin 00!"});
  plan.run_queries(Rank::query_colliders, c);
  CHECK(order.size() == 2);
  plan.run_queries(Rank::query_boundary, c);
  CHECK(order == std::vector<std::string>{"begin 00!", "colliders 00!", "colliders 00!", "walls 00!"});
}
