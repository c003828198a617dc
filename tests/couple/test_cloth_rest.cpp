// Bodies at rest on coarse cloth: no point of a triangle is inside them, over a second, and they lie still.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "couple/cloth_and_rigid.h"
#include "state/bodies.h"
#include "support/catch.h"

using namespace feder;

namespace {

// The least distance of points of all triangles (a raster finer than the body) from the shape's surface, m.
Real nearest(const Cloth& cloth, ObjectId id, const Shape& shape, const Pose& pose) {
  constexpr int kRaster = 12;
  std::vector<std::uint32_t> triangles;
  cloth.triangles(id, triangles);
  Real least = kInfinity;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    Vec3 x[3];
    for (std::size_t k = 0; k < 3; ++k) x[k] = to_local(pose, cloth.point(id, triangles[t + k]));
    for (int i = 0; i <= kRaster; ++i)
      for (int j = 0; i + j <= kRaster; ++j) {
        const Real a = Real(i) / kRaster, b = Real(j) / kRaster;
        Vec3 normal;
        least = std::min(least, shape.distance(x[0] + a * (x[1] - x[0]) + b * (x[2] - x[0]), 1, normal));
      }
  }
  return least;
}

}  // namespace

TEST_CASE("a heavy body rests on coarse cloth and does not sink through between its vertices", "[couple][cloth]") {
  // smaller than a cell of 0.14 m, on a corner, and one over many cells of 0.05 m, which strain most
  const int kind = GENERATE(0, 1, 2, 3, 4);
  const double mass = GENERATE(0.1, 1.0, 3.0);
  World w(WorldDesc{}, kClothAndRigid);
  Rigid& rigid = w.need<Rigid>();
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d;
  d.size[0] = d.size[1] = 1;
  d.nx = d.ny = kind == 4 ? 21 : 8;
  d.self_collision = false;
  d.stretch = kind == 4 ? Real(5000) : Real(20000);
  d.damping = Real(0.02);
  for (const char* name : {"top", "bottom", "left", "right"}) d.pin_names.emplace_back(name);
  const ObjectId id = cloth.add_cloth(d);
  const ShapePtr shapes[] = {make_sphere(Real(0.03)), make_box(Real(0.1), Real(0.1), Real(0.1)),
                             make_box(Real(0.08), Real(0.05), Real(0.06)), make_capsule(Real(0.02), Real(0.08)),
                             make_sphere(Real(0.15))};
  BodyDesc b;
  b.shape = shapes[kind];
  // a thin capsule of ten times the cloth's mass rolls to and fro in its dent for ever
  b.mass = static_cast<Real>(kind == 3 ? mass / 3 : mass);
  b.position = Vec3(Real(0.012), Real(0.2), Real(0.031));  // above the inside of a triangle
  if (kind == 1) {
    b.rotation = rotation_from_to(normalized_or(Vec3(1, 1, 1), Vec3(1, 0, 0)), Vec3(0, -1, 0));
    b.lock = kLockRx | kLockRy | kLockRz;
  }
  b.angular_damping = b.linear_damping = 4;  // or it rolls to and fro in its dent
  const ObjectId body = rigid.add_body(b);
  for (int k = 0; k < 240; ++k) w.step();
  Real least = 1, most = 0, low = 1, high = -1;
  for (int k = 0; k < 60; ++k) {
    w.step();
    low = std::min(low, rigid.pose(body).position[1]), high = std::max(high, rigid.pose(body).position[1]);
    const Real gap = nearest(cloth, id, *shapes[kind], rigid.pose(body));
    least = std::min(least, gap), most = std::max(most, gap);
  }
  CAPTURE(kind, mass, least, most, low, high, cloth.max_strain(id), cloth.substeps(id));
  CHECK(least > Real(0.2) * d.thickness / 2);
  CHECK(most < d.thickness);
  CHECK(high - low < Real(0.002));
}

TEST_CASE("coarse cloth lies on the tip of a mesh that pokes between its vertices", "[couple][cloth]") {
  const bool mesh = GENERATE(true, false);
  World w(WorldDesc{}, kClothAndRigid);
  Rigid& rigid = w.need<Rigid>();
  Cloth& cloth = w.need<Cloth>();
  const std::vector<Vec3> points = {Vec3(Real(-0.3), Real(-0.4), Real(-0.3)), Vec3(Real(0.3), Real(-0.4), Real(-0.3)),
                                    Vec3(Real(0.3), Real(-0.4), Real(0.3)), Vec3(Real(-0.3), Real(-0.4), Real(0.3)),
                                    Vec3(0, 0, 0)};
  const std::vector<std::uint32_t> faces = {0, 1, 2, 0, 2, 3, 0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0};
  const ShapePtr hull = make_hull(points);
  BodyDesc b;
  b.shape = mesh ? make_mesh(points, faces) : hull;
  b.type = BodyType::fixed;
  b.friction_static = b.friction_dynamic = 1;
  const ObjectId body = rigid.add_body(b);
  ClothDesc d;
  d.size[0] = d.size[1] = 1;
  d.nx = d.ny = 9;
  d.friction = 1;
  d.pose.position = Vec3(Real(0.041), Real(0.05), Real(-0.02));
  const ObjectId id = cloth.add_cloth(d);
  Real least = 1;
  for (int k = 0; k < 90; ++k) {
    w.step();
    least = std::min(least, nearest(cloth, id, *hull, rigid.pose(body)));
  }
  CAPTURE(mesh, least);
  // a mesh pushes along the normals of its faces only: the tip may come through by half the thickness and back
  CHECK(least > -(mesh ? Real(1) : Real(0.1)) * d.thickness);
  CHECK(w.is_finite());
}

TEST_CASE("a cloth asleep on a body wakes when that goes, whatever other bodies there are", "[couple][cloth]") {
  World w(WorldDesc{}, kClothAndRigid);
  Rigid& rigid = w.need<Rigid>();
  Cloth& cloth = w.need<Cloth>();
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = make_box(2, Real(0.2), 2);
  const ObjectId table = rigid.add_body(b);
  b.position = Vec3(10, 0, 0);
  rigid.add_body(b);
  ClothDesc d;
  d.nx = d.ny = 9;
  d.pose.position = Vec3(0, Real(0.106), 0);
  const ObjectId id = cloth.add_cloth(d);
  for (int k = 0; k < 60; ++k) w.step();
  cloth.sleep(id);
  w.step();
  REQUIRE(cloth.asleep(id));
  rigid.destroy_body(table, "");
  w.step();
  CHECK_FALSE(cloth.asleep(id));
  int ends = 0;
  for (const Event& e : w.events().list()) ends += e.kind == EventKind::contact_end && e.a == id && e.b == table;
  CHECK(ends == 1);
  for (int k = 0; k < 60; ++k) w.step();
  CHECK(cloth.point(id, 40)[1] < Real(-1));
}

TEST_CASE("a sleeping cloth stops what flies at it", "[couple][cloth]") {
  const Real speed = GENERATE(Real(5), Real(40), Real(100));
  World w(WorldDesc{}, kClothAndRigid);
  Rigid& rigid = w.need<Rigid>();
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d;
  d.nx = d.ny = 17;
  d.pin_names = {"top", "bottom", "left", "right"};
  const ObjectId id = cloth.add_cloth(d);
  for (int k = 0; k < 30; ++k) w.step();
  cloth.sleep(id);
  BodyDesc b;
  b.shape = make_sphere(Real(0.1));
  b.mass = Real(0.05);
  b.position = Vec3(0, 3, 0);
  b.velocity = Vec3(0, -speed, 0);
  const ObjectId body = rigid.add_body(b);
  Real lowest = 1;
  for (int k = 0; k < 60; ++k) {
    w.step();
    lowest = std::min(lowest, rigid.bodies().position[rigid.index(body)][1]);
  }
  CAPTURE(speed, lowest);
  CHECK(lowest > -1);
  CHECK_FALSE(cloth.asleep(id));
}

// Where folds lie is chance: a fine sheet buckles at rates that amplify rounding a thousandfold in a tenth of a second.
TEST_CASE("a drape hangs alike at its corners, and as the mesh of it is mirrored and turned", "[couple][cloth][late]") {
  constexpr int kSide = 31;
  Real mean[2][2] = {};  // height of the corner of each quadrant, m
  for (int image = 0; image < 8; ++image) {
    const auto place = [&](Real x, Real y, Real z) {
      if (image >= 4) x = -x;
      for (int k = 0; k < image % 4; ++k) std::swap(x, z), z = -z;
      return Vec3(x, y, z);
    };
    World w(WorldDesc{}, kClothAndRigid);
    BodyDesc ball;
    ball.shape = make_sphere(Real(0.25));
    ball.type = BodyType::fixed;
    w.need<Rigid>().add_body(ball);
    ClothDesc d;
    const auto at = [](int i, int j) { return static_cast<std::uint32_t>(j * kSide + i); };
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const Real x = Real(i) / (kSide - 1) - Real(0.5), z = Real(j) / (kSide - 1) - Real(0.5);
        d.vertices.push_back(place(x, Real(0.3), z));
        if (i + 1 == kSide || j + 1 == kSide) continue;
        const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), e = at(i, j + 1);
        for (const std::uint32_t k : (i + j) % 2 == 0 ? std::array{a, b, c, a, c, e} : std::array{a, b, e, b, c, e})
          d.triangles.push_back(k);
      }
    Cloth& cloth = w.need<Cloth>();
    const ObjectId id = cloth.add_cloth(d);
    for (int k = 0; k < 300; ++k) w.step();
    Real low = 1, high = -1;
    for (const std::uint32_t corner : {at(0, 0), at(kSide - 1, 0), at(0, kSide - 1), at(kSide - 1, kSide - 1)}) {
      const Vec3 x = cloth.point(id, corner);
      low = std::min(low, x[1]), high = std::max(high, x[1]);
      mean[x[0] > 0][x[2] > 0] += x[1] / 8;
    }
    std::printf("drape of mesh %d: corners from %.3f to %.3f m\n", image, double(low), double(high));
    CHECK(high - low < Real(0.02));
    CHECK(high < Real(-0.28));  // of -.31 m where they hang straight down
  }
  const auto [least, most] = std::minmax({mean[0][0], mean[0][1], mean[1][0], mean[1][1]});
  std::printf("mean over eight: from %.4f to %.4f m\n", double(least), double(most));
  CHECK(most - least < Real(0.002));
}
