// A pool of worker threads. Work is cut into blocks by index only, so what is computed never depends on the number
// of threads: a body writes to places that belong to its own indices and merges happen in index order afterwards.
#pragma once
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "base/types.h"

namespace feder {

class JobPool {
 public:
  explicit JobPool(int threads = 1);  // total number including the caller; at least 1
  ~JobPool();
  JobPool(const JobPool&) = delete;
  JobPool& operator=(const JobPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  // Calls body(first, last, worker) for blocks of at most `grain` indices that cover [0, count); worker is in
  // [0, threads()). Returns when all are done. No allocation. Not re-entrant.
  template <class Body>
  void for_blocks(std::uint32_t count, std::uint32_t grain, Body&& body) {
    if (count == 0) return;
    if (workers_.empty() || count <= grain) {
      for (std::uint32_t i = 0; i < count; i += grain) body(i, i + grain < count ? i + grain : count, 0);
      return;
    }
    run(count, grain, [](void* b, std::uint32_t first, std::uint32_t last, int worker) {
      (*static_cast<std::remove_reference_t<Body>*>(b))(first, last, worker);
    }, const_cast<void*>(static_cast<const void*>(&body)));
  }

 private:
  using Function = void (*)(void*, std::uint32_t first, std::uint32_t last, int worker);
  void run(std::uint32_t count, std::uint32_t grain, Function function, void* body);
  void work(int worker);
  void claim_blocks(int worker);

  // The blocks that a worker takes first: neighbours, and the same ones in every round of a size, so that what it wrote
  // in one round is still in its cache in the next. Those who are done take from the others.
  struct alignas(64) Share {
    std::atomic<std::uint32_t> next{0};
    std::uint32_t end = 0;
  };

  std::unique_ptr<Share[]> shares_;  // by worker
  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<std::uint64_t> round_{0};  // raised by run(); workers spin on it, then sleep
  std::atomic<int> busy_{0};
  std::atomic<bool> stop_{false};
  std::uint32_t count_ = 0, grain_ = 1;
  Function function_ = nullptr;
  void* body_ = nullptr;
};

}  // namespace feder
