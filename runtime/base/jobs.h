// A pool of worker threads. Work is cut into blocks by index only, so what is computed never depends on the number
// of threads. Contract of every loop here, checked by tests/base/test_jobs.cpp:
//  - each block is run exactly once, by whoever takes it; blocks of one stage do not see each other's writes;
//  - a body writes to places that belong to its own indices. A result per block goes to slot first / grain, and the
//    caller merges the slots in this order afterwards: the same bits for any number of threads;
//  - blocks and forks are functions of counts and of estimates that callers state (JobGrain), never of a clock;
//  - nobody waits for a thread that holds no block. A worker that never got a core costs nothing, and one that woke
//    late takes nothing of a later stage: it joins by a compare-exchange that carries the epoch (the stage's number);
//  - no allocation, and not re-entrant: a body starts no loop of the same pool.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "base/semaphore.h"
#include "feder/types.h"

namespace feder {

// How a loop is cut, and what it costs: items of a block, and what a full block takes on a common processor. An
// estimate within a factor of three will do; it decides only whether waking others is worth it.
struct JobGrain {
  std::uint32_t items;
  std::uint32_t block_ns = 10'000;  // ns
  constexpr JobGrain(std::uint32_t n, std::uint32_t ns = 10'000) : items(n), block_ns(ns) {}
};

class JobPool : public std::enable_shared_from_this<JobPool> {
 public:
  explicit JobPool(int threads = 1);  // total number including the caller; at least 1
  // Threads of others help, which `call` asks for; see Executor in feder/world.h. The pool belongs to a shared_ptr.
  using Call = std::function<void(const std::shared_ptr<JobPool>& self, int helpers)>;
  JobPool(int threads, Call call);
  ~JobPool();
  JobPool(const JobPool&) = delete;
  JobPool& operator=(const JobPool&) = delete;

  int threads() const { return threads_; }
  std::uint64_t forks() const { return forks_; }  // loops so far that asked others: the same in every run of a scene

  // One stage of a staged loop: body(first, last, worker) for blocks that cover [first, last). Made by stage();
  // refers to the body, which must outlive the loop.
  struct Stage {
    std::uint32_t first = 0, last = 0;
    JobGrain grain{1};
    void (*function)(void* body, std::uint32_t first, std::uint32_t last, int worker) = nullptr;
    void* body = nullptr;

    std::uint32_t blocks() const { return (last - first) / grain.items + ((last - first) % grain.items != 0); }
    std::uint64_t work() const { return std::uint64_t(last - first) * grain.block_ns / grain.items; }  // ns
  };

  template <class Body>
  static Stage stage(std::uint32_t first, std::uint32_t last, JobGrain grain, Body& body) {
    return {
        first, last, grain,
        [](void* b, std::uint32_t from, std::uint32_t to, int worker) { (*static_cast<Body*>(b))(from, to, worker); },
        const_cast<void*>(static_cast<const void*>(&body))};
  }

  // Stage after stage: the next begins when all blocks of the one before are done, and is opened by the thread that did
  // the last of them, so that a loop goes on while its caller has no core. Threads stay with the loop from stage to
  // stage: one fork for all colours, passes and iterations of a substep. Returns when all are done.
  void run_stages(std::span<const Stage> stages);

  // The loop of one stage: body(first, last, worker) for blocks of `grain` that cover [0, count); worker is in
  // [0, threads()). Returns when all are done.
  template <class Body>
  void for_blocks(std::uint32_t count, JobGrain grain, Body&& body) {
    if (threads_ > 1 && std::uint64_t(count) * grain.block_ns >= kForkWork * grain.items && count > grain.items) {
      const Stage all = stage(0, count, grain, body);
      run_stages({&all, 1});
      return;
    }
    for (std::uint32_t i = 0; i < count;) {
      const std::uint32_t last = count - i > grain.items ? i + grain.items : count;
      body(i, last, 0);
      i = last;
    }
  }

  bool help();  // see Helper there

 private:
  // Below this a fork costs more than it brings: a thread takes some microseconds to wake.
  static constexpr std::uint64_t kForkWork = 40'000;  // ns
  static constexpr std::uint64_t kHelpWork = 20'000;  // ns, for each that is woken

  // The blocks that a worker takes first: neighbours, and the same ones in every stage of a size, so that what it wrote
  // in one is still in its cache in the next. Those who are done take from the others.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> left{0};  // epoch << kLeftBits | blocks not yet taken
  };
  static constexpr int kLeftBits = 24;
  static constexpr std::uint64_t kLeftMask = (std::uint64_t(1) << kLeftBits) - 1;

  void work(int worker);
  bool withdraw();
  bool take_blocks(std::uint64_t epoch, int worker);
  void open(const Stage& stage);
  void next_stage();
  void wake(int wanted);
  void wake_caller();
  void sleep_caller(std::uint64_t epoch);

  // the stage that is open; atomic because a worker that comes late may read while the next is written
  std::atomic<std::uint64_t> epoch_{0};  // of the open stage; raised by open(), never reused
  std::atomic<std::uint32_t> first_{0}, last_{0}, items_{1}, blocks_{0};
  std::atomic<decltype(Stage::function)> function_{nullptr};
  std::atomic<void*> body_{nullptr};
  std::unique_ptr<Share[]> shares_;                 // by worker
  alignas(64) std::atomic<std::uint32_t> done_{0};  // blocks of the open stage
  std::atomic<bool> finished_{true};                // all stages of the loop

  // of the loop; read and written only by who opens its stages
  const Stage* stages_ = nullptr;
  std::size_t stage_ = 0, stage_count_ = 0;
  int helpers_ = 0;  // worth waking
  std::uint64_t forks_ = 0;

  int threads_ = 1;
  Call call_;
  std::atomic<std::uint64_t> helping_{0};  // bits: workers in help()
  std::vector<std::thread> workers_;
  Semaphore calls_, news_;    // for workers; for the caller
  std::atomic<int> idle_{0};  // workers that sleep and were not called yet; with a call: those not in help()
  std::atomic<bool> caller_asleep_{false};  // and was not called yet
  std::atomic<bool> stop_{false};
};

}  // namespace feder
