// What a script says for the eye only: no part of the world, its hash or its snapshots.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "state/objects.h"

namespace feder::lua {

// `camera = { target =, distance =, yaw =, pitch = }` of a scene; what is not given is fitted.
struct SceneCamera {
  bool has_target = false, has_distance = false, has_yaw = false, has_pitch = false;
  double target[3] = {0, 0, 0};  // m
  double distance = 0;           // m
  double yaw = 0, pitch = 0;     // rad
};

// Of one world.
struct Look {
  std::map<ObjectId, std::uint32_t> colors;              // 0xrrggbb; objects without one are not here
  std::map<ObjectId, std::vector<std::uint32_t>> faces;  // of nets: three point numbers (from 0) per triangle
  std::uint64_t version = 0;                             // goes up when a colour of an older object changes
};

}  // namespace feder::lua
