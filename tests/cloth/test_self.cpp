// Cloth against itself: no crossing at any frame, by the independent count of crossings.h.
#include <cmath>
#include <cstdio>

#include "cloth/crossings.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

// A sheet bent double about its middle, the layers `gap` apart; rows beyond the bend lie above.
Vec3 folded(const Vec3& flat, Real gap) {
  const Real radius = gap / 2, half = kPi * radius / 2, x = flat[0];
  if (x < -half) return Vec3(x + half, 0, flat[2]);
  if (x > half) return Vec3(half - x, gap, flat[2]);
  const Real angle = (x + half) / radius;
  Real s = 0, c = 1;
  sin_cos(angle, s, c);
  return Vec3(radius * s, radius * (1 - c), flat[2]);
}

}  // namespace

TEST_CASE("the count of crossings finds them", "[cloth]") {
  Soup s;
  s.points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0.2, -1, 0.2}, {0.2, 1, 0.2}, {2, 1, 2}};
  s.triangles = {0, 1, 2, 3, 4, 5};
  CHECK(count_crossings(s) >= 1);
  s.points[3] = {0.2, 0.1, 0.2};
  CHECK(count_crossings(s) == 0);
}

TEST_CASE("a sheet folded on itself, pressed and let fall for 10 s never crosses itself", "[cloth][late]") {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  const std::uint32_t n = sizeof(Real) == 4 ? 40 : 24;  // double is three times slower
  ClothDesc d = sheet(n, n, 1, 1);
  d.thickness = Real(0.01);
  d.bend = Real(1e-5);
  // The lower layer's border is held, the upper layer falls on it and slides. Held to 2/5 of the length, a loop of .14
  // m hangs over the edge and friction holds .4 x .35 m: then the mesh decides whether all of it slides off.
  for (std::uint32_t j = 0; j < n; ++j) d.pins.push_back(n * j);
  for (std::uint32_t i = 0; i < 9 * n / 20; ++i) d.pins.push_back(i), d.pins.push_back((n - 1) * n + i);
  const ObjectId id = cloth.add_cloth(d);
  for (std::size_t i = 0; i < n * n; ++i) cloth.set_point(id, i, folded(cloth.point(id, i), Real(0.06)));
  std::size_t worst = 0, frames = 0;
  const int steps = kAsserts ? 300 : 600;  // with asserts it is ten times slower, and lies after 5 s
  for (int k = 0; k < steps; ++k) {
    w.step();
    Soup s;
    s.add(cloth, id);
    const std::size_t crossings = count_crossings(s);
    worst = std::max(worst, crossings);
    frames += crossings > 0;
  }
  std::printf("folded sheet: %zu frames with crossings, at most %zu; stretch %.3f\n", frames, worst,
              static_cast<double>(cloth.max_strain(id)));
  CHECK(frames == 0);
  CHECK(w.is_finite());
  // it lies on itself: the upper layer has come down to the thickness and not through
  const Real between = cloth.point(id, n / 2 * n + 7 * n / 8)[1] - cloth.point(id, n / 2 * n + n / 10)[1];
  CHECK(std::abs(between) < Real(0.1));
}

TEST_CASE("vertices on one spot, or triangles without area, give no number that is not finite", "[cloth]") {
  const int kind = GENERATE(0, 1, 2, 3);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(9, 9, Real(0.2), Real(0.2));
  const ObjectId id = cloth.add_cloth(d);
  const Vec3 at = cloth.point(id, 40);
  if (kind == 0) cloth.set_point(id, 41, at);                               // an edge
  if (kind == 1) cloth.set_point(id, 41, at), cloth.set_point(id, 49, at);  // a triangle
  if (kind == 2) cloth.set_point(id, 41, cloth.point(id, 12));              // far vertices
  if (kind == 3)
    for (std::size_t i = 0; i < 81; ++i) cloth.set_point(id, i, at);
  for (int k = 0; k < 30; ++k) w.step();
  CAPTURE(kind);
  CHECK(w.is_finite());
}

TEST_CASE("shreds that are caught in each other give up their stretch and their motion", "[cloth][late]") {
  const Real speed = GENERATE(Real(10), Real(30));
  WorldDesc wd;
  wd.options.set("air_density", 0.0);  // where these shreds get free; others stay jammed, see tests/README.md, Cloth
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(10, 10, 1, 1);
  d.stretch = 1e4, d.shear = 1e3, d.bend = Real(1e-4), d.damping = Real(0.01);
  d.thickness = Real(0.01);
  d.tear_strain = Real(0.5);
  d.pins = {0, 9, 8};
  const ObjectId id = cloth.add_cloth(d);
  const double height = w.energy().potential;
  // one vertex is torn away upwards, over 2 m, and let go
  Vec3 x = cloth.point(id, 8);
  for (int k = 0; k < 12; ++k) {
    w.step();
    x[1] += speed / 60;
    if (x[1] < 2) cloth.set_point(id, 8, x);
  }
  cloth.unpin(id, 8);
  double strain = 0, mass = 0;
  for (int k = 0; k < 240; ++k) {
    w.step();
    for (const Residual& r : w.residuals())
      if (r.name == "cloth.max_strain") strain = r.value;
  }
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) mass += double(cloth.point_mass(id, i));
  CHECK(mass == Approx(0.2).epsilon(1e-3));
  // what falls off may fall as fast as it likes, from where it hung
  const double thrown = w.energy().kinetic + w.energy().potential - height;
  CAPTURE(speed, thrown, w.energy().kinetic, w.energy().elastic);
  CHECK(strain < 0.5);
  CHECK(w.energy().elastic < 5);
  CHECK(thrown < 0.5 * mass * 15 * 15);  // shreds in flight; the vertex was drawn at 10 to 30 m/s
}
