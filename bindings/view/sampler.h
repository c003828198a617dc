// Curves and times for the panels: values over simulated time, and how long each pass of the plan and each
// handler takes. Samples a scene once per picture; computes nothing that is not asked for.
#pragma once
#include <string>
#include <vector>

#include "view/live_scene.h"

namespace feder::view {

struct CurvePoint {
  double time = 0, value = 0;
};

// The last values, oldest first.
class Curve {
 public:
  explicit Curve(std::string name, std::string unit) : name_(std::move(name)), unit_(std::move(unit)) {}
  void add(double time, double value);
  void clear() { points_.clear(); }
  const std::string& name() const { return name_; }
  const std::string& unit() const { return unit_; }
  const std::vector<CurvePoint>& points() const { return points_; }

 private:
  static constexpr std::size_t kPoints = 600;
  std::string name_, unit_;
  std::vector<CurvePoint> points_;
};

struct TimeRow {
  std::string label, detail;  // "find pairs", "collide"; or "tower.lua:23", "Lua"; of a loop its name and nothing
  int depth = 0;              // loops around it, below the step
  double ms = 0;              // per step, smoothed
  double calls = 0;           // per step
  std::uint64_t counted_ns = 0, counted_calls = 0;  // at the last sample
};

class Sampler {
 public:
  // `curves`: energy and penetration are wanted (they cost a pass over the world).
  void sample(LiveScene& live, bool curves);
  const std::vector<Curve>& curves() const { return curves_; }
  const std::vector<TimeRow>& rows() const { return rows_; }

 private:
  void sample_times(LiveScene& live);
  TimeRow& row(const std::string& label, const std::string& detail);

  std::vector<Curve> curves_ = {Curve("energy", "J"), Curve("kinetic energy", "J"), Curve("deepest contact", "mm"),
                                Curve("step", "ms")};
  std::vector<TimeRow> rows_;
  std::uint64_t generation_ = 0, step_ = 0, times_step_ = 0;
};

}  // namespace feder::view
