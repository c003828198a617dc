// Tangles: crossings of a surface with itself, found where its owner suspects them and led out. Private to the module.
#pragma once
#include "geom/crossings.h"
#include "state/surface.h"

namespace feder {

struct Tangles {
  explicit Tangles(Arena& a)
      : search(a), found(&a), after(&a), start(&a), now(&a), trial(&a), shift(&a), of(&a), faces(&a), counts(&a) {}

  // An edge that crosses, and what lies across it.
  struct Faces {
    std::uint32_t a = 0, b = 0, opposite[2] = {kNone, kNone};
  };
  // Crossings of a connected bunch, by its lowest point, before and after a trial.
  struct Counts {
    std::uint32_t before = 0, after = 0;
  };

  CrossingSearch search;
  Array<Crossing> found, after;   // now, and after a trial
  Array<Vec3> start, now, trial;  // by point of the surface, m
  Array<Vec3> shift;              // likewise, of a trial, m
  Array<std::uint32_t> of;        // by point: a point of its bunch, itself for the root
  Array<Faces> faces;             // ascending
  Array<Counts> counts;           // by point
};

}  // namespace feder
