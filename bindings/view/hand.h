// The mouse in the world: what a ray meets, and how a grip pulls. Reads the world; what it wants done comes back as
// commands. Nothing here acts unless something is held.
#pragma once
#include <optional>
#include <string>

#include "view/scene_run.h"

namespace feder::view {

struct Ray {
  Vec3 origin = Vec3::Zero(), direction = Vec3(0, 0, -1);  // unit
};

// What a ray meets first.
struct Pick {
  ObjectId object;
  std::uint32_t point = kNone;   // of a net
  Vec3 position = Vec3::Zero();  // world, m
  Real depth = 0;                // along the ray, m
  bool movable = false;          // a dynamic body or a net point
};

// `slack`: radians by which the ray may miss a net point.
std::optional<Pick> pick(World& world, const Ray& ray, Real slack);

struct Grip {
  ObjectId object;
  std::uint32_t point = kNone;  // of a net; it is pinned while it is held
  bool was_pinned = false;
  Vec3 local = Vec3::Zero();   // body frame, m
  Vec3 target = Vec3::Zero();  // where the mouse wants it, world, m
};

Grip grip(World& world, const Pick& pick);
Vec3 grip_position(World& world, const Grip& grip);  // of the held place now
bool alive(World& world, const Grip& grip);
// What has to be done when it is taken, before each step, and when it is let go. Letting go throws: the speed stays.
Command take_command(const Grip& grip);
Command pull_command(World& world, const Grip& grip);
Command release_command(World& world, const Grip& grip, bool pin);

// Holds a movable thing in its place, or frees it again. Empty for what cannot be pinned.
Command pin_command(World& world, const Pick& pick);
bool is_pinned(World& world, const Pick& pick);

// Lua text that shoots a ball along the ray; `number` makes its name.
std::string shot_text(const World& world, const Ray& ray, Real radius, Real speed, int number);

}  // namespace feder::view
