// Loops over threads that come late or never: every loop returns, results and forks are those of one thread.
#include <chrono>
#include <ctime>

#include "base/jobs.h"
#include "support/catch.h"

#ifdef __linux__
#include <pthread.h>

#include <csignal>
#endif

using namespace feder;

namespace {

constexpr JobGrain kHeavy{7, 50'000};  // blocks that are worth a fork, by what is stated

// Stages that need each other: stage k writes one array from neighbours in the other.
struct Chain {
  static constexpr std::uint32_t kCount = 500;
  std::vector<std::uint32_t> a = std::vector<std::uint32_t>(kCount, 1), b = a;
  std::vector<std::uint32_t> sums = std::vector<std::uint32_t>((kCount + 6) / 7);  // a result per block

  std::uint64_t run(JobPool& pool, int rounds) {
    auto mix = [](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to, std::uint32_t i) {
      to[i] = from[i] * 3 + from[(i + 1) % kCount] + from[(i + kCount - 50) % kCount] + i;
    };
    auto there = [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) mix(a, b, i);
    };
    auto back = [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) mix(b, a, i);
    };
    auto sum = [&](std::uint32_t first, std::uint32_t last, int) {
      std::uint32_t s = 0;
      for (std::uint32_t i = first; i < last; ++i) s = s * 31 + a[i];
      sums[first / kHeavy.items] = s;
    };
    const JobPool::Stage stages[] = {JobPool::stage(0, kCount, kHeavy, there), JobPool::stage(0, 200, kHeavy, back),
                                     JobPool::stage(200, 200, kHeavy, back),  // empty
                                     JobPool::stage(200, kCount, kHeavy, back), JobPool::stage(0, kCount, kHeavy, sum)};
    std::uint64_t all = 0;
    for (int k = 0; k < rounds; ++k) {
      pool.run_stages(stages);
      for (const std::uint32_t s : sums) all = all * 1000003 + s;
    }
    return all;
  }
};

std::uint64_t serial_result(int rounds) {
  JobPool one(1);
  return Chain().run(one, rounds);
}

}  // namespace

TEST_CASE("staged loops give the same bits for any number of threads", "[base][jobs][threads]") {
  const int rounds = 300;
  const std::uint64_t expected = serial_result(rounds);
  for (const int threads : {2, 3, 4, 16}) {
    CAPTURE(threads);
    JobPool pool(threads);
    CHECK(Chain().run(pool, rounds) == expected);
    CHECK(pool.forks() == static_cast<std::uint64_t>(rounds));
  }
}

TEST_CASE("forks follow the stated work, not a clock", "[base][jobs][threads]") {
  for (const int threads : {2, 4}) {
    JobPool pool(threads);
    std::vector<int> hits(10'000);
    const auto body = [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) ++hits[i];
    };
    pool.for_blocks(10'000, {100, 300}, body);  // 30 us
    CHECK(pool.forks() == 0);
    pool.for_blocks(10'000, {100, 500}, body);  // 50 us
    CHECK(pool.forks() == 1);
    pool.for_blocks(100, {100, 1'000'000}, body);  // long, but one block
    CHECK(pool.forks() == 1);
    CHECK(std::count(hits.begin(), hits.begin() + 100, 3) == 100);
    CHECK(std::count(hits.begin() + 100, hits.end(), 2) == 9'900);
  }
}

TEST_CASE("threads of a host may help at once, late or never", "[base][jobs][threads]") {
  std::atomic<int> asked{0};
  const auto pool =
      std::make_shared<JobPool>(4, [&](const std::shared_ptr<JobPool>&, int helpers) { asked.fetch_add(helpers); });
  const int rounds = 400;
  const std::uint64_t expected = serial_result(rounds);
  CHECK(Chain().run(*pool, rounds) == expected);  // never
  CHECK(asked.load() > 0);
  std::atomic<bool> stop{false};
  std::vector<std::thread> threads;
  for (int k = 0; k < 5; ++k)  // more than it takes
    threads.emplace_back([&stop, pool, k] {
      while (!stop) {
        if (k > 1) std::this_thread::sleep_for(std::chrono::microseconds(100 * k));
        pool->help();
      }
    });
  for (int k = 0; k < 5; ++k) CHECK(Chain().run(*pool, rounds) == expected);
  stop = true;
  for (std::thread& t : threads) t.join();
}

#if defined(__linux__) && !defined(FEDER_SANITIZED)
// A worker that the system took its core from: a signal handler that does not return until told.
namespace {
std::atomic<bool> parked{false}, release_parked{false};
void park(int) {
  parked = true;
  const timespec pause{0, 1'000'000};
  for (int i = 0; i < 3000 && !release_parked.load(); ++i) nanosleep(&pause, nullptr);  // 3 s at most
  parked = false;
}
}  // namespace

TEST_CASE("no loop waits for a worker without a core", "[base][jobs][threads]") {
  struct sigaction action = {}, before = {};
  action.sa_handler = park;
  sigaction(SIGUSR1, &action, &before);
  {
    JobPool pool(3);
    const std::uint64_t expected = serial_result(200);
    std::atomic<bool> known{false};
    std::atomic<pthread_t> victim{};
    const auto meet = [&](std::uint32_t, std::uint32_t, int worker) {
      if (worker == 1 && !known.load()) victim = pthread_self(), known = true;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    };
    while (!known.load()) pool.for_blocks(64, {1, 100'000}, meet);
    pthread_kill(victim.load(), SIGUSR1);
    while (!parked.load()) std::this_thread::yield();
    CHECK(Chain().run(pool, 200) == expected);
    CHECK(parked.load());  // still: the loops did not wait for it
    release_parked = true;
    while (parked.load()) std::this_thread::yield();
    CHECK(Chain().run(pool, 200) == expected);  // and with it again
  }
  sigaction(SIGUSR1, &before, nullptr);
}
#endif
