// Links of surfaces: a point of a soft thing held to a point of another, or to a place on a body. Kept between steps by
// contact, which holds surfaces to each other; the coupling with bodies reads those to bodies.
#pragma once
#include <string>

#include "feder/events.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"
#include "state/surface.h"

namespace feder {

struct SurfaceLink {
  ObjectId a, b;                       // b: another surface, or a body
  std::uint32_t point = 0, other = 0;  // of a, and of b, from 0 within them
  Vec3 local = Vec3::Zero();           // of a body: the place in its frame, m
  std::uint32_t to_body = 0;           // 1: b is a body
  std::uint32_t warned = 0;            // 1: a gap was reported
};

// The block: a world's links in the order they were made.
struct SurfaceLinks {
  explicit SurfaceLinks(Arena& a) : list(&a) {}
  Array<SurfaceLink> list;

  bool names(ObjectId object) const {
    for (const SurfaceLink& l : list)
      if (l.a == object || l.b == object) return true;
    return false;
  }
};

// Holds point i of `a` to point j of `b`, or where that is a body to the place `local` of its frame, from the next step
// on while both show surfaces with such points; wakes both. SceneError when `b` is no living body or soft thing, or
// both points are one. Systems call it for `a`, whose index they have checked.
void hold_point(Store& store, const Objects& objects, ObjectId a, std::size_t i, ObjectId b, std::size_t j,
                const Vec3& local);
// The same for a body alone.
void hold_to_body(Store& store, const Objects& objects, ObjectId a, std::size_t i, ObjectId body, const Vec3& local);
// Ends all links of that point; false when there are none.
bool release_point(Store& store, const Objects& objects, ObjectId a, std::size_t i);

// Reports once what is held apart by more than half of the mean edge of the surface `s`, whose point it is; `to` names
// the other side.
void warn_of_gap(SurfaceLink& l, const Surfaces& all, const Surface& s, Real gap, const std::string& to,
                 const Objects& objects, Events& events);

}  // namespace feder
