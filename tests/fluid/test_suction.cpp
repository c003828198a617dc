// Negative pressure (dfsph): a column hangs in a tube that is closed above and open below, as a barometer's does;
// without it falls out. What bears suction keeps its momentum, and lies as still as other water.
#include <cmath>

#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Water in a tube of 8 spacings in a basin: mean height of the particles in the tube above the basin's level, m.
struct Barometer {
  explicit Barometer(double negative_pressure, int threads = 1) : w(fluid_world(2, threads), fluid_catalog()) {
    const Real d = kSpacing, side = Real(0.05);
    add_tank(w, vec3(40 * d, 0, 0));
    const auto block = [&](Real x0, Real y0, Real x1, Real y1) {
      BodyDesc b;
      b.type = BodyType::fixed;
      b.shape = make_box(x1 - x0, y1 - y0, 1)->section();
      b.position = vec3((x0 + x1) / 2, (y0 + y1) / 2, 0);
      w.need<Rigid>().add_body(b);
    };
    block(16 * d - side, 4 * d, 16 * d, 30 * d + side), block(24 * d, 4 * d, 24 * d + side, 30 * d + side);
    block(16 * d, 30 * d, 24 * d, 30 * d + side);
    FluidDesc f;
    f.spacing = d, f.negative_pressure = static_cast<Real>(negative_pressure);
    Fluid& fluid = w.need<Fluid>();
    id = fluid.add_fluid(f);
    const auto fill = [&](Real x0, Real y0, Real x1, Real y1) {
      Pose pose;
      pose.position = vec3((x0 + x1) / 2, (y0 + y1) / 2, 0);
      fluid.fill(id, *make_box(x1 - x0, y1 - y0, 1)->section(), pose, Vec3::Zero());
    };
    fill(0, 0, 40 * d, 4 * d);
    fill(0, 4 * d, 16 * d - side, 8 * d), fill(24 * d + side, 4 * d, 40 * d, 8 * d);
    fill(16 * d, 4 * d, 24 * d, 30 * d);
  }
  double hanging() {
    int n = 0;
    for (const Vec3& x : places(w, id)) n += x[0] > 16 * kSpacing && x[0] < 24 * kSpacing && x[1] > 4 * kSpacing;
    return n / (8.0 * 26);
  }
  static constexpr Real kSpacing = Real(0.02);
  World w;
  ObjectId id;
};

}  // namespace

TEST_CASE("a column hangs by its suction, and falls without", "[fluid][suction]") {
  if (!kFull) return;
  Barometer hangs(1), falls(0);
  run(hangs.w, 4), run(falls.w, 4);
  CAPTURE(hangs.hanging(), falls.hanging());
  CHECK(hangs.hanging() > 0.95);
  CHECK(falls.hanging() < 0.5);
  // -rho g (H - h): 0.4 m above the basin
  const double top = hangs.w.query<Fluid>()->pressure_at(hangs.id, vec3(Real(0.4), Real(0.56), 0));
  CHECK(top < -1000);
}

TEST_CASE("suction is the same on any number of threads, and after a restore", "[fluid][suction][threads]") {
  Barometer one(1), two(1, 2);
  for (int k = 0; k < 15; ++k) one.w.step(), two.w.step();
  CHECK(one.w.hash() == two.w.hash());
  const std::string image = one.w.snapshot();
  for (int k = 0; k < 5; ++k) one.w.step();
  const std::uint64_t hash = one.w.hash();
  one.w.restore(image);
  for (int k = 0; k < 5; ++k) one.w.step();
  CHECK(one.w.hash() == hash);
}

TEST_CASE("what bears suction keeps its momentum", "[fluid][suction]") {
  World w(weightless(fluid_world(3)), fluid_catalog());
  FluidDesc d;
  d.negative_pressure = 1;
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(d);
  f.fill(id, *make_box(Real(0.4), Real(0.3), Real(0.3)), Pose{}, Vec3::Zero());
  std::vector<Vec3> v;
  for (const Vec3& x : places(w, id)) v.push_back(vec3(x[0] + Real(0.2), x[2], -x[1]));  // drawn out
  f.set_velocities(id, v);
  const Momentum before = w.momentum();
  run(w, 0.5 * kShare);
  const Momentum after = w.momentum();
  const double scale = static_cast<double>(f.particle_mass(id)) * static_cast<double>(v.size()) * 0.2;
  for (int k = 0; k < 3; ++k) CHECK(std::fabs(after.linear[k] - before.linear[k]) < 1e-5 * scale);
  CHECK(w.is_finite());
}

TEST_CASE("only dfsph bears suction, of one atmosphere at most", "[fluid][suction]") {
  World w(fluid_world(2), fluid_catalog());
  FluidDesc d;
  d.negative_pressure = 2;
  CHECK_THROWS_AS(w.need<Fluid>().add_fluid(d), SceneError);
  d.negative_pressure = 1, d.solver = "pbf";
  CHECK_THROWS_AS(w.need<Fluid>().add_fluid(d), SceneError);
}
