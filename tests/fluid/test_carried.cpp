// Emitters and drains that ride on bodies, and the layers of jets.
#include <algorithm>
#include <cmath>

#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A small ball of lead that fluid does not meet.
BodyDesc carrier(BodyType type, const Vec3& position, const Vec3& velocity) {
  BodyDesc b;
  b.type = type, b.shape = make_sphere(Real(0.01)), b.density = 11000;
  b.position = position, b.velocity = velocity;
  b.mask = 2;
  b.can_sleep = false;
  return b;
}

std::vector<std::string> warnings(World& w, const std::string& code) {
  std::vector<std::string> found;
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning && w.events().warning_code(e) == code)
      found.push_back(w.events().warning_message(e));
  return found;
}

}  // namespace

TEST_CASE("an emitter on a body moves with it, and the jet has the velocity of both", "[fluid][carried]") {
  const BodyType type = GENERATE(BodyType::dynamic, BodyType::kinematic);
  World w(weightless(fluid_world()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  const ObjectId cart = w.need<Rigid>().add_body(carrier(type, vec3(1, 2, 3), vec3(4, 0, 0)));
  FluidDesc d;
  const ObjectId id = f.add_fluid(d);
  EmitterDesc e;
  e.body = cart, e.position = vec3(0, Real(-0.5), 0), e.direction = vec3(0, -1, 0), e.speed = 3, e.radius = 0;
  f.add_emitter(id, e);
  run(w, 0.5);
  std::vector<Vec3> v, x = places(w, id);
  f.velocities(id, v);
  REQUIRE(v.size() >= 29);
  for (const Vec3& u : v) CHECK(length(Vec3(u - vec3(4, -3, 0))) < Real(1e-3));
  // in the frame of the cart they lie below one another, from the nozzle on
  for (const Vec3& q : x) {
    CHECK(q[0] == Approx(1 + 4 * 0.5).margin(1e-3));
    CHECK(q[2] == Approx(3).margin(1e-3));
  }
  const auto nearest = std::max_element(x.begin(), x.end(), [](const Vec3& a, const Vec3& b) { return a[1] < b[1]; });
  CHECK((*nearest)[1] == Approx(1.5).margin(0.051));
}

TEST_CASE("a nozzle that turns with its body throws what leaves it", "[fluid][carried]") {
  World w(weightless(fluid_world()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  BodyDesc b = carrier(BodyType::kinematic, Vec3::Zero(), Vec3::Zero());
  b.angular_velocity = vec3(0, 0, 2);
  const ObjectId arm = w.need<Rigid>().add_body(b);
  FluidDesc d;
  const ObjectId id = f.add_fluid(d);
  EmitterDesc e;
  e.body = arm, e.position = vec3(1, 0, 0), e.direction = vec3(1, 0, 0), e.speed = 5, e.radius = 0;
  f.add_emitter(id, e);
  run(w, 0.25);
  std::vector<Vec3> v, x = places(w, id);
  f.velocities(id, v);
  REQUIRE(v.size() > 20);
  // 5 m/s outwards and 2 rad/s at 1 m across, when each left: speed and angular momentum tell
  for (std::size_t i = 0; i < v.size(); ++i) {
    CHECK(length(v[i]) == Approx(std::sqrt(29.0)).epsilon(0.01));
    CHECK(cross(x[i], v[i])[2] == Approx(2).margin(0.2));
  }
}

TEST_CASE("a drain on a body takes what its volume meets", "[fluid][carried]") {
  World w(weightless(fluid_world()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  const ObjectId mouth = w.need<Rigid>().add_body(carrier(BodyType::kinematic, vec3(-1, 0, 0), vec3(1, 0, 0)));
  FluidDesc d;
  d.spacing = Real(0.1);
  const ObjectId id = f.add_fluid(d);
  std::vector<Vec3> points;
  for (int k = 0; k < 10; ++k) points.push_back(vec3(Real(0.2) * static_cast<Real>(k) + Real(0.13), 1, 0));
  f.fill(id, points, Vec3::Zero());
  Pose above;
  above.position = vec3(0, 1, 0);
  const ObjectId drain = f.add_drain(id, "", 0, make_box(Real(0.1), Real(0.5), Real(0.5)), above, mouth);
  run(w, 1);
  CHECK(f.passed(drain) == 0);
  const std::string image = w.snapshot();
  run(w, 1);
  CHECK(f.passed(drain) == 5);
  const std::uint64_t hash = w.hash();
  w.restore(image);
  run(w, 1);
  CHECK(w.hash() == hash);
  CHECK(f.passed(drain) == 5);
}

TEST_CASE("what rode on a body that is no more stops, with one warning each", "[fluid][carried]") {
  World w(weightless(fluid_world()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  BodyDesc b = carrier(BodyType::dynamic, Vec3::Zero(), Vec3::Zero());
  b.name = "cart";
  const bool alone = GENERATE(true, false);
  if (!alone) add_plane(w, vec3(0, 1, 0), -9);
  const ObjectId cart = w.need<Rigid>().add_body(b);
  const ObjectId id = f.add_fluid(FluidDesc{});
  EmitterDesc e;
  e.name = "hose", e.body = cart;
  const ObjectId hose = f.add_emitter(id, e);
  Pose pose;
  const ObjectId drain = f.add_drain(id, "mouth", 0, make_box(9, Real(0.5), 9), pose, cart);
  pose.position = vec3(0, -1, 0);
  run(w, 0.2);
  const std::uint64_t made = f.passed(hose), taken = f.passed(drain);
  CHECK(made > 0);
  w.need<Rigid>().destroy_body(cart, "scene.lua:7");
  w.step();
  const auto told = warnings(w, "source_lost");
  REQUIRE(told.size() == 1);
  CHECK(told[0] ==
        "emitter \"hose\" stops: body \"cart\", which it rode on, was destroyed at scene.lua:7; drain "
        "\"mouth\" stops: body \"cart\", which it rode on, was destroyed at scene.lua:7; destroy it as "
        "well, or make another one");
  for (int k = 0; k < 20; ++k) {
    w.step();
    CHECK(warnings(w, "source_lost").empty());
  }
  CHECK(f.passed(hose) == made);
  CHECK(f.passed(drain) == taken);
  CHECK_FALSE(f.running(hose));
  CHECK_THROWS_AS(f.add_emitter(id, e), SceneError);  // the body is no more
  CHECK_THROWS_AS(f.add_drain(id, "", 0, make_box(1, 1, 1), pose, id), SceneError);
}

TEST_CASE("the layers of a jet interlock: halves a spacing apart, and no pair closer than 0.8", "[fluid][carried]") {
  const int dimension = GENERATE(2, 3);
  CAPTURE(dimension);
  World w(weightless(fluid_world(dimension)), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.spacing = Real(0.1), d.solver = any_fluid_solver();
  CAPTURE(d.solver);
  const ObjectId id = f.add_fluid(d);
  EmitterDesc e;
  e.direction = dimension == 2 ? vec3(Real(0.6), Real(0.8), 0) : vec3(Real(0.6), 0, Real(0.8));
  e.speed = 10, e.radius = Real(0.35);
  f.add_emitter(id, e);
  run(w, 0.2);
  const std::vector<Vec3> x = places(w, id);
  const std::size_t layer = dimension == 2 ? 7 : 37, early = dimension == 2 ? 3 : 21;
  CHECK((x.size() == 20 * layer + early || x.size() == 20 * layer + layer));
  double nearest = 9;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) nearest = std::min<double>(nearest, length(Vec3(x[i] - x[j])));
  CHECK(nearest > 0.08);
  // of four neighbours at a distance of a spacing across the jet none lies in the same plane
  double even = 0;
  for (std::size_t i = 0; i < layer; ++i) {
    const double behind = static_cast<double>(dot(Vec3(x[0] - x[i]), e.direction));
    CHECK(behind == Approx(i < early ? 0 : 0.05).margin(0.01));
    even += behind < 0.025;
  }
  CHECK(even == static_cast<double>(early));
  double mean = 0, most = 0;
  w.query<Fluid>()->density_error(id, mean, most);
  CHECK(most < 0.04);
}
