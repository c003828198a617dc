// Picking: what a ray meets, and how a grip pulls. Nothing here acts unless something is held.
#pragma once
#include "view/object_view.h"

namespace feder::view {

std::optional<Pick> pick(World& world, const Ray& ray, Real slack);
bool alive(World& world, const Grip& grip);
Grip grip(World& world, const Pick& pick);           // of what was picked just now
Vec3 grip_position(World& world, const Grip& grip);  // of the held place now; it must be alive

// Holds a movable thing in its place, or frees it again. Empty for what cannot be pinned.
Command pin_command(World& world, const Pick& pick);
bool is_pinned(World& world, const Pick& pick);

// Lua text that shoots a ball along the ray; `number` makes its name.
std::string shot_text(const World& world, const Ray& ray, Real radius, Real speed, int number);

}  // namespace feder::view
