// Pairs of objects that one finder sees in the contact book: what systems with contacts of surfaces ask of it.
#pragma once
#include "state/contact_book.h"
#include "state/surface.h"

namespace feder {

inline std::size_t count_pairs(const ContactBook& book, std::uint32_t finder) {
  std::size_t sum = 0;
  book.each(finder, [&](const ContactRecord&) { ++sum; });
  return sum;
}

inline void hash_pairs(const ContactBook& book, std::uint32_t finder, Hash& h) {
  book.each(finder, [&](const ContactRecord& r) { h.add(r.key.a.slot), h.add(r.key.b.slot); });
}

// Calls f(left, gone) for pairs of which one object was destroyed.
template <class F>
void each_left(const ContactBook& book, std::uint32_t finder, const Objects& objects, F&& f) {
  book.each(finder, [&](const ContactRecord& r) {
    for (const auto& [left, gone] : {std::pair(r.key.a, r.key.b), std::pair(r.key.b, r.key.a)})
      if (objects.alive(left) && !objects.alive(gone)) f(left, gone);
  });
}

// Null when the object shows no surface in this step.
inline const Surface* surface_of(const Surfaces& all, ObjectId object) {
  for (const Surface& s : all.list)
    if (s.object == object) return &s;
  return nullptr;
}

}  // namespace feder
