// Seams between flush colliders: what rolls or slides over them keeps its speed, and what stands in the way still does.
#include "closed_scene.h"

using namespace feder;

namespace {

constexpr int kTiles = 60;
constexpr Real kStep = Real(5e-5);  // m, between neighbouring tiles

enum Floor { kBoxes, kParts, kMesh, kFloors };
enum Runner { kBall, kCapsule, kBox, kHull, kRunners };

Vec3 tile_at(int i, Real step) { return Vec3(Real(i), Real(-0.5) - (i % 2 ? step : Real(0)), 0); }

void add_floor(ClosedScene& s, int kind, Real step, Real away) {
  BodyDesc d;
  d.type = BodyType::fixed;
  d.friction_static = d.friction_dynamic = 1;
  const ShapePtr tile = make_box(1, 1, 4);
  if (kind == kBoxes) {
    for (int i = 0; i < kTiles; ++i)
      d.shape = tile, d.position = tile_at(i, step) + Vec3(away, 0, 0), s.rigid().add_body(d);
    return;
  }
  d.position = Vec3(away, 0, 0);
  if (kind == kParts) {
    std::vector<CompoundPart> parts;
    for (int i = 0; i < kTiles; ++i) parts.push_back({tile, {tile_at(i, step), {}}});
    d.shape = make_compound(parts);
  } else {
    std::vector<Vec3> corners;
    std::vector<std::uint32_t> triangles;
    for (int i = 0; i <= kTiles; ++i)
      for (const int z : {-2, 2}) corners.push_back(Vec3(Real(i) - Real(0.5), 0, Real(z)));
    for (std::uint32_t i = 0; i < kTiles; ++i)
      for (const std::uint32_t c : {0u, 1u, 2u, 1u, 3u, 2u}) triangles.push_back(2 * i + c);
    d.shape = make_mesh(corners, triangles);
  }
  s.rigid().add_body(d);
}

BodyDesc runner_of(int kind, Real speed) {
  const Real r = Real(0.1);
  BodyDesc d = body_of(make_sphere(r), Vec3(2, r, 0), 1, Real(0.6));
  if (kind == kCapsule) {
    d.shape = make_capsule(r, 5 * r);
    d.rotation = integrate_rotation({}, Vec3(kPi / 2, 0, 0));
  }
  if (kind <= kCapsule) d.angular_velocity = Vec3(0, 0, -speed / r);
  if (kind == kBox) d.shape = make_box(2 * r, 2 * r, 2 * r);
  if (kind == kHull) {
    std::vector<Vec3> points;
    for (const Vec3& p : {Vec3(1, 0, 0), Vec3(Real(0.5), 0, Real(0.87)), Vec3(Real(-0.5), 0, Real(0.87)),
                          Vec3(-1, 0, 0), Vec3(Real(-0.5), 0, Real(-0.87)), Vec3(Real(0.5), 0, Real(-0.87))})
      points.push_back(r * p - Vec3(0, r, 0)), points.push_back(Real(1.2) * r * p + Vec3(0, r, 0));
    d.shape = make_hull(points);
  }
  if (kind >= kBox) d.friction_static = d.friction_dynamic = 0;
  d.velocity = Vec3(speed, 0, 0);
  return d;
}

}  // namespace

TEST_CASE("flush seams do not brake and do not bump", "[rigid][seams]") {
  const int floor = GENERATE(range(0, int(kFloors))), runner = GENERATE(range(0, int(kRunners)));
  const Real step = GENERATE(Real(0), kStep), away = GENERATE(Real(0), Real(1000));
  if (floor == kMesh && step > 0) return;
  for (const Real speed : {Real(0.5), Real(2), Real(8)}) {
    CAPTURE(floor, runner, step, away, speed);
    ClosedScene s("soft_step");
    add_floor(s, floor, step, away);
    BodyDesc d = runner_of(runner, speed);
    d.position += Vec3(away, 0, 0);
    const ObjectId body = s.rigid().add_body(d);
    s.run(0.5);
    Real low = s.position(body)[1], high = low, slowest = speed, fastest = speed;
    const int steps = static_cast<int>(std::min(500.0, 48 / double(speed) * 60));
    for (int k = 0; k < steps; ++k) {
      s.world().step();
      const Real y = s.position(body)[1], v = s.velocity(body)[0];
      low = std::min(low, y), high = std::max(high, y);
      slowest = std::min(slowest, v), fastest = std::max(fastest, v);
    }
    CHECK(slowest > speed * Real(0.999));
    CHECK(fastest < speed * Real(1.001));
    CHECK(high - low < Real(1e-4) + step + away * kEpsilon);
  }
}

// A kerb of 1 cm, a wall on the tiles, the end of the floor.
TEST_CASE("what stands above a seam is in the way", "[rigid][seams]") {
  const Real height = GENERATE(Real(0.01), Real(1));
  const int runner = GENERATE(range(0, int(kRunners)));
  CAPTURE(height, runner);
  ClosedScene s("soft_step");
  add_floor(s, kBoxes, 0, 0);
  BodyDesc kerb;
  kerb.type = BodyType::fixed;
  kerb.shape = make_box(1, height + 1, 4);
  kerb.position = Vec3(Real(5.5), (height - 1) / 2, 0);
  s.rigid().add_body(kerb);
  const ObjectId body = s.rigid().add_body(runner_of(runner, Real(0.3)));
  s.run(12);
  CHECK(s.position(body)[0] < 5);
}

TEST_CASE("a box rests in a corner and over the end of a floor", "[rigid][seams]") {
  ClosedScene s("soft_step");
  add_floor(s, kBoxes, 0, 0);
  BodyDesc wall;
  wall.type = BodyType::fixed;
  wall.shape = make_box(1, 2, 4);
  wall.position = Vec3(5, 1, 0);
  s.rigid().add_body(wall);
  BodyDesc leaning = runner_of(kBox, 0);
  leaning.position = Vec3(Real(4.4), Real(0.1), 0);
  leaning.friction_static = leaning.friction_dynamic = Real(0.5);
  const ObjectId corner = s.rigid().add_body(leaning);
  leaning.position = Vec3(Real(kTiles) - Real(0.57), Real(0.1), 0);
  const ObjectId edge = s.rigid().add_body(leaning);
  s.run(4);
  CHECK(s.position(corner)[0] == Approx(4.4).margin(1e-3));
  CHECK(s.position(corner)[1] == Approx(0.1).margin(1e-3));
  CHECK(s.position(edge)[1] == Approx(0.1).margin(1e-3));
}
