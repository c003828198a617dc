// Staged loops on threads that may come late. A stage is published as (epoch, what to run); a worker takes a block by
// compare-exchange on a word that holds the epoch and the number of blocks left of a share, so that a thread that slept
// through the end of a stage fails. The last block of a stage opens the next; only taken blocks are waited for.
// Workers spin until the next loop of a step has had time to begin, then sleep: on a busy machine spinning would take
// the time from the thread that steps, and more threads than cores hardly spin. They do not yield: a yield may cost a
// whole slice (Linux 6.18), and a sleeper is woken sooner.
#include "base/jobs.h"

#include <algorithm>
#include <chrono>

#include "feder/error.h"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace feder {
namespace {

constexpr int kShortSpins = 400;    // some 10 us, of a host's threads, which have other work, and of crowded ones
constexpr int kCallerSpins = 1000;  // some 25 us: the blocks it waits for are being run
// What a step does between two loops is mostly shorter, and to be woken costs more than most loops save.
constexpr std::chrono::microseconds kPatience{250};
constexpr int kSpinsPerLook = 64;  // at the clock

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#elif defined(__aarch64__) && defined(__GNUC__)
  __asm__ __volatile__("isb");  // yield is nothing on most cores
#else
  std::this_thread::yield();
#endif
}

template <class Ready>
bool spin(int spins, Ready&& ready) {
  for (int i = 0; i < spins; ++i) {
    if (ready()) return true;
    relax();
  }
  return ready();
}

template <class Ready>
bool spin_patiently(Ready&& ready) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < end)
    if (spin(kSpinsPerLook, ready)) return true;
  return false;
}

void run_serial(std::span<const JobPool::Stage> stages) {
  for (const JobPool::Stage& s : stages) {
    for (std::uint32_t first = s.first; first < s.last;) {
      const std::uint32_t last = s.last - first > s.grain.items ? first + s.grain.items : s.last;
      s.function(s.body, first, last, 0);
      first = last;
    }
  }
}

}  // namespace

JobPool::JobPool(int threads)
    : shares_(new Share[static_cast<std::size_t>(std::max(threads, 1))]), threads_(std::max(threads, 1)) {
  for (int i = 1; i < threads_; ++i) workers_.emplace_back([this, i] { work(i); });
}

JobPool::JobPool(int threads, Call call)
    : shares_(new Share[static_cast<std::size_t>(threads)]), threads_(threads), call_(std::move(call)),
      idle_(threads_ - 1) {
  FEDER_ASSERT(call_ && threads_ >= 1 && threads_ <= 64);
}

JobPool::~JobPool() {
  stop_.store(true);
  for (std::size_t i = 0; i < workers_.size(); ++i) calls_.post();
  for (std::thread& t : workers_) t.join();
}

// What is read of the stage belongs to `epoch` whenever a take succeeds: the next stage is written only after the block
// that was taken is done. True when a block was run.
bool JobPool::take_blocks(std::uint64_t epoch, int worker) {
  const std::uint64_t first = first_.load(std::memory_order_relaxed), last = last_.load(std::memory_order_relaxed);
  const std::uint64_t items = items_.load(std::memory_order_relaxed), blocks = blocks_.load(std::memory_order_relaxed);
  const auto function = function_.load(std::memory_order_relaxed);
  void* const body = body_.load(std::memory_order_relaxed);
  const auto all = static_cast<std::uint64_t>(threads_);
  std::uint32_t ran = 0;
  for (std::uint64_t k = 0; k < all; ++k) {
    const std::uint64_t s = (static_cast<std::uint64_t>(worker) + k) % all, end = blocks * (s + 1) / all;
    std::atomic<std::uint64_t>& word = shares_[s].left;
    std::uint64_t left = word.load(std::memory_order_acquire);
    while (left >> kLeftBits == epoch && (left & kLeftMask) != 0) {
      if (!word.compare_exchange_weak(left, left - 1, std::memory_order_acq_rel, std::memory_order_acquire)) continue;
      const std::uint64_t from = first + (end - (left & kLeftMask)) * items;
      function(body, static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(std::min(from + items, last)),
               worker);
      ++ran;
      left = word.load(std::memory_order_acquire);
    }
  }
  // counted together: a word that all write after each block would travel between their caches
  if (ran > 0 && done_.fetch_add(ran, std::memory_order_acq_rel) + ran == blocks) next_stage();
  return ran > 0;
}

// By one thread at a time: the caller at the start of a loop, then who did the last block of a stage.
void JobPool::open(const Stage& stage) {
  const std::uint64_t blocks = stage.blocks(), all = static_cast<std::uint64_t>(threads_);
  FEDER_ASSERT(blocks <= kLeftMask);
  const std::uint64_t epoch = epoch_.load(std::memory_order_relaxed) + 1;
  first_.store(stage.first, std::memory_order_relaxed), last_.store(stage.last, std::memory_order_relaxed);
  items_.store(stage.grain.items, std::memory_order_relaxed);
  blocks_.store(static_cast<std::uint32_t>(blocks), std::memory_order_relaxed);
  function_.store(stage.function, std::memory_order_relaxed), body_.store(stage.body, std::memory_order_relaxed);
  done_.store(0, std::memory_order_relaxed);
  const auto wanted = static_cast<int>(std::min<std::uint64_t>(blocks - 1, static_cast<std::uint64_t>(helpers_)));
  for (std::uint64_t s = 0; s < all; ++s)
    shares_[s].left.store(epoch << kLeftBits | (blocks * (s + 1) / all - blocks * s / all), std::memory_order_release);
  epoch_.store(epoch);
  wake(wanted);  // by now others may have ended the stage, and the loop: nothing of it is read any more
}

void JobPool::next_stage() {
  do ++stage_;
  while (stage_ < stage_count_ && stages_[stage_].blocks() == 0);
  if (stage_ < stage_count_) {
    open(stages_[stage_]);
    return;
  }
  finished_.store(true);
  wake_caller();
}

void JobPool::wake_caller() {
  if (caller_asleep_.exchange(false)) news_.post();
}

// So many as are wanted and not awake yet. Who goes to sleep counts itself idle before it looks at the epoch a last
// time, so either it is counted here or it sees the new epoch.
void JobPool::wake(int wanted) {
  wake_caller();
  if (workers_.empty() && !call_) return;
  int idle = idle_.load(), called;
  do {
    called = std::min(wanted - (threads_ - 1 - idle), idle);
    if (called <= 0) return;
  } while (!call_ && !idle_.compare_exchange_weak(idle, idle - called));
  if (call_) {
    call_(weak_from_this().lock(), called);
    return;
  }
  for (int i = 0; i < called; ++i) calls_.post();
}

void JobPool::run_stages(std::span<const Stage> stages) {
  if (threads_ == 1) return run_serial(stages);
  std::uint64_t work = 0, widest = 0;
  for (const Stage& s : stages) work += s.work(), widest = std::max<std::uint64_t>(widest, s.blocks());
  if (work < kForkWork || widest < 2) return run_serial(stages);
  FEDER_ASSERT(finished_.load());  // not re-entrant
  ++forks_;
  helpers_ = static_cast<int>(std::min({static_cast<std::uint64_t>(threads_), widest, work / kHelpWork})) - 1;
  stages_ = stages.data(), stage_count_ = stages.size(), stage_ = 0;
  while (stages_[stage_].blocks() == 0) ++stage_;
  finished_.store(false, std::memory_order_relaxed);
  open(stages_[stage_]);
  for (;;) {
    const std::uint64_t epoch = epoch_.load(std::memory_order_acquire);
    if (take_blocks(epoch, 0)) continue;
    if (finished_.load(std::memory_order_acquire)) return;
    sleep_caller(epoch);
  }
}

// Until the loop is done or its next stage is open.
void JobPool::sleep_caller(std::uint64_t epoch) {
  const auto ready = [&] { return finished_.load() || epoch_.load() != epoch; };
  if (spin(kCallerSpins, ready)) return;
  caller_asleep_.store(true);
  if (!ready() || !caller_asleep_.exchange(false)) news_.wait();  // who is called must hear it
}

void JobPool::work(int worker) {
  const bool crowded = static_cast<unsigned>(threads_) > std::thread::hardware_concurrency();
  for (;;) {
    const std::uint64_t epoch = epoch_.load();
    if (take_blocks(epoch, worker)) continue;
    const auto news = [&] { return epoch_.load() != epoch || stop_.load(); };
    if (!(crowded ? spin(kShortSpins, news) : spin_patiently(news))) {
      idle_.fetch_add(1);
      if (!news() || !withdraw()) calls_.wait();
    }
    if (stop_.load()) return;
  }
}

// From the idle; false when all of them were called, this one too.
bool JobPool::withdraw() {
  int idle = idle_.load();
  while (idle > 0)
    if (idle_.compare_exchange_weak(idle, idle - 1)) return true;
  return false;
}

bool JobPool::help() {
  std::uint64_t helping = helping_.load();
  int worker;
  do {
    worker = 1;
    while (worker < threads_ && helping >> worker & 1u) ++worker;
    if (worker == threads_) return false;
  } while (!helping_.compare_exchange_weak(helping, helping | std::uint64_t(1) << worker));
  idle_.fetch_sub(1);
  bool any = false;
  for (;;) {
    const std::uint64_t epoch = epoch_.load();
    if (take_blocks(epoch, worker)) {
      any = true;
      continue;
    }
    if (!spin(kShortSpins, [&] { return epoch_.load(std::memory_order_acquire) != epoch; })) break;
  }
  idle_.fetch_add(1);
  helping_.fetch_and(~(std::uint64_t(1) << worker));
  return any;
}

}  // namespace feder
