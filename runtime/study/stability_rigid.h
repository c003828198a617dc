// Scenes of the stability maps of bodies: what stability_rigid.cpp runs. Private to the module.
#pragma once
#include <vector>

#include "feder/rigid.h"
#include "study/stability_problem.h"

namespace feder {

struct RigidScene {
  // A joint between two of `bodies`; kNoBody: the world.
  struct Joint {
    std::size_t a, b;
    JointDesc joint;
  };
  static constexpr std::size_t kNoBody = static_cast<std::size_t>(-1);

  double h = 1.0 / 60, seconds = 2;
  double gravity = 9.81;
  double length = 1;        // m, what errors are divided by
  double size = 1;          // m, what penetrations and errors of joints are divided by
  double speed = 1;         // m/s, the largest that should be seen
  double energy = 1;        // J, scale
  double energy_start = 0;  // J, kept to the end where keeps_energy
  double energy_zero = 0;   // J, added to the world's energy where keeps_energy
  bool keeps_energy = false;
  bool known = true;  // where the watched bodies end; false: chaos decides
  std::vector<BodyDesc> bodies;
  std::vector<Joint> joints;
  std::vector<std::size_t> watched;  // of bodies
  std::vector<Vec3d> expected;       // where they are in the end
};

struct RigidMap {
  StabilityProblemInfo info;
  RigidScene (*scene)(double x, double y);
};

const StabilityAxis& rigid_step_axis();
std::vector<RigidMap> joint_stability_maps();  // stability_joints.cpp

}  // namespace feder
