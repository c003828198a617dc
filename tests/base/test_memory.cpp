// Arenas, work arrays and scratch memory: what they count, what they give back, what they keep apart.
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

#include "base/hash.h"
#include "feder/memory.h"
#include "support/catch.h"

#if defined(__linux__)
#include <sys/resource.h>
#endif

using namespace feder;

TEST_CASE("arenas count bytes and allocations, scratch stops allocating", "[base][memory]") {
  Arena arena("test");
  {
    Array<double> numbers(&arena);
    numbers.resize(1000);
    CHECK(arena.bytes() >= 8000);
  }
  CHECK(arena.bytes() == 0);
  Scratch scratch(arena);
  std::uint64_t allocations = 0;
  for (int step = 0; step < 5; ++step) {
    scratch.reset();
    for (int i = 0; i < 50; ++i) {
      double* d = scratch.take<double>(3000);
      CHECK(reinterpret_cast<std::uintptr_t>(d) % 64 == 0);
      std::iota(d, d + 3000, i);
    }
    if (step == 1) allocations = arena.allocations();
    if (step > 1) CHECK(arena.allocations() == allocations);
  }
}

TEST_CASE("a frame of scratch memory ends with what was taken in it, and with nothing else", "[base][memory]") {
  Arena arena("test");
  Scratch scratch(arena);
  std::size_t after_frames = 0;
  for (int step = 0; step < 4; ++step) {
    scratch.reset();
    int* kept = scratch.take<int>(5000);
    std::iota(kept, kept + 5000, 0);
    int* rare = scratch.take_rare<int>(5000);
    std::iota(rare, rare + 5000, 7);
    int* first = nullptr;
    for (int round = 0; round < 20; ++round) {
      const Scratch::Frame frame(scratch);
      int* mine = scratch.take<int>(20'000);
      if (!first) first = mine;
      if (step > 0) CHECK(mine == first);  // the first step grows
      std::fill_n(mine, 20'000, -1);
      std::fill_n(scratch.take_rare<int>(1000), 1000, -1);
    }
    std::fill_n(scratch.take<int>(1000), 1000, -1);
    for (int i = 0; i < 5000; ++i) REQUIRE((kept[i] == i && rare[i] == i + 7));
    if (step == 1) after_frames = arena.bytes();
    if (step > 1) CHECK(arena.bytes() == after_frames);
  }
  CHECK(after_frames < 200'000);  // not twenty times what a frame takes
}

TEST_CASE("a hash of a sequence tells every word and the order", "[base]") {
  const auto hash = [](std::vector<std::array<std::uint64_t, 3>> records) {
    SequenceHash h;
    for (const auto& r : records) h.add(r[0], r[1], r[2]);
    return h;
  };
  const std::vector<std::array<std::uint64_t, 3>> all = {{1, 2, 3}, {4, 5, 6}, {0, 0, 0}};
  CHECK(hash(all) == hash(all));
  for (std::size_t record = 0; record < 3; ++record)
    for (std::size_t word = 0; word < 3; ++word)
      for (int bit = 0; bit < 64; ++bit) {
        auto other = all;
        other[record][word] ^= std::uint64_t(1) << bit;
        REQUIRE_FALSE(hash(other) == hash(all));
      }
  CHECK_FALSE(hash({all[1], all[0], all[2]}) == hash(all));
  CHECK_FALSE(hash({all[0], all[1]}) == hash(all));
  CHECK_FALSE(word_of(Real(0)) == word_of(-Real(0)));
}

TEST_CASE("a work array gives back what one step needed, and keeps what all need", "[base][memory]") {
  Arena arena("test");
  Array<int> work(&arena);
  Slack slack;
  work.resize(100'000);
  CHECK_FALSE(slack.clear(work));
  const std::size_t burst = arena.bytes();
  int calls = 0;
  while (arena.bytes() == burst && calls < 1000) work.resize(1000), slack.clear(work), ++calls;
  CHECK((calls > 20 && calls < 100));
  CHECK(arena.bytes() == 0);
  // from then on as much as it needs, without a further allocation
  work.resize(1000), slack.clear(work);
  const std::uint64_t allocations = arena.allocations();
  for (int call = 0; call < 500; ++call) work.resize(call % 50 ? 700 : 1000), slack.clear(work);
  CHECK(arena.allocations() == allocations);
  CHECK(work.empty());
}

#if defined(__linux__) && !defined(FEDER_SANITIZED)
TEST_CASE("where the system gives no more mappings, large blocks come from the heap", "[base][memory]") {
  Arena arena("test");
  constexpr std::size_t kBytes = 100'000;
  std::vector<void*> blocks;
  const auto take = [&] { blocks.push_back(arena.allocate(kBytes, 64)); };
  take();
  // room in the heap: what is freed below a block in use stays there
  ::operator delete(::operator new(4'000'000));  // from now on malloc does not map blocks of that size
  std::vector<void*> room;
  for (int i = 0; i < 20; ++i) room.push_back(::operator new(kBytes + 10'000));
  const auto above = std::make_unique<std::array<char, 1000>>();
  for (void* p : room) ::operator delete(p);
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_AS, &before) == 0);
  const rlimit none{1, before.rlim_max};
  blocks.reserve(10);
  setrlimit(RLIMIT_AS, &none);
  bool all = true;
  try {
    for (int i = 0; i < 4; ++i) take();
  } catch (const std::bad_alloc&) {
    all = false;
  }
  setrlimit(RLIMIT_AS, &before);
  REQUIRE(all);
  take();
  CHECK(reinterpret_cast<std::uintptr_t>(blocks[0]) % 4096 == 0);
  for (std::size_t i = 1; i < 5; ++i) CHECK(reinterpret_cast<std::uintptr_t>(blocks[i]) % 4096 == 64);
  for (void* p : blocks) {
    std::fill_n(static_cast<std::byte*>(p), kBytes, std::byte(1));
    arena.deallocate(p, kBytes, 64);
  }
  CHECK(arena.bytes() == 0);
}
#endif
