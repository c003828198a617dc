// Named memory: every block of a system lives in an Arena, so that bytes per system can be printed and a system
// that is absent has none. Scratch is the step's throw-away memory.
#pragma once
#include <atomic>
#include <memory_resource>
#include <string>
#include <vector>

#include "base/types.h"

namespace feder {

// Counts what its containers hold. Thread-safe. Not copyable: containers keep its address.
class Arena final : public std::pmr::memory_resource {
 public:
  explicit Arena(std::string name) : name_(std::move(name)) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  const std::string& name() const { return name_; }
  std::size_t bytes() const { return bytes_.load(std::memory_order_relaxed); }
  std::uint64_t allocations() const { return allocations_.load(std::memory_order_relaxed); }  // since birth

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void* p, std::size_t bytes, std::size_t alignment) override;
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::string name_;
  std::atomic<std::size_t> bytes_{0};
  std::atomic<std::uint64_t> allocations_{0};
};

// A growable array in an arena: `Array<Vec3> v{&arena};`
template <class T>
using Array = std::pmr::vector<T>;

// Bump memory of one step: reset at `begin`, grows to the largest step and then never allocates again.
// Only for trivially destructible things; single-threaded (take what workers need before they start).
class Scratch {
 public:
  explicit Scratch(Arena& arena) : blocks_(&arena), arena_(&arena) {}
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  void reset();
  // `count` uninitialised elements, aligned to 64 bytes; valid until reset().
  template <class T>
  T* take(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>);
    return static_cast<T*>(take_bytes(count * sizeof(T)));
  }

 private:
  struct Block {
    std::byte* data;
    std::size_t size;
  };
  void* take_bytes(std::size_t bytes);

  Array<Block> blocks_;
  std::size_t used_ = 0;   // in the last block
  std::size_t total_ = 0;  // asked for since reset
  Arena* arena_;
};

}  // namespace feder
