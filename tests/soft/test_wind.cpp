// Wind on the skin of soft bodies.
#include "forces/forces.h"
#include "soft_contact.h"

namespace feder::test {
namespace {

constexpr double kAir = 1.2;  // kg/m^3

void blow(World& w, double speed) {
  Params options;
  options.set("velocity", std::vector<double>{speed, 0, 0});
  ForceEntry on;
  on.all = true;
  w.add_force("wind", options, std::move(on), "", 0);
}

double momentum_in_a_step(const SoftDesc& d, double speed) {
  World w(weightless(), catalog());
  w.need<Soft>().add_soft(d);
  blow(w, speed);
  w.step();
  const Momentum p = w.need<Soft>().momentum();
  CHECK(std::fabs(p.linear[1]) + std::fabs(p.linear[2]) < 0.02 * p.linear[0]);
  return p.linear[0] * 60;  // N
}

}  // namespace

// The force on one square metre across the flow is density v^2/2; a sphere, with pressure as the square of the cosine
// on its front, bears 2/3 of that of its cross-section.
TEST_CASE("wind pushes a soft cube as a plate, and a ball by two thirds of that", "[soft]") {
  const double speed = 10, pressure = 0.5 * kAir * speed * speed;
  SoftDesc d = soft_box(vec3(Real(0.5), Real(0.5), Real(0.5)), 4);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  CHECK(momentum_in_a_step(d, speed) / (pressure * 0.25) == Approx(1.02).epsilon(0.02));  // .02: what rubs
  d.shape = make_sphere(Real(0.5)), d.resolution = 8;
  const double sphere = momentum_in_a_step(d, speed) / (pressure * 3.14159265 * 0.25);
  CHECK(sphere == Approx(2.0 / 3 + 0.04).epsilon(0.04));
}

TEST_CASE("a feather-light soft body flies with a storm and no faster", "[soft]") {
  World w(weightless(), catalog());
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.3), Real(0.3)), 3);
  d.density = 2, d.solver = any_soft_solver();
  CAPTURE(d.solver);
  const ObjectId id = w.need<Soft>().add_soft(d);
  blow(w, 50);
  double fastest = 0;
  for (int k = 0; k < 120; ++k) {
    w.step();
    fastest = std::max(fastest, w.need<Soft>().momentum().linear[0] / mass_of(w.need<Soft>(), id));
  }
  CHECK(w.is_finite());
  CHECK(fastest > 30);
  CHECK(fastest < 50);
  CHECK(count_warnings(w, "diverged") == 0);
}

TEST_CASE("what stands in the wind does not sleep", "[soft]") {
  const bool windy = GENERATE(false, true);
  World w(WorldDesc{}, catalog());
  add_ground(w);
  SoftDesc d = soft_box(vec3(Real(0.5), Real(0.5), Real(0.5)), 3);
  d.pose.position = vec3(0, Real(0.27), 0);
  const ObjectId id = w.need<Soft>().add_soft(d);
  if (windy) blow(w, 3);
  for (int k = 0; k < 300; ++k) w.step();
  CHECK(w.need<Soft>().asleep(id) == !windy);
}

}  // namespace feder::test
