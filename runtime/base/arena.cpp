// Blocks that are counted, and the step's scratch memory. Large blocks are pages of their own where the system has
// mmap: an array that has grown gives its old place back, where malloc may keep it, and what it has not used yet takes
// none.
#include <algorithm>
#include <cstring>
#include <new>

#include "feder/error.h"
#include "feder/memory.h"

#if defined(__unix__) && !defined(__EMSCRIPTEN__) && !defined(FEDER_SANITIZED)
#include <sys/mman.h>
#define FEDER_PAGES 1
#else
#define FEDER_PAGES 0
#endif

namespace feder {
namespace {

constexpr std::size_t kLine = 64;              // a cache line, and the widest vector
constexpr std::size_t kPage = 4096;            // at least
constexpr std::size_t kLargeBlock = 64 << 10;  // B: a page more or less is nothing

#if FEDER_PAGES
bool is_large(std::size_t bytes, std::size_t alignment) { return bytes >= kLargeBlock && alignment <= kLine; }
#endif

// A large block that begins a line after a page is no mapping: the system allows so many of these to a process.
void* take_block(std::size_t bytes, std::size_t alignment) {
#if FEDER_PAGES
  if (is_large(bytes, alignment)) {
    void* p = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (p != MAP_FAILED) return p;
    return static_cast<std::byte*>(::operator new(bytes + kLine, std::align_val_t(kPage))) + kLine;
  }
#endif
  return ::operator new(bytes, std::align_val_t(alignment));
}

void give_block_back(void* p, [[maybe_unused]] std::size_t bytes, std::size_t alignment) {
#if FEDER_PAGES
  if (is_large(bytes, alignment)) {
    if (reinterpret_cast<std::uintptr_t>(p) % kPage == 0)
      munmap(p, bytes);
    else
      ::operator delete(static_cast<std::byte*>(p) - kLine, std::align_val_t(kPage));
    return;
  }
#endif
  ::operator delete(p, std::align_val_t(alignment));
}

}  // namespace

void* Arena::do_allocate(std::size_t bytes, std::size_t alignment) {
  void* p = take_block(bytes, std::max(alignment, kLine));
  bytes_.fetch_add(bytes, std::memory_order_relaxed);
  allocations_.fetch_add(1, std::memory_order_relaxed);
  return p;
}

void Arena::do_deallocate(void* p, std::size_t bytes, std::size_t alignment) {
  give_block_back(p, bytes, std::max(alignment, kLine));
  bytes_.fetch_sub(bytes, std::memory_order_relaxed);
}

Scratch::~Scratch() {
  for (const Block& b : blocks_) arena_->deallocate(b.data, b.size, kLine);
}

void Scratch::reset() {
  // several blocks mean the step outgrew them: make one that holds all
  if (blocks_.size() > 1) {
    for (const Block& b : blocks_) arena_->deallocate(b.data, b.size, kLine);
    blocks_.clear();
    const std::size_t size = (most_ + most_ / 4 + kLine - 1) / kLine * kLine;
    blocks_.push_back({static_cast<std::byte*>(arena_->allocate(size, kLine)), size});
  }
  at_ = {};
  most_ = 0;
}

void* Scratch::take_bytes(std::size_t bytes, bool rare) {
  bytes = (bytes + kLine - 1) / kLine * kLine;
  at_.total += bytes;
  most_ = std::max(most_, at_.total);
  if (blocks_.empty() || at_.used + at_.rare + bytes > blocks_.back().size) {
    const std::size_t size = std::max<std::size_t>(bytes, 1u << 16);
    blocks_.push_back({static_cast<std::byte*>(arena_->allocate(size, kLine)), size});
    at_.used = at_.rare = 0;
  }
  const Block& block = blocks_.back();
  std::byte* const taken = rare ? block.data + block.size - at_.rare - bytes : block.data + at_.used;
  (rare ? at_.rare : at_.used) += bytes;
  // what reads it unwritten is not the same run after run; with this the hashes of this build tell
  if constexpr (kAsserts) std::memset(taken, 0xcd, bytes);
  return taken;
}

}  // namespace feder
