// What survives a reload that keeps the world: objects with the same name go on from where they are.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "base/math.h"
#include "world/world.h"

namespace feder::view {

struct BodyState {
  Pose pose;  // of the body frame's origin
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
};

struct NetState {
  std::vector<Vec3> points, velocities;
};

// Named objects; those that share a name are told apart by their order.
struct NamedStates {
  std::map<std::string, std::vector<BodyState>> bodies;  // dynamic and kinematic ones
  std::map<std::string, std::vector<NetState>> nets;
};

NamedStates named_states(World& world);

struct KeptState {
  NamedStates start;  // as the old scene file built them
  NamedStates now;    // when the new file came
  double time = 0;    // s, shown by the clock then
};

// `world` has just been built. An object that the old and the new file start in the same pose (velocity) gets the pose
// (velocity) that it had; where the file says something new, the file is right. Nets need the same number of points.
// Returns how many objects went on.
int apply_kept(World& world, const KeptState& kept);

}  // namespace feder::view
