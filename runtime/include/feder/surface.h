// What a part of a compound or a triangle of a mesh states of its surface: friction, restitution, belts, a material.
// What it does not state is its material's, and what that does not state is the body's. Plain data, no errors: shapes
// check it when they are made.
#pragma once
#include <cstdint>
#include <string>

#include "feder/types.h"

namespace feder {

// Each below 0: not stated.
struct SurfaceNumbers {
  Real friction_static = -1, friction_dynamic = -1, restitution = -1;
  Real rolling_friction = -1;  // lever arm, m

  // Calls f(field) for all of them, in this order.
  template <class S, class F>
  static void each_field(S& s, F&& f) {
    f(s.friction_static), f(s.friction_dynamic), f(s.restitution), f(s.rolling_friction);
  }
};

struct ShapeSurface {
  SurfaceNumbers numbers = {};
  bool has_velocity = false;
  Vec3 velocity = Vec3::Zero();  // body frame, m/s, when has_velocity
  std::string material = {};     // of the world's; "": not stated

  template <class S, class F>
  static void each_field(S& s, F&& f) {
    SurfaceNumbers::each_field(s.numbers, f), f(s.has_velocity), f(s.velocity), f(s.material);
  }
};

// Numbers of a list of surfaces: from 1; 0 is the body's own surface.
using SurfaceNumber = std::uint16_t;
inline constexpr std::size_t kMaxSurfaces = 0xffff;

// What is stated takes the place of what was there.
inline void override_numbers(SurfaceNumbers& all, const SurfaceNumbers& by) {
  if (by.friction_static >= 0) all.friction_static = by.friction_static;
  if (by.friction_dynamic >= 0) all.friction_dynamic = by.friction_dynamic;
  if (by.restitution >= 0) all.restitution = by.restitution;
  if (by.rolling_friction >= 0) all.rolling_friction = by.rolling_friction;
}

}  // namespace feder
