// Memory: every block of state lives in a named Arena, so that bytes per system can be printed and an absent system has
// none. Scratch is a step's temporary memory; Store holds a world's blocks by type. An Arena may be used by several
// threads at once, Scratch and Store by one.
#pragma once
#include <atomic>
#include <memory>
#include <memory_resource>
#include <string>
#include <vector>

#include "feder/error.h"
#include "feder/types.h"

namespace feder {

// Counts the bytes of its containers. Thread-safe. Not copyable: containers keep its address.
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

// How much of a work array was needed of late, so that what one step needed is not kept for good.
class Slack {
 public:
  // When the array is not needed any more in a step: clears it. Its memory goes back when it has been four times what
  // was needed for some fifty steps: returns whether it did.
  template <class T>
  bool clear(Array<T>& a) {
    recent_ -= recent_ / 32;
    if (recent_ < a.size()) recent_ = a.size();
    a.clear();
    const bool much = a.capacity() * sizeof(T) > kSmall && a.capacity() / 4 > recent_;
    if (much) Array<T>(a.get_allocator()).swap(a);
    return much;
  }

 private:
  static constexpr std::size_t kSmall = 4096;  // B
  std::size_t recent_ = 0;                     // elements
};

// Bump memory of one step: reset at `begin`, grows to the largest step and then never allocates again.
// Only for trivially destructible things; single-threaded (take what workers need before they start).
class Scratch {
 public:
  explicit Scratch(Arena& arena) : blocks_(&arena), arena_(&arena) {}
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  void reset();
  // What is taken while a frame lives ends with it.
  class Frame {
   public:
    explicit Frame(Scratch& scratch) : scratch_(scratch), before_(scratch.at_), blocks_(scratch.blocks_.size()) {}
    ~Frame() {
      if (scratch_.blocks_.size() == blocks_)
        scratch_.at_ = before_;
      else
        scratch_.at_.total = before_.total;
    }
    Frame(const Frame&) = delete;
    Frame& operator=(const Frame&) = delete;

   private:
    friend class Scratch;
    struct Place {
      std::size_t used = 0;   // in the last block, from its start
      std::size_t rare = 0;   // and from its end
      std::size_t total = 0;  // taken now
    };
    Scratch& scratch_;
    Place before_;
    std::size_t blocks_;
  };
  // `count` uninitialised elements, aligned to 64 bytes; valid until reset().
  template <class T>
  T* take(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>);
    return static_cast<T*>(take_bytes(count * sizeof(T), false));
  }
  // The same for what most steps do not write: it lies apart, so that no page of it is touched for something else.
  template <class T>
  T* take_rare(std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>);
    return static_cast<T*>(take_bytes(count * sizeof(T), true));
  }

 private:
  struct Block {
    std::byte* data;
    std::size_t size;
  };
  void* take_bytes(std::size_t bytes, bool rare);

  Array<Block> blocks_;
  Frame::Place at_;
  std::size_t most_ = 0;  // taken at a time since reset
  Arena* arena_;
};

// Blocks of state by type, made when a system first needs them: unused ones do not exist.
class Store {
 public:
  // The block, made in the arena `arena_name` on first use (one arena per system; several blocks may share it).
  template <class Block>
  Block& need(const char* arena_name) {
    if (Block* found = find<Block>()) return *found;
    auto holder = std::make_unique<Holder<Block>>(arena(arena_name));
    Block& block = holder->block;
    blocks_.push_back({type_tag<Block>(), std::move(holder)});
    return block;
  }
  // Null when nothing has needed it.
  template <class Block>
  Block* find() const {
    for (const Entry& e : blocks_)
      if (e.tag == type_tag<Block>()) return &static_cast<Holder<Block>*>(e.holder.get())->block;
    return nullptr;
  }
  // For passes, which only run when their blocks exist.
  template <class Block>
  Block& get() const {
    Block* block = find<Block>();
    FEDER_ASSERT(block);
    return *block;
  }

  Arena& arena(const char* name);
  const std::vector<std::unique_ptr<Arena>>& arenas() const { return arenas_; }

 private:
  struct HolderBase {
    virtual ~HolderBase() = default;
  };
  template <class Block>
  struct Holder : HolderBase {
    explicit Holder(Arena& a) : block(a) {}
    Block block;
  };
  template <class Block>
  static const void* type_tag() {
    static const char tag = 0;
    return &tag;
  }
  struct Entry {
    const void* tag;
    std::unique_ptr<HolderBase> holder;
  };

  std::vector<std::unique_ptr<Arena>> arenas_;  // first: freed last
  std::vector<Entry> blocks_;
};

}  // namespace feder
