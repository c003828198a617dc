// Objects: everything a script has a handle of (body, joint, net, force ...) is a slot with a generation, a kind, a
// name and tags. Systems keep the data; this table has its index. A freed slot keeps its name and where it was
// destroyed, for messages about stale handles.
#pragma once
#include <compare>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "feder/types.h"

namespace feder {

class CommandLog;
class Writer;
class Reader;

// A name of a family that modules add to ("cloth" among the kinds of objects): a constant in the header of its module.
// Names compare by text, so that nothing depends on what else a build has.
template <class Family>
class Name {
 public:
  // `text` lives as long as the program.
  explicit constexpr Name(const char* text) : text_(text) {}
  constexpr const char* text() const { return text_; }
  friend constexpr bool operator==(const Family& x, const Family& y) {
    return x.text() == y.text() || std::string_view(x.text()) == y.text();
  }
  friend constexpr bool operator<(const Family& x, const Family& y) {
    return x.text() != y.text() && std::string_view(x.text()) < y.text();
  }

 private:
  const char* text_;
};

// "body", "net" ...: systems list theirs in their descriptor.
class ObjectKind : public Name<ObjectKind> {
 public:
  constexpr ObjectKind(const char* one, const char* many) : Name(one), many_(many) {}
  constexpr const char* plural() const { return many_; }  // "bodies"
  static const ObjectKind none;

 private:
  const char* many_;
};
inline constexpr ObjectKind ObjectKind::none{"none", "none"};
inline constexpr ObjectKind kForceKind{"force", "forces"};  // the world's own

struct ObjectId {
  std::uint32_t slot = kNone;
  std::uint32_t generation = 0;
  explicit operator bool() const { return slot != kNone; }
  friend auto operator<=>(const ObjectId&, const ObjectId&) = default;
};

// One bit per tag; a world knows at most 64 different tags.
using TagMask = std::uint64_t;

class Objects {
 public:
  // Only objects of known kinds can be added.
  Objects(std::initializer_list<ObjectKind> kinds = {});
  void know(ObjectKind kind);
  void log_to(CommandLog& log) { log_ = &log; }  // tags that are set from outside
  // `index` is that in the owning system. The name may be empty.
  ObjectId add(ObjectKind kind, std::uint32_t index, std::string name, TagMask tags);
  // `where` ("scene.lua:41", may be empty) is kept for the message about stale handles.
  void remove(ObjectId id, std::string where);

  bool alive(ObjectId id) const;
  ObjectKind kind(ObjectId id) const;                       // also of destroyed ones, until the slot is used again
  std::uint32_t index(ObjectId id) const;                   // alive only
  std::uint32_t index(ObjectId id, ObjectKind kind) const;  // SceneError unless it is alive and of that kind
  void set_index(ObjectId id, std::uint32_t index);
  const std::string& name(ObjectId id) const;  // also of destroyed ones, until the slot is used again; else ""
  const std::string& destroyed_at(ObjectId id) const;
  std::string describe(ObjectId id) const;  // body "crate3", or body #17 without a name
  TagMask tags(ObjectId id) const;
  void set_tags(ObjectId id, TagMask tags);

  // The bit of a tag, made on first use. SceneError beyond 64 tags.
  TagMask tag_bit(std::string_view tag);
  TagMask known_tag(std::string_view tag) const;  // 0 when never used
  const std::vector<std::string>& tag_names() const { return tag_names_; }

  // The living object of a slot; none when the slot is free.
  ObjectId at(std::uint32_t slot) const {
    return slot < slots_.size() && slots_[slot].alive ? ObjectId{slot, slots_[slot].generation} : ObjectId{};
  }
  // First living object with that name in slot order; none when absent.
  ObjectId find(std::string_view name) const;

  // Calls f(ObjectId) for the living ones of a kind in slot order.
  template <class F>
  void for_each(ObjectKind kind, F&& f) const {
    for (std::uint32_t i = 0; i < slots_.size(); ++i)
      if (slots_[i].alive && kinds_[slots_[i].kind] == kind) f(ObjectId{i, slots_[i].generation});
  }
  std::size_t count(ObjectKind kind) const;
  std::size_t bytes() const;
  void validate() const;  // asserts what holds of the table by itself

  void save(Writer& w) const;
  void load(Reader& r);

 private:
  // Most objects have no name and were not destroyed: texts lie elsewhere.
  struct Texts {
    std::string name, destroyed_at;
  };
  struct Slot {
    std::uint32_t generation = 0;
    std::uint32_t index = 0;
    std::uint32_t texts = kNone;  // in texts_
    std::uint8_t kind = 0;        // in kinds_
    bool alive = false;
    TagMask tags = 0;
  };
  const Slot* slot(ObjectId id) const;
  const Texts& texts(const Slot& s) const;
  void set_texts(Slot& s, Texts texts);
  std::uint8_t number_of(ObjectKind kind) const;  // in kinds_, or its length

  CommandLog* log_ = nullptr;
  std::vector<ObjectKind> kinds_ = {ObjectKind::none};
  std::vector<Slot> slots_;
  std::vector<Texts> texts_;
  std::vector<std::uint32_t> free_texts_;
  std::vector<std::uint32_t> free_;  // first in, first out: a stale handle keeps its tombstone as long as possible
  std::size_t free_head_ = 0;
  std::vector<std::string> tag_names_;
};

}  // namespace feder
