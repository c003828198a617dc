// Threads that a host has already (an engine's task system), in place of a world's own workers. They help, they are not
// relied on: help may come late, more often than asked or never, from any threads; the thread that steps then does all
// itself, and results are the same bits in every case.
#pragma once
#include <functional>
#include <memory>

namespace feder {

class JobPool;

// What a helping thread calls. May be kept and copied freely, and outlive the world: it then finds nothing to do.
class Helper {
 public:
  explicit Helper(std::shared_ptr<JobPool> jobs) : jobs_(std::move(jobs)) {}
  // Takes blocks of the world's loops while there are any, and returns when there have been none for some
  // microseconds. True when it did something; false also when Executor::threads are at work already.
  bool help() const;

 private:
  std::shared_ptr<JobPool> jobs_;
};

struct Executor {
  int threads = 1;  // 1 .. 64: at most so many work at once, with the one that steps; in place of WorldDesc::threads
  // Asks for up to `helpers` calls of helper.help(), on any threads, soon. It comes from the thread that steps or from
  // one that helps; it must not block, throw, or call help() itself. Empty: the world makes its own workers.
  std::function<void(const Helper& helper, int helpers)> call;
};

}  // namespace feder
