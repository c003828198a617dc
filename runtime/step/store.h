// Blocks of state by type, made when a system first asks: what nobody needs is not there and has no bytes.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "base/arena.h"
#include "base/assert.h"

namespace feder {

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
  // Null when nobody has asked for it.
  template <class Block>
  Block* find() const {
    for (const Entry& e : blocks_)
      if (e.tag == type_tag<Block>()) return &static_cast<Holder<Block>*>(e.holder.get())->block;
    return nullptr;
  }
  // For rows, which only run when their blocks exist.
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
