// Air and wind on ropes: closed forms of a cylinder in cross-flow, and whom forces act on.
#include "base/double3.h"
#include "feder/force.h"
#include "ropes.h"

namespace feder::test {
namespace {

constexpr double kDrag = 1.2, kAir = 1.2, kRadius = 0.01;  // defaults

RopeDesc light_rope(const Vec3& a, const Vec3& b, int segments = 20) {
  RopeDesc d = straight_rope(a, b, segments);
  d.density = 50;
  return d;
}

double weight_per_length(const RopeDesc& d) { return number(d.density) * M_PI * kRadius * kRadius * 9.81; }

void blow(World& w, double x, double z) {
  Params options;
  options.set("velocity", std::vector<double>{x, 0, z});
  ForceEntry on;
  on.all = true;
  w.add_force("wind", options, std::move(on), "", 0);
}

Double3 mean_velocity(const Rope& rope, ObjectId id) {
  Double3 sum{0, 0, 0};
  const std::size_t n = rope.point_count(id);
  for (std::size_t i = 0; i < n; ++i) sum = sum + (1 / double(n)) * wide(rope.velocity(id, i));
  return sum;
}

}  // namespace

TEST_CASE("a rope sinks through still air at the speed where the drag of a cylinder carries it", "[rope][air]") {
  const double air = GENERATE(0.0, 0.6, 1.2), drag = GENERATE(0.0, 1.2, 2.0);
  WorldDesc wd;
  wd.sleeping = false;
  wd.options.set("air_density", air);
  World w(wd, catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = light_rope(Vec3(-1, 0, 0), Vec3(1, 0, 0));
  d.drag = static_cast<Real>(drag);
  d.bend = 1;  // a limp one flutters
  const ObjectId id = rope.add_rope(d);
  for (int k = 0; k < 240; ++k) w.step();
  const double speed = -mean_velocity(rope, id).y;
  CAPTURE(air, drag, speed);
  if (air * drag == 0)
    CHECK(speed == Approx(9.81 * 4).epsilon(1e-3));
  else
    CHECK(speed == Approx(std::sqrt(2 * weight_per_length(d) / (air * drag * 2 * kRadius))).epsilon(0.01));
}

TEST_CASE("along its length air only rubs", "[rope][air]") {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = light_rope(Vec3(0, 0, 0), Vec3(0, 2, 0));
  d.bend = 1;
  const ObjectId id = rope.add_rope(d);
  for (int k = 0; k < 60; ++k) w.step();
  // v' = g - q v^2: v = sqrt(g/q) tanh(sqrt(g q) t), q by the skin's share of the drag across
  const double q = 0.02 * kDrag * kAir * 2 * kRadius / 2 / (weight_per_length(d) / 9.81);
  CHECK(-mean_velocity(rope, id).y == Approx(std::sqrt(9.81 / q) * std::tanh(std::sqrt(9.81 * q))).epsilon(0.002));
}

// Across the rope weight w sin(phi) and drag q cos^2(phi) balance at every point, so that it hangs straight
// and nothing bends it. The end of a limp one flutters: where its waves are slower than the air along it.
TEST_CASE("in steady wind a rope hangs straight, at the angle where weight and drag across it balance", "[rope][air]") {
  const double speed = GENERATE(2.0, 4.0, 8.0), direction = GENERATE(0.0, 1.1);
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = light_rope(Vec3(0, 0, 0), Vec3(0, -1, 0));
  d.pins = {0}, d.bend = Real(0.05);
  const ObjectId id = rope.add_rope(d);
  const double x = std::cos(direction), z = std::sin(direction);
  blow(w, speed * x, speed * z);
  for (int k = 0; k < 60 * 20; ++k) w.step();
  const double weight = weight_per_length(d), q = 0.5 * kAir * kDrag * 2 * kRadius * speed * speed;
  const double sine = (-weight + std::sqrt(weight * weight + 4 * q * q)) / (2 * q), angle = std::asin(sine);
  CAPTURE(speed, angle, mean_velocity(rope, id).y);
  for (const std::size_t i : {5, 10, 20}) {
    const Double3 p = wide(rope.point(id, i));
    CHECK(std::atan2(p.x * x + p.z * z, -p.y) == Approx(angle).epsilon(0.01));
    CHECK(std::fabs(p.x * z - p.z * x) < 1e-3);
  }
}

TEST_CASE("drag of a light rope at high speed stops it and never turns it round", "[rope][air]") {
  const bool wind = GENERATE(false, true);
  WorldDesc wd;
  wd.sleeping = false;
  wd.gravity = Vec3(0, 0, 0);
  World w(wd, catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = light_rope(Vec3(-1, 0, 0), Vec3(1, 0, 0));
  d.density = Real(0.5), d.bend = 1;
  d.velocity = Vec3(0, -300, 0);
  const ObjectId id = rope.add_rope(d);
  if (wind) blow(w, 0, 0);
  double last = 300;
  for (int k = 0; k < 30; ++k) {
    w.step();
    const double now = -mean_velocity(rope, id).y;
    CHECK(now <= last + 1e-4);
    CHECK(now >= -1e-4);
    last = now;
  }
  CHECK(last < 5);
}

TEST_CASE("forces act on ropes by tag or name, and ropes in wind stay awake", "[rope][air]") {
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  World w(wd, catalog());
  Rope& rope = w.need<Rope>();
  const char* const kind = GENERATE("wind", "attractor");
  ObjectId ropes[3];
  for (int i = 0; i < 3; ++i) {
    RopeDesc d = light_rope(Vec3(-1, static_cast<Real>(i), 0), Vec3(1, static_cast<Real>(i), 0));
    d.tags = i == 0 ? 2 : 1;
    ropes[i] = rope.add_rope(d);
  }
  Params options;
  if (std::string(kind) == "wind")
    options.set("velocity", std::vector<double>{0, 0, 3});
  else
    options.set("position", std::vector<double>{0, 0, 100}), options.set("strength", 0.01), options.set("power", 1.0);
  ForceEntry by_tag, by_name;
  by_tag.tags = 2, by_name.target = ropes[1];
  w.add_force(kind, options, std::move(by_tag), "", 0);
  w.add_force(kind, options, std::move(by_name), "", 0);
  for (int k = 0; k < 240; ++k) w.step();
  CHECK(mean_velocity(rope, ropes[0]).z > 0.2);
  CHECK(mean_velocity(rope, ropes[1]).z == Approx(mean_velocity(rope, ropes[0]).z).epsilon(1e-3));
  CHECK(mean_velocity(rope, ropes[2]).z == 0);
  CHECK_FALSE(rope.asleep(ropes[0]));
  CHECK(rope.asleep(ropes[2]));
}

}  // namespace feder::test
