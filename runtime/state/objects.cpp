// The table of objects: slots with generations. Freed slots are used again first in, first out, and only when many are
// free, so that a stale handle finds its tombstone (name, place of destruction) as long as possible.
#include <algorithm>

#include "feder/error.h"
#include "feder/object.h"
#include "feder/snapshot.h"
#include "state/arrays.h"
#include "state/command_log.h"

namespace feder {
namespace {
constexpr std::size_t kTombstones = 64;  // freed slots that wait before they are used again
}  // namespace

Objects::Objects(std::initializer_list<ObjectKind> kinds) {
  for (ObjectKind kind : kinds) know(kind);
}

void Objects::know(ObjectKind kind) {
  if (number_of(kind) < kinds_.size()) return;
  FEDER_ASSERT(kinds_.size() < 255);
  kinds_.push_back(kind);
}

std::uint8_t Objects::number_of(ObjectKind kind) const {
  return static_cast<std::uint8_t>(std::find(kinds_.begin(), kinds_.end(), kind) - kinds_.begin());
}

const Objects::Texts& Objects::texts(const Slot& s) const {
  static const Texts none;
  return s.texts == kNone ? none : texts_[s.texts];
}

void Objects::set_texts(Slot& s, Texts texts) {
  const bool any = !texts.name.empty() || !texts.destroyed_at.empty();
  if (!any && s.texts == kNone) return;
  if (s.texts == kNone) {
    if (free_texts_.empty()) free_texts_.push_back(static_cast<std::uint32_t>(texts_.size())), texts_.emplace_back();
    s.texts = free_texts_.back();
    free_texts_.pop_back();
  }
  texts_[s.texts] = std::move(texts);
  if (any) return;
  free_texts_.push_back(s.texts);
  s.texts = kNone;
}

const Objects::Slot* Objects::slot(ObjectId id) const {
  if (id.slot >= slots_.size() || slots_[id.slot].generation != id.generation) return nullptr;
  return &slots_[id.slot];
}

ObjectId Objects::add(ObjectKind kind, std::uint32_t index, std::string name, TagMask tags) {
  const std::uint8_t number = number_of(kind);
  FEDER_ASSERT(kind != ObjectKind::none && number < kinds_.size());
  std::uint32_t i;
  if (free_.size() - free_head_ > kTombstones) {
    i = free_[free_head_++];
    if (free_head_ > 1024) {
      free_.erase(free_.begin(), free_.begin() + static_cast<std::ptrdiff_t>(free_head_));
      free_head_ = 0;
    }
  } else {
    i = static_cast<std::uint32_t>(slots_.size());
    slots_.emplace_back();
  }
  Slot& s = slots_[i];
  FEDER_ASSERT(!s.alive);
  ++s.generation;
  s.index = index, s.kind = number, s.alive = true, s.tags = tags;
  set_texts(s, {std::move(name), {}});
  return {i, s.generation};
}

void Objects::remove(ObjectId id, std::string where) {
  FEDER_ASSERT(alive(id));
  Slot& s = slots_[id.slot];
  s.alive = false;
  set_texts(s, {texts(s).name, std::move(where)});
  free_.push_back(id.slot);
}

bool Objects::alive(ObjectId id) const {
  const Slot* s = slot(id);
  return s && s->alive;
}

ObjectKind Objects::kind(ObjectId id) const {
  const Slot* s = slot(id);
  return s ? kinds_[s->kind] : ObjectKind::none;
}

std::uint32_t Objects::index(ObjectId id) const {
  FEDER_ASSERT(alive(id));
  return slots_[id.slot].index;
}

std::uint32_t Objects::index(ObjectId id, ObjectKind expected) const {
  const Slot* s = slot(id);
  if (!s || !s->alive || kinds_[s->kind] != expected)
    throw SceneError(std::string("expected a living ") + expected.text() + ", got " + describe(id));
  return s->index;
}

void Objects::set_index(ObjectId id, std::uint32_t index) {
  FEDER_ASSERT(alive(id));
  slots_[id.slot].index = index;
}

const std::string& Objects::name(ObjectId id) const {
  const Slot* s = slot(id);
  return texts(s ? *s : Slot{}).name;
}

const std::string& Objects::destroyed_at(ObjectId id) const {
  const Slot* s = slot(id);
  return texts(s ? *s : Slot{}).destroyed_at;
}

std::string Objects::describe(ObjectId id) const {
  const Slot* s = slot(id);
  if (!s) return "object #" + std::to_string(id.slot);
  const std::string kind = kinds_[s->kind].text();
  const std::string& own = texts(*s).name;
  return own.empty() ? kind + " #" + std::to_string(id.slot) : kind + " \"" + own + "\"";
}

TagMask Objects::tags(ObjectId id) const {
  const Slot* s = slot(id);
  return s ? s->tags : 0;
}

void Objects::set_tags(ObjectId id, TagMask tags) {
  FEDER_ASSERT(alive(id));
  const Command command(log_, "objects.set_tags", id, tags);
  slots_[id.slot].tags = tags;
}

TagMask Objects::known_tag(std::string_view tag) const {
  for (std::size_t i = 0; i < tag_names_.size(); ++i)
    if (tag_names_[i] == tag) return TagMask(1) << i;
  return 0;
}

TagMask Objects::tag_bit(std::string_view tag) {
  if (const TagMask known = known_tag(tag)) return known;
  const Command command(log_, "objects.tag_bit", tag);
  if (tag_names_.size() == 64)
    throw SceneError("tags: a world knows at most 64 different tags, '" + std::string(tag) + "' is one more");
  tag_names_.emplace_back(tag);
  return TagMask(1) << (tag_names_.size() - 1);
}

ObjectId Objects::find(std::string_view name) const {
  for (std::uint32_t i = 0; i < slots_.size(); ++i)
    if (slots_[i].alive && texts(slots_[i]).name == name) return {i, slots_[i].generation};
  return {};
}

std::size_t Objects::count(ObjectKind kind) const {
  std::size_t n = 0;
  for (const Slot& s : slots_) n += s.alive && kinds_[s.kind] == kind;
  return n;
}

std::size_t Objects::bytes() const {
  return slots_.capacity() * sizeof(Slot) + texts_.capacity() * sizeof(Texts) +
         (free_.capacity() + free_texts_.capacity()) * sizeof(std::uint32_t);
}

void Objects::validate() const {
  FEDER_ASSERT(free_head_ <= free_.size());
  FEDER_ASSERT(tag_names_.size() <= 64);
  for (const Slot& s : slots_) FEDER_ASSERT(s.generation > 0 && s.kind < kinds_.size());
  const auto with = std::count_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.texts != kNone; });
  FEDER_ASSERT(static_cast<std::size_t>(with) + free_texts_.size() == texts_.size());
  const std::span<const std::uint32_t> free(free_.data() + free_head_, free_.size() - free_head_);
  const bool listed = lists_free(free, slots_.size(), [&](std::uint32_t i) { return !slots_[i].alive; });
  FEDER_ASSERT(listed);
}

void Objects::save(Writer& w) const {
  w.add(static_cast<std::uint64_t>(slots_.size()));
  for (const Slot& s : slots_) {
    const std::string kind = kinds_[s.kind].text();
    const Texts& own = texts(s);
    for_each_of(saved_to(w), s.generation, s.index, kind, s.alive, s.tags, own.name, own.destroyed_at);
  }
  w.list(free_);
  w.add(static_cast<std::uint64_t>(free_head_));
  w.add(static_cast<std::uint64_t>(tag_names_.size()));
  for (const std::string& t : tag_names_) w.text(t);
}

void Objects::load(Reader& r) {
  std::uint64_t n = 0;
  r.get(n);
  slots_.assign(n, {});
  texts_.clear(), free_texts_.clear();
  std::string kind;
  for (Slot& s : slots_) {
    Texts own;
    for_each_of(loaded_from(r), s.generation, s.index, kind, s.alive, s.tags, own.name, own.destroyed_at);
    set_texts(s, std::move(own));
    const auto known = std::find_if(kinds_.begin(), kinds_.end(), [&](ObjectKind k) { return kind == k.text(); });
    if (known == kinds_.end()) throw SceneError("snapshot: this build has no objects of the kind '" + kind + "'");
    s.kind = static_cast<std::uint8_t>(known - kinds_.begin());
  }
  r.list(free_);
  r.get(n);
  free_head_ = n;
  r.get(n);
  tag_names_.resize(n);
  for (std::string& t : tag_names_) r.text(t);
}

}  // namespace feder
