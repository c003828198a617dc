// An axis of a drawing: where a value lies, and which ticks a reader wants to see.
#pragma once
#include <string>
#include <vector>

namespace feder::report {

enum class TickStyle {
  power,    // 10^{-3} on decades, 2 and 5 between when there are few
  seconds,  // 10 µs, 1 ms, 1 s
  plain,    // 0.25
};

struct Tick {
  double value = 0;
  std::string label;  // empty: a minor one, a faint line of the grid
};

struct Axis {
  std::string label;  // with its unit: "run time, s"
  bool log = false;
  double lo = 0, hi = 1;
  TickStyle style = TickStyle::plain;
  std::vector<Tick> fixed = {};  // these instead of computed ones

  // 0 at `lo`, 1 at `hi`; not cut. NaN and what has no logarithm lie at 0.
  double at(double value) const;
  // Major and minor ticks within [lo, hi], ascending; at most `max_labels` labels.
  std::vector<Tick> ticks(int max_labels) const;
};

// An axis that holds all `values` with round ends; what does not lie on it (not finite; log: <= 0) is left out of
// account. At least one decade (log) or a span that is not empty (linear).
Axis fit_axis(const std::string& label, bool log, const std::vector<double>& values,
              TickStyle style = TickStyle::plain);

}  // namespace feder::report
