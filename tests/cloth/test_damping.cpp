// `damping` is the time tau of a Kelvin-Voigt material: a bending mode of angular frequency w decays at tau w^2/2,
// for any number of segments and substeps.
#include <cmath>
#include <cstdio>
#include <vector>

#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

struct Swing {
  double frequency = 0, decay = 0;  // rad/s, 1/s
};

// Mode 1 of a clamped strip of 1 m without weight, started with the mode's own velocity: from the extrema of its tip.
Swing swing_of(const char* solver, std::uint32_t segments, int substeps, double tau) {
  WorldDesc wd;
  wd.sleeping = false;
  wd.gravity = Vec3(0, 0, 0);
  wd.options.set("air_density", 0.0);
  wd.substeps = substeps;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  const double omega = 5, root = 1.8751040687, sigma = 0.7340955138;
  ClothDesc d = sheet(segments + 1, 2, 1, Real(1.0 / segments));
  d.solver = solver;
  d.area_density = 1;
  d.stretch = 1e4;
  d.bend = static_cast<Real>(omega * omega / std::pow(root, 4));
  d.damping = static_cast<Real>(tau);
  d.self_collision = false;
  d.pin_names = {"left_clamped"};
  const ObjectId id = cloth.add_cloth(d);
  for (std::uint32_t i = 0; i < 2 * (segments + 1); ++i) {
    const double s = root * (i % (segments + 1)) / segments;
    const double shape = std::cosh(s) - std::cos(s) - sigma * (std::sinh(s) - std::sin(s));
    cloth.set_velocity(id, i, Vec3(0, static_cast<Real>(0.1 * shape), 0));
  }
  // extrema by the parabola through three samples
  double before[2] = {0, 0}, time = 0;
  std::vector<double> when, size;
  while (when.size() < 5 && time < 6) {
    w.step();
    time = w.time();
    const double y = component(cloth.point(id, segments), 1);
    const double a = before[1] - before[0], b = y - before[1];
    if (a * b < 0) {
      const double bend = b - a, at = -(a + b) / (2 * bend);
      when.push_back(time - wd.dt + at * wd.dt);
      size.push_back(std::fabs(before[1] + (a + b) / 2 * at + bend / 2 * at * at));
    }
    before[0] = before[1], before[1] = y;
  }
  if (when.size() < 2) return {};
  const std::size_t n = when.size() - 1;
  const double span = when[n] - when[0];
  return {3.14159265358979 * static_cast<double>(n) / span, std::log(size[0] / size[n]) / span};
}

}  // namespace

TEST_CASE("a bending mode decays at damping w^2/2, for any segments and substeps", "[cloth][damping]") {
  const std::uint32_t segments = GENERATE(10u, 20u, 40u);
  const int substeps = GENERATE(4, 20);
  const Swing still = swing_of("xpbd", segments, substeps, 0);
  std::printf("strip of %u segments, %d substeps: w %.3f, own decay %.4f\n", segments, substeps, still.frequency,
              still.decay);
  for (const double share : {0.02, 0.1, 0.2, 0.4}) {
    const double tau = share / 5;
    const Swing swing = swing_of("xpbd", segments, substeps, tau);
    const double law = tau * still.frequency * still.frequency / 2;
    std::printf("  tau w %.2f: decay %.4f, law %.4f\n", share, swing.decay, law);
    CAPTURE(segments, substeps, tau, swing.decay, law);
    CHECK(swing.decay == Approx(law).epsilon(0.2));
  }
}

TEST_CASE("ten times the damping is ten times the decay", "[cloth][damping]") {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  const char* solver = cloth_solvers()[static_cast<std::size_t>(row)].name;
  if (std::string(solver) == "mass_spring") return;  // a flat sheet of springs has no bending mode
  CAPTURE(solver);
  const double weak = swing_of(solver, 20, 4, 0.008).decay, strong = swing_of(solver, 20, 4, 0.08).decay;
  CHECK(strong / weak == Approx(10).epsilon(0.2));
}

TEST_CASE("damping keeps momentum and angular momentum, and a cloth that turns as a whole does not feel it",
          "[cloth][damping]") {
  WorldDesc wd;
  wd.sleeping = false;
  wd.gravity = Vec3(0, 0, 0);
  wd.options.set("air_density", 0.0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(13, 11, 1, Real(0.8));
  d.bend = Real(0.5);
  d.damping = Real(0.2);
  d.self_collision = false;
  const ObjectId id = cloth.add_cloth(d);
  for (std::uint32_t i = 0; i < 143; ++i) {
    const Vec3 x = cloth.point(id, i);
    const Real wave = static_cast<Real>(0.3 * std::sin(9 * component(x, 0) + 4 * component(x, 2)));
    cloth.set_velocity(id, i, Vec3(Real(0.1), wave + Real(0.2) * x[2], Real(-0.2) * x[1]));
  }
  const Momentum before = w.momentum();
  const double fast = w.energy().kinetic;
  for (int k = 0; k < 60; ++k) w.step();
  const Momentum after = w.momentum();
  const double scale = static_cast<double>(d.area_density) * 0.8 * 0.3;
  for (int k = 0; k < 3; ++k) {
    CHECK(after.linear[k] == Approx(before.linear[k]).margin(2e-5 * scale));
    CHECK(after.angular[k] == Approx(before.angular[k]).margin(1e-3 * scale));
  }
  CHECK(w.energy().kinetic < 0.5 * fast);
}

TEST_CASE("damping beyond what its stages reach is bounded, and says so once", "[cloth][damping]") {
  WorldDesc wd;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(21, 21, 1, 1);
  d.bend = 1;
  d.damping = 1e6;
  d.pin_names = {"top"};
  cloth.add_cloth(d);
  int warned = 0;
  for (int k = 0; k < 5; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "damping_cap") ++warned;
  }
  CHECK(warned == 1);
  CHECK(w.is_finite());
}
