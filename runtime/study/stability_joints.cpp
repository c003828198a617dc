// Stability maps of slender bodies on joints. A thin rod has moments of inertia in the ratio of 2 (thickness/length)^2:
// what a solver takes from another pose, or loses in rounding, turns into spin about the long axis.
#include <algorithm>
#include <cmath>

#include "study/stability_rigid.h"

namespace feder {
namespace {

constexpr double kGravity = 9.81;

// Rods of 1 m and 1 kg in a row along x, each on a joint of the one before, the first on the world.
RigidScene rods(const char* joint, std::size_t count, double thick, double h) {
  RigidScene s;
  s.h = h, s.keeps_energy = true;
  const double n = static_cast<double>(count);
  s.energy = s.energy_start = s.energy_zero = kGravity * n * n / 2;
  s.speed = std::sqrt(2 * kGravity * n);
  for (std::size_t k = 0; k < count; ++k) {
    BodyDesc d;
    d.shape = make_box(1, static_cast<Real>(thick), static_cast<Real>(thick));
    d.position = Vec3(static_cast<Real>(static_cast<double>(k) + 0.5), 0, 0);
    d.mass = 1;
    JointDesc j;
    j.type = joint;
    j.anchor_a = Vec3(static_cast<Real>(k), 0, 0);
    s.joints.push_back({k == 0 ? RigidScene::kNoBody : k - 1, k, j});
    s.bodies.push_back(d);
    s.watched.push_back(k), s.expected.push_back(Vec3d(0, 0, 0));
  }
  return s;
}

// Angle from hanging straight down of a pendulum with the squared frequency w2, released from the horizontal.
double swing_angle(double w2, double t) {
  const int steps = std::max(100, static_cast<int>(std::ceil(t * 2000)));
  const double h = t / steps;
  double angle = std::acos(0.0), rate = 0;
  for (int i = 0; i < steps; ++i) {  // classical Runge-Kutta, error below 1e-12
    const double a1 = -w2 * std::sin(angle), r2 = rate + h / 2 * a1;
    const double a2 = -w2 * std::sin(angle + h / 2 * rate), r3 = rate + h / 2 * a2;
    const double a3 = -w2 * std::sin(angle + h / 2 * r2), r4 = rate + h * a3;
    const double a4 = -w2 * std::sin(angle + h * r3);
    angle += h / 6 * (rate + 2 * r2 + 2 * r3 + r4);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return angle;
}

RigidScene hinged_rod(double h, double thick) {
  RigidScene s = rods("hinge", 1, thick, h);
  const double steps = std::max(8.0, std::ceil(s.seconds / h - 1e-9));
  const double angle = swing_angle(kGravity * 0.5 / ((1 + thick * thick) / 12 + 0.25), steps * h);
  s.expected[0] = 0.5 * Vec3d(std::sin(angle), -std::cos(angle), 0);
  return s;
}

RigidScene jointed_chain(double links, double slenderness) {
  RigidScene s = rods("ball", static_cast<std::size_t>(links), 1 / slenderness, 1.0 / 60);
  const Real rate = Real(0.5);  // rad/s about the vertical axis: out of the plane
  for (BodyDesc& d : s.bodies) {
    d.velocity = Vec3(0, 0, -rate * d.position[0]);
    d.angular_velocity = Vec3(0, rate, 0);
  }
  s.known = false;
  return s;
}

}  // namespace

std::vector<RigidMap> joint_stability_maps() {
  return {{{"hinged_rod",
            "a rod of 1 m on a hinge swings from the horizontal for 2 s",
            rigid_step_axis(),
            {"thickness", "thickness", "m", true, {1e-3, 3e-3, 1e-2, 3e-2, 0.1}, {1e-3, 1e-2, 0.1}}},
           &hinged_rod},
          {{"jointed_chain",
            "rods of 1 m on ball joints swing from the horizontal for 2 s, 60 steps/s",
            {"links", "links", "", true, {1, 2, 3, 5, 10, 20}, {2, 10}},
            {"slenderness", "length by thickness", "", true, {1, 10, 30, 100, 300, 1000}, {10, 100, 1000}}},
           &jointed_chain}};
}

}  // namespace feder
