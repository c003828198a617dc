// Continuous collision at default settings: what is fast passes no wall, and what only brushes along is not stopped.
#include "closed_scene.h"

using namespace feder;

namespace {

constexpr Real kWall = 5;  // m: where its face is

enum class WallKind { box, mesh, mesh_back, compound, plane, plate };
constexpr const char* kWallNames[] = {"box", "mesh", "mesh from behind", "compound", "plane", "moving plate"};

ShapePtr wall_mesh(bool back) {
  const Vec3 corners[] = {Vec3(kWall, -9, -9), Vec3(kWall, 9, -9), Vec3(kWall, 9, 9), Vec3(kWall, -9, 9)};
  const std::vector<std::uint32_t> front = {0, 1, 2, 0, 2, 3}, behind = {0, 2, 1, 0, 3, 2};
  return make_mesh(corners, back ? behind : front);
}

BodyDesc wall_of(WallKind kind) {
  const ShapePtr half = make_box(Real(0.1), 9, 18);
  BodyDesc d;
  d.type = BodyType::fixed;
  d.position = Vec3(kWall + Real(0.05), 0, 0);
  switch (kind) {
    case WallKind::box: d.shape = make_box(Real(0.1), 18, 18); break;
    case WallKind::compound:
      d.shape = make_compound({{half, {Vec3(0, Real(4.5), 0), {}}}, {half, {Vec3(0, Real(-4.5), 0), {}}}});
      break;
    case WallKind::plate:
      d.type = BodyType::kinematic;
      d.shape = make_box(Real(0.1), 18, 18);
      d.velocity = Vec3(-2, 0, 0);
      break;
    case WallKind::plane: d.shape = make_plane(Vec3(-1, 0, 0), -kWall), d.position = Vec3::Zero(); break;
    default: d.shape = wall_mesh(kind == WallKind::mesh_back), d.position = Vec3::Zero();
  }
  return d;
}

ShapePtr shot_shape(int i, Real size) {
  switch (i % 5) {
    case 0: return make_sphere(size / 2);
    case 1: return make_box(size, size, size);
    case 2: return make_capsule(size / 4, size);
    case 3: return make_box(size, size / 5, size / 5);
    default: return make_cylinder(size / 2, size / 3);
  }
}

}  // namespace

// 20 bodies of 2 to 10 cm at 20 speeds from 30 m/s to 10 km/s, spinning, a little aslant, from several places: where in
// a step they arrive decides how they tumble then, at up to 500 turns a step.
TEST_CASE("nothing fast passes a wall", "[rigid][continuous]") {
  const int kind = GENERATE(range(0, 6));
  const Real off = GENERATE(Real(-0.4), Real(-0.2), Real(0), Real(0.05), Real(0.15));
  CAPTURE(kWallNames[kind], off);
  for (int i = 0; i < 20; ++i) {
    const Real speed = Real(30 * std::pow(10'000.0 / 30, i / 19.0)), size = Real(0.02 + 0.08 * (i * 7 % 20) / 19);
    ClosedScene s("soft_step");
    s.desc.gravity = Vec3::Zero();
    const bool moves = static_cast<WallKind>(kind) == WallKind::plate;
    s.rigid().add_body(wall_of(static_cast<WallKind>(kind)));
    BodyDesc d =
        body_of(shot_shape(i, size), Vec3(Real(i % 4) * Real(0.3) + off, Real(0.03), Real(0.02)), 1, Real(0.5));
    d.velocity = Vec3(speed, Real(0.02) * speed * Real(i % 3 - 1), 0);
    d.angular_velocity = Vec3(Real(3 * i), 5, Real(-7 * i));
    d.bullet = moves;
    const ObjectId shot = s.rigid().add_body(d);
    Real deepest = -kInfinity;
    for (int step = 1; step <= 40; ++step) {
      s.world().step();
      const Real face = kWall - (moves ? Real(2 * s.desc.dt * step) : Real(0));
      if (std::abs(s.position(shot)[1]) < 8) deepest = std::max(deepest, s.position(shot)[0] - face);
    }
    CAPTURE(i, speed, size);
    CHECK(deepest < size / 10);  // its middle; a plane may be entered by that much
  }
}

TEST_CASE("a body stopped at its time of impact keeps its velocity for the contact", "[rigid][continuous]") {
  ClosedScene s("soft_step");
  s.desc.gravity = Vec3::Zero();
  BodyDesc wall = wall_of(WallKind::box);
  BodyDesc ball = body_of(make_sphere(Real(0.05)), Vec3::Zero());
  wall.restitution = ball.restitution = 1;
  ball.velocity = Vec3(100, 0, 0);
  s.rigid().add_body(wall);
  const ObjectId shot = s.rigid().add_body(ball);
  s.run(0.3);
  CHECK(s.velocity(shot)[0] <= -99);
}

TEST_CASE("cubes of a millimetre stay on a plate of a millimetre", "[rigid][continuous]") {
  ClosedScene s("soft_step");
  BodyDesc plate;
  plate.type = BodyType::fixed;
  plate.shape = make_box(1, Real(0.001), 1);
  s.rigid().add_body(plate);
  std::vector<ObjectId> cubes;
  for (int i = 0; i < 20; ++i)
    cubes.push_back(s.rigid().add_body(body_of(make_box(Real(0.001), Real(0.001), Real(0.001)),
                                               Vec3(Real(i) / 50 - Real(0.2), Real(0.1) + Real(0.05) * Real(i), 0),
                                               Real(1e-6), Real(0.5))));
  s.run(2);
  for (const ObjectId cube : cubes) CHECK(s.position(cube)[1] > 0);
}

// A fast marble rolls over the seams of a mesh, and a fast box slides over those of flush tiles that it is sunk into:
// what lies ahead is near, but in the way of neither.
TEST_CASE("what brushes along is not stopped", "[rigid][continuous]") {
  const bool mesh = GENERATE(true, false);
  ClosedScene s("soft_step");
  std::vector<Vec3> corners;
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t k = 0; k <= 400; ++k)
    for (const int z : {-1, 1}) corners.push_back(Vec3(Real(k) / 4, 0, Real(z)));
  for (std::uint32_t k = 0; k < 400; ++k)
    for (const std::uint32_t c : {0u, 1u, 2u, 1u, 3u, 2u}) triangles.push_back(2 * k + c);
  BodyDesc floor;
  floor.type = BodyType::fixed;
  floor.shape = mesh ? make_mesh(corners, triangles) : make_box(200, 1, 2);
  if (!mesh) floor.position = Vec3(100, Real(-0.5), 0);
  floor.friction_static = floor.friction_dynamic = 0;
  s.rigid().add_body(floor);
  BodyDesc d = body_of(mesh ? make_sphere(Real(0.01)) : make_box(Real(0.1), Real(0.02), Real(0.1)),
                       Vec3(1, Real(0.01), 0), Real(0.1));
  d.velocity = Vec3(30, 0, 0);
  const ObjectId body = s.rigid().add_body(d);
  s.run(2);
  CHECK(s.position(body)[0] == Approx(61).epsilon(1e-3));
}

// Cubes and balls of 40 cm head on, at rest or moving, from gaps that are no multiple of the way in a step. What is not
// looked for ahead, up to a quarter of the half width a step, may be sunk in; spins as the shape allows.
TEST_CASE("two moving bodies do not pass each other", "[rigid][continuous]") {
  const bool ball = GENERATE(true, false), spins = GENERATE(false, true);
  const Real size = Real(0.4);
  for (int i = 0; i < 24; ++i) {
    const Real speed = Real(5 * std::pow(100, i / 23.0)), gap = Real(0.21) + Real(0.083) * Real(i);
    CAPTURE(ball, spins, speed, gap);
    ClosedScene s("soft_step");
    s.desc.gravity = Vec3::Zero();
    const ShapePtr shape = ball ? make_sphere(size / 2) : make_box(size, size, size);
    BodyDesc a = body_of(shape, Vec3::Zero(), 1), b = body_of(shape, Vec3(size + gap, Real(0.01), 0), 1);
    a.velocity = Vec3(speed, 0, 0);
    if (i % 2) b.velocity = Vec3(-speed / 3, 0, 0);
    if (spins) a.angular_velocity = Vec3(4, 0, 0);
    const ObjectId first = s.rigid().add_body(a), second = s.rigid().add_body(b);
    Real nearest = kInfinity;
    for (int step = 0; step < 60; ++step) {
      s.world().step();
      const Vec3 between = s.position(second) - s.position(first);  // balls slide round each other
      nearest = std::min(nearest, ball ? length(between) : between[0]);
    }
    CHECK(nearest > Real(0.7) * size);
    const Vec3 sum = s.velocity(first) + s.velocity(second);
    CHECK(sum[0] == Approx(a.velocity[0] + b.velocity[0]).epsilon(1e-4));
    CHECK(s.velocity(second)[0] >= s.velocity(first)[0] - Real(1e-3) * speed);
  }
}

TEST_CASE("two moving bodies that miss each other do not feel it", "[rigid][continuous]") {
  const Real aside = GENERATE(Real(0.41), Real(0.5), Real(0.8));
  ClosedScene s("soft_step");
  s.desc.gravity = Vec3::Zero();
  const ShapePtr cube = make_box(Real(0.4), Real(0.4), Real(0.4));
  BodyDesc a = body_of(cube, Vec3::Zero(), 1), b = body_of(cube, Vec3(Real(3.1), aside, 0), 1);
  a.velocity = Vec3(60, 0, 0), b.velocity = Vec3(-40, 0, 0);
  const ObjectId first = s.rigid().add_body(a), second = s.rigid().add_body(b);
  s.run(0.2);
  CHECK(s.velocity(first) == a.velocity);
  CHECK(s.velocity(second) == b.velocity);
}

TEST_CASE("a sweep past too many parts speaks", "[rigid][continuous]") {
  ClosedScene s("soft_step");
  s.desc.gravity = Vec3::Zero();
  for (int k = 0; k < 3000; ++k) {
    BodyDesc d;
    d.type = BodyType::fixed;
    d.shape = make_box(Real(0.001), 1, 1);
    d.position = Vec3(Real(1) + Real(k) * Real(0.004), Real(1), 0);
    s.rigid().add_body(d);
  }
  BodyDesc d = body_of(make_sphere(Real(0.2)), Vec3(0, Real(0.295), 0));
  d.velocity = Vec3(900, 0, 0);
  s.rigid().add_body(d);
  int warnings = 0;
  for (int step = 0; step < 6; ++step) {
    s.world().step();
    for (const Event& e : s.world().events().list())
      warnings += e.kind == EventKind::warning && s.world().events().warning_code(e) == "sweep_limit";
  }
  CHECK(warnings == 1);
}
