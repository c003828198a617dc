// Soft bodies against closed forms of small strains: bar, cube, free fall, frequency. All at default settings.
#include "soft_bodies.h"

namespace feder::test {
namespace {

// A bar of 1 m with a strain of a per cent by E; and its sides.
void check_bar(std::uint32_t across, const std::string& solver) {
  CAPTURE(solver);
  World w(weightless(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(1, Real(0.1), Real(0.1)), 10 * across);
  d.young = Real(1e6), d.poisson = Real(0.3);
  d.solver = solver;
  const ObjectId id = soft.add_soft(d);
  REQUIRE(soft.tetrahedron_count(id) == 50 * std::size_t(across) * across * across);
  const double strain = 0.01;
  pull_faces(soft, id, Vec3(Real(strain * 1e6), 0, 0));
  settle(w, 1, 3e-3);
  const double longer = side(soft, id, 0) - 1;
  CHECK(std::fabs(longer / strain - 1) < (is_springs(solver) ? 0.08 : 0.02));
  for (int axis = 1; axis < 3; ++axis) {
    const double narrower = 1 - side(soft, id, axis) / 0.1;
    CHECK(std::fabs(narrower / (0.3 * longer) - 1) < 0.05);
  }
}

}  // namespace

TEST_CASE("a bar is as long under a force as F L/(E A) says, and as narrow as nu", "[soft]") {
  check_bar(2, any_soft_solver());
}

TEST_CASE("a bar of 8 cells across is as long as F L/(E A) says", "[soft][heavy]") { check_bar(8, "xpbd"); }

TEST_CASE("a cube under pressure shrinks by p/K", "[soft]") {
  const std::string solver = any_soft_solver();
  for (const double nu : {0.0, 0.3, 0.45}) {
    CAPTURE(nu, solver);
    World w(weightless(), catalog());
    Soft& soft = w.need<Soft>();
    SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 4);
    d.poisson = static_cast<Real>(nu);
    d.solver = solver;
    const ObjectId id = soft.add_soft(d);
    const double acts = is_springs(solver) ? std::fmax(nu, 0.25) : nu;
    const double bulk = double(d.young) / (3 * (1 - 2 * acts)), share = 0.005;
    for (int k = 0; k < 60; ++k) {  // as the skin lies: else it would turn over
      pull_faces(soft, id, Vec3::Constant(static_cast<Real>(-share * bulk)));
      w.step();
    }
    const double smaller = 1 - number(soft.volume(id)) / number(soft.rest_volume(id));
    CHECK(std::fabs(smaller / share - 1) < (is_springs(solver) ? 0.18 : 0.02));
  }
}

TEST_CASE("a soft body falls as a stone does", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 3);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  const ObjectId id = soft.add_soft(d);
  const double start = number(soft.point(id, 0)[1]);
  for (int k = 0; k < 60; ++k) w.step();
  CHECK(std::fabs(number(soft.point(id, 0)[1]) - (start - 0.5 * 9.81)) < 1e-4);
  CHECK(std::fabs(number(soft.velocity(id, 0)[1]) + 9.81) < 1e-4);
  CHECK(number(soft.max_strain(id)) < 1e-5);
}

// Longitudinal mode of a free bar: f = sqrt(E/rho)/(2 L) where it is thin.
TEST_CASE("a free bar rings along at the speed of sound over twice its length", "[soft]") {
  WorldDesc desc = weightless();
  SoftDesc d = soft_box(vec3(1, Real(0.1), Real(0.1)), 20);
  d.young = Real(1e5), d.poisson = 0, d.damping = 0, d.density = 1000;
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  const bool damps = is_backward_euler(d.solver);
  if (damps) desc.substeps = 16;
  World w(desc, catalog());
  Soft& soft = w.need<Soft>();
  const ObjectId id = soft.add_soft(d);
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const Real x = soft.rest_point(id, i)[0];
    soft.set_velocity(id, i, vec3(Real(0.02) * static_cast<Real>(std::sin(3.14159265358979 * number(x))), 0, 0));
  }
  const double energy = w.energy().kinetic;
  // zero crossings of the elongation
  double last = 0, first_time = -1, last_time = -1;
  int crossings = 0;
  for (int k = 1; k <= 120; ++k) {
    w.step();
    const double now = side(soft, id, 0) - 1;
    if (last * now < 0) {
      const double t = (k - 1 + last / (last - now)) / 60;
      if (crossings++ == 0) first_time = t;
      last_time = t;
    }
    last = now;
  }
  REQUIRE(crossings > 10);
  const double frequency = (crossings - 1) / (2 * (last_time - first_time));
  CHECK(std::fabs(frequency / 5.0 - 1) < (is_springs(d.solver) ? 0.04 : 0.01));
  // without damping nothing is lost
  if (damps) return;
  const Energy after = w.energy();
  CHECK(std::fabs((after.kinetic + after.elastic) / energy - 1) < (is_springs(d.solver) ? 0.04 : 0.02));
}

TEST_CASE("damping takes what tau w^2/2 says from a mode", "[soft]") {
  WorldDesc desc = weightless();
  SoftDesc d = soft_box(vec3(1, Real(0.1), Real(0.1)), 20);
  d.young = Real(1e5), d.poisson = 0, d.damping = Real(0.002);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  if (is_backward_euler(d.solver)) desc.substeps = 32;  // it counts h = 1/1920 s of its own
  World w(desc, catalog());
  Soft& soft = w.need<Soft>();
  const ObjectId id = soft.add_soft(d);
  const double omega = 2 * 3.14159265358979 * 5;
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const double x = number(soft.rest_point(id, i)[0]);
    soft.set_velocity(id, i, vec3(static_cast<Real>(0.02 * std::sin(3.14159265358979 * x)), 0, 0));
  }
  const double before = w.energy().kinetic;
  for (int k = 0; k < 60; ++k) w.step();
  const Energy after = w.energy();
  CHECK(std::log(before / (after.kinetic + after.elastic)) ==
        Approx(0.002 * omega * omega).epsilon(is_springs(d.solver) ? 0.09 : 0.03));
}

}  // namespace feder::test
