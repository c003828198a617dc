#include "view/sampler.h"

#include <algorithm>
#include <cmath>

namespace feder::view {
namespace {

double deepest_contact(World& world) {  // m
  for (const Residual& r : world.residuals())
    if (std::string_view(r.name) == "collide.max_penetration_m") return r.value;
  return 0;
}

}  // namespace

void Curve::add(double time, double value) {
  if (!std::isfinite(value)) return;
  // a scene that was taken back draws over what it had drawn
  while (!points_.empty() && points_.back().time >= time) points_.pop_back();
  if (points_.size() == kPoints) points_.erase(points_.begin());
  points_.push_back({time, value});
}

void Sampler::sample(LiveScene& live, bool curves) {
  if (!live.has_scene() || live.in_past() || live.rewriting()) return;
  const bool fresh = generation_ != live.generation();
  if (fresh) {
    generation_ = live.generation();
    for (Curve& c : curves_) c.clear();
    rows_.clear();
    step_ = times_step_ = 0;
  }
  if (!fresh && step_ == live.world_step()) return;
  step_ = live.world_step();
  const double time = live.shown_time();
  if (curves) {
    const Energy e = live.world().energy();
    curves_[0].add(time, e.kinetic + e.potential + e.elastic);
    curves_[1].add(time, e.kinetic);
    curves_[2].add(time, deepest_contact(live.world()) * 1000);
  }
  curves_[3].add(time, live.step_seconds() * 1000);
  sample_times(live);
}

TimeRow& Sampler::row(const std::string& label, const std::string& detail) {
  for (TimeRow& r : rows_)
    if (r.label == label && r.detail == detail) return r;
  rows_.push_back({label, detail});
  return rows_.back();
}

void Sampler::sample_times(LiveScene& live) {
  // ten samples a second of simulated time are enough, and steadier
  const std::uint64_t steps = step_ - times_step_;
  if (steps < 6 && times_step_ > 0) return;
  if (steps == 0) return;
  times_step_ = step_;
  const auto count = [&](const std::string& label, const std::string& detail, int depth, std::uint64_t ns,
                         std::uint64_t calls) {
    TimeRow& r = row(label, detail);
    r.depth = depth;
    if (calls < r.counted_calls) r.counted_ns = r.counted_calls = 0;  // counters were reset
    r.counted_ns = std::min(r.counted_ns, ns);                        // what was not clocked is estimated
    const double per_step = 1.0 / static_cast<double>(steps);
    const double ms = static_cast<double>(ns - r.counted_ns) * 1e-6 * per_step;
    r.ms = r.counted_calls == 0 ? ms : r.ms + 0.3 * (ms - r.ms);
    r.calls = static_cast<double>(calls - r.counted_calls) * per_step;
    r.counted_ns = ns, r.counted_calls = calls;
  };
  for (const PlanNode& n : live.world().plan().nodes())
    count(n.name, n.system, StepPlan::depth(n), static_cast<std::uint64_t>(n.counter.total_nanoseconds()),
          n.counter.calls);
  for (const lua::HandlerProfile& p : live.script().handler_profile()) count(p.where, "Lua", 0, p.nanoseconds, p.calls);
}

}  // namespace feder::view
