// What is drawn: one bool per layer, found by name (command line, viewer). A layer that is off is not collected.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace feder::view {

inline constexpr std::size_t kLiquidLimit = 100'000;  // 20 ms of one core
inline constexpr int kMaxVolumeLevel = 64;

struct Toggles {
  bool shapes = true;   // rigid bodies
  bool meshes = true;   // faces of nets, cloth, fluid surfaces
  bool points = true;   // net points with a radius, fluid particles
  bool liquid = true;   // fluids as liquids; else by their particles
  bool springs = true;  // coloured by strain
  bool sensors = true;  // translucent
  bool joints = false;
  bool contacts = false;  // points and normals
  bool impulses = false;  // length by normal impulse
  bool velocities = false;
  bool axes = false;                        // centre of mass and body axes
  bool islands = false;                     // bodies of a sleeping island are joined by lines
  bool bounds = false;                      // boxes of the broad phase
  bool volumes = false;                     // of the indices of meshes, at volume_level
  bool cells = false;                       // of the broad phase, at cell_level
  bool labels = false;                      // names
  bool marks = false;                       // this step's events
  bool plots = false;                       // energy, penetration
  bool temporal = false;                    // cloth that trembles is drawn at rest
  std::size_t liquid_limit = kLiquidLimit;  // particles of a fluid in space up to which its surface is built
  int volume_level = 0;                     // below the volume of the whole
  int cell_level = 0;                       // below the root
  const char* point_scalar = "speed";       // what colours points: "speed", "density", "pressure", "none"
};

struct ToggleInfo {
  const char* name;
  const char* help;
  bool Toggles::*field;
};
std::span<const ToggleInfo> toggle_list();
std::span<const char* const> point_scalars();
// "contacts,joints" on, "-springs" off, "volumes=3" and "cells=3" on at that level, "density" colours points by it;
// SceneError that lists the known names.
void set_toggles(Toggles& toggles, std::string_view list);

}  // namespace feder::view
