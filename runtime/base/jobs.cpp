// Workers spin for a short while between rounds (a step has hundreds of short rounds), then sleep on a condition
// variable. Blocks are claimed from one counter per worker, the own one first.
#include "base/jobs.h"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace feder {
namespace {

constexpr int kSpins = 4000;  // about 40 us of waiting before a worker goes to sleep

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#else
  std::this_thread::yield();
#endif
}

}  // namespace

JobPool::JobPool(int threads) : shares_(new Share[static_cast<std::size_t>(threads > 1 ? threads : 1)]) {
  for (int i = 1; i < threads; ++i) workers_.emplace_back([this, i] { work(i); });
}

JobPool::~JobPool() {
  {
    std::lock_guard lock(mutex_);
    stop_.store(true);
    round_.fetch_add(1);
  }
  wake_.notify_all();
  for (std::thread& t : workers_) t.join();
}

void JobPool::claim_blocks(int worker) {
  const int all = threads();
  for (int k = 0; k < all; ++k) {
    Share& share = shares_[static_cast<std::size_t>((worker + k) % all)];
    for (;;) {
      const std::uint32_t block = share.next.fetch_add(1, std::memory_order_relaxed);
      if (block >= share.end) break;
      const std::uint64_t first = std::uint64_t(block) * grain_, last = first + grain_;
      function_(body_, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last < count_ ? last : count_),
                worker);
    }
  }
}

void JobPool::run(std::uint32_t count, std::uint32_t grain, Function function, void* body) {
  count_ = count, grain_ = grain, function_ = function, body_ = body;
  const std::uint64_t blocks = (std::uint64_t(count) + grain - 1) / grain, all = static_cast<std::uint64_t>(threads());
  for (std::uint64_t w = 0; w < all; ++w) {
    shares_[w].next.store(static_cast<std::uint32_t>(blocks * w / all), std::memory_order_relaxed);
    shares_[w].end = static_cast<std::uint32_t>(blocks * (w + 1) / all);
  }
  busy_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
  {
    std::lock_guard lock(mutex_);
    round_.fetch_add(1, std::memory_order_release);
  }
  wake_.notify_all();
  claim_blocks(0);
  for (int spins = 0; busy_.load(std::memory_order_acquire) != 0; ++spins) {
    if (spins < kSpins) relax(); else std::this_thread::yield();
  }
}

void JobPool::work(int worker) {
  std::uint64_t seen = 0;
  for (;;) {
    for (int spins = 0; round_.load(std::memory_order_acquire) == seen; ++spins) {
      if (spins < kSpins) {
        relax();
        continue;
      }
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return round_.load(std::memory_order_acquire) != seen; });
    }
    seen = round_.load(std::memory_order_acquire);
    if (stop_.load()) return;
    claim_blocks(worker);
    busy_.fetch_sub(1, std::memory_order_release);
  }
}

}  // namespace feder
