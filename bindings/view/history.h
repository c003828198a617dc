// The last seconds of a world as snapshots, and what happened in them. Scrubbing shows these moments; it runs nothing.
#pragma once
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

namespace feder::view {

struct Moment {
  std::uint64_t step = 0;
  double time = 0;    // s, simulated
  std::string image;  // World::snapshot after that step
};

// Something on the timeline.
struct Mark {
  std::uint64_t step = 0;
  double time = 0;
  std::string kind;   // "warning", "joint_break", "sleep", "error", "hand", "reload" ...
  std::string label;  // of the first of that kind in the step
  int count = 1;
};

// Contract, checked by tests/view/test_window_history.cpp:
//  - moments come in with growing steps; those older than `seconds` before the newest go, except one;
//  - above `bytes` the older ones are thinned out, every second at a time; the newest kDense always stay.
class History {
 public:
  History(double seconds, std::size_t bytes) : seconds_(seconds), limit_(bytes) {}

  void add(Moment moment);
  void mark(std::uint64_t step, double time, const std::string& kind, const std::string& label);
  void cut_after(std::uint64_t step);  // what came later never happened
  void clear();

  bool empty() const { return moments_.empty(); }
  std::size_t size() const { return moments_.size(); }
  std::size_t bytes() const { return bytes_; }
  const Moment& first() const { return moments_.front(); }
  const Moment& last() const { return moments_.back(); }
  // The latest moment at or before a step; the first one when there is none.
  const Moment& at(std::uint64_t step) const;
  const Moment* before(std::uint64_t step) const;  // strictly
  const Moment* after(std::uint64_t step) const;   // strictly
  const std::deque<Mark>& marks() const { return marks_; }

 private:
  static constexpr std::size_t kDense = 30;  // newest moments that are never thinned out
  static constexpr std::size_t kMarks = 500;

  void thin_out();

  double seconds_;
  std::size_t limit_, bytes_ = 0;
  std::deque<Moment> moments_;
  std::deque<Mark> marks_;
};

}  // namespace feder::view
