// Crossings of a cloth with itself: the count against the independent one, and how they come apart.
#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "cloth/crossings.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

std::size_t counted(const Cloth& cloth, ObjectId id) {
  Soup s;
  s.add(cloth, id);
  return count_crossings(s);
}

}  // namespace

TEST_CASE("tangles() is the independent count", "[cloth]") {
  const int kind = GENERATE(0, 1, 2, 3, 4);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(15, 15, 1, 1);
  // tilted, so that flat is flat within rounding only
  d.pose.rotation = kind == 0 ? Quat(1, 0, 0, 0) : Quat(Real(0.6), Real(0.48), Real(0.64), 0);
  const ObjectId id = cloth.add_cloth(d);
  Rng rng(3);
  for (std::size_t i = 0; i < 225; ++i) {
    const Vec3 x = cloth.point(id, i);
    const Vec3 r(rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1));
    if (kind == 2) cloth.set_point(id, i, r);                  // all random
    if (kind == 3) cloth.set_point(id, i, x + Real(0.1) * r);  // rough
    if (kind == 4 && i % 15 > 7) cloth.set_point(id, i, cloth.point(id, i - 2 * (i % 15 - 7)) + Real(0.02) * r);
  }
  const std::size_t expected = counted(cloth, id);
  CAPTURE(kind, expected);
  CHECK(cloth.tangles(id) == expected);
  CHECK((kind > 1) == (expected > 0));
}

namespace {

// A sheet with its first edge put through it, beside the corner of a cell; or all of it shaken; or folded, with a
// corner of the upper layer through the lower one; or all at random.
enum class Tangle { poke, rough, layers, random };

void tangle(Cloth& cloth, ObjectId id, std::uint32_t n, Tangle how) {
  Rng rng(3);
  const Vec3 through = cloth.point(id, 3 * n + 3) + Vec3(Real(0.03), 0, Real(0.02));
  for (std::size_t i = 0; i < n * n; ++i) {
    const Vec3 r(rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1));
    if (how == Tangle::poke && i < 2) cloth.set_point(id, i, through + Vec3(0, i == 0 ? Real(-0.03) : Real(0.03), 0));
    if (how == Tangle::rough) cloth.set_point(id, i, cloth.point(id, i) + Real(0.1) * r);
    if (how == Tangle::random) cloth.set_point(id, i, r);
    const Real cell = 1 / Real(n - 1), row = Real(i / n) * cell;
    if (how == Tangle::layers && i % n > n / 2) {
      const std::size_t k = i % n - n / 2 - 1;
      const Real far = Real(2 * k) * cell;
      const Vec3 beside(Real(0.2) * cell, cell - Real(1.7) * cell * far * (1 - row), Real(0.3) * cell);
      cloth.set_point(id, i, cloth.point(id, i - 2 * k - 1) + beside);
    }
  }
}

}  // namespace

TEST_CASE("crossings come apart without kinetic energy, and their number only falls", "[cloth]") {
  const auto how = GENERATE(Tangle::poke, Tangle::rough, Tangle::layers);
  const Real other = Real(1e-5) * Real(GENERATE(range(0, 6)));  // m/s: which way out is found hangs on rounding
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  w.set_gravity(Vec3::Zero());
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(sheet(15, 15, 1, 1));
  tangle(cloth, id, 15, how);
  for (std::size_t i = 0; i < 225; ++i) cloth.set_velocity(id, i, Vec3(1 + other, 0, 0));
  // Without gravity the sheet gains no energy but what moves give it: kinetic energy up to 1 % of what it had, at 1
  // m/s. The way out of a fold may stretch it first, by up to a quarter of the energy of the fold.
  const double kinetic = w.energy().kinetic, had = kinetic + w.energy().elastic;
  // what a step gains, and as much of it as is kinetic
  double gained = 0, gained_kinetic = 0, moves = kinetic, energy = had;
  const auto step = [&] {
    w.step();
    const double next_moves = w.energy().kinetic, next = next_moves + w.energy().elastic;
    gained += std::max(0.0, next - energy);
    gained_kinetic += std::max(0.0, std::min(next - energy, next_moves - moves));
    energy = next, moves = next_moves;
  };
  std::size_t last = cloth.tangles(id);
  REQUIRE(last > 0);
  int rises = 0, k = 0;
  for (; k < 240 && last > 0; ++k) {
    step();
    const std::size_t now = cloth.tangles(id);
    rises += now > last;
    last = now;
  }
  CAPTURE(int(how), k, last, kinetic, had, gained, gained_kinetic);
  CHECK(rises == 0);
  CHECK(last == 0);
  CHECK(gained_kinetic < 0.01 * kinetic);
  CHECK(gained < (how == Tangle::layers ? 0.3 : 0.01) * had);
  for (; k < 240; ++k) w.step();
  CHECK(cloth.tangles(id) == 0);
  CHECK(double(cloth.max_strain(id)) < 0.1);
}

TEST_CASE("what crosses itself comes back through itself where that is ignored", "[cloth]") {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(7, 7, 1, 1);
  d.inside = "ignore";
  d.bend = Real(0.01);
  const ObjectId id = cloth.add_cloth(d);
  tangle(cloth, id, 7, Tangle::random);
  for (int k = 0; k < 300; ++k) w.step();
  CHECK(w.is_finite());
  CHECK(cloth.tangles(id) == 0);
  CHECK(double(cloth.max_strain(id)) < 0.05);
}

TEST_CASE("a crumpled sheet does not cross itself, whatever finds its candidates", "[cloth]") {
  const char* const self = GENERATE("swept_boxes", "hash");
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(12, 12, 1, 1);
  d.self = self;
  const ObjectId id = cloth.add_cloth(d);
  Rng rng(9);
  for (std::size_t i = 0; i < 144; ++i) {  // towards its middle
    const Vec3 x = cloth.point(id, i);
    cloth.set_velocity(id, i, Vec3(-6 * x[0], rng.uniform(-2, 2), -6 * x[2]));
  }
  std::size_t worst = 0;
  for (int k = 0; k < 40; ++k) {
    w.step();
    worst = std::max(worst, counted(cloth, id));
  }
  CAPTURE(self);
  CHECK(worst == 0);
}

TEST_CASE("a search of self-contact that is not there is named", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  ClothDesc d = sheet(4, 4, 1, 1);
  d.self = "hsah";
  CHECK_THROWS_WITH(w.need<Cloth>().add_cloth(d), Catch::Contains("hash"));
  d.self = "", d.inside = "in";
  CHECK_THROWS_WITH(w.need<Cloth>().add_cloth(d), Catch::Contains("'guard' or 'ignore'"));
}

TEST_CASE("a sheet that crosses itself goes on from a snapshot as it would have", "[cloth]") {
  const auto how = GENERATE(Tangle::poke, Tangle::layers, Tangle::random);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(11, 11, 1, 1);
  d.self = "hash";
  const ObjectId id = cloth.add_cloth(d);
  tangle(cloth, id, 11, how);
  const int wait = GENERATE(0, 8);
  for (int k = 0; k < wait; ++k) w.step();
  CAPTURE(int(how), wait, cloth.tangles(id));
  const std::string image = w.snapshot();
  for (int k = 0; k < 10; ++k) w.step();
  const std::uint64_t hash = w.hash();
  w.restore(image);
  for (int k = 0; k < 10; ++k) w.step();
  CHECK(w.hash() == hash);
}

TEST_CASE("a vertex put 100 lengths away comes back", "[cloth]") {
  const std::size_t i = GENERATE(0, 112, 200, 224);
  const bool hung = GENERATE(false, true);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(15, 15, 1, 1);
  if (hung) d.pin_names = {"top_left", "top_right"};
  const ObjectId id = cloth.add_cloth(d);
  const Real from = hung && i == 0 ? Real(0) : Real(100);  // a pin stays
  cloth.set_point(id, i, cloth.point(id, i) + from * Vec3(1, 1, 1));
  int warned = 0;
  for (int k = 0; k < 180; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "overstretched") {
        ++warned;
        const std::string text = w.events().warning_message(e);
        CHECK(text.find("vertex " + std::to_string(i + 1) + " was put") != std::string::npos);
      }
  }
  CAPTURE(i, hung);
  CHECK(warned == (from > 0));
  CHECK(cloth.tangles(id) == 0);
  CHECK(double(cloth.max_strain(id)) < 0.05);
}

TEST_CASE("pins that are carried far away in one step pull no vertex along by hand", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(9, 9, 1, 1);
  d.pin_names = {"top"};
  const ObjectId id = cloth.add_cloth(d);
  for (std::size_t i = 0; i < 81; ++i)
    if (cloth.pinned(id, i)) cloth.set_point(id, i, cloth.point(id, i) + Vec3(0, 3, 0));
  w.step();
  for (const Event& e : w.events().list())
    CHECK_FALSE((e.kind == EventKind::warning && w.events().warning_code(e) == "overstretched"));
}

TEST_CASE("layers that lie exactly in one place are named, rows of vertices that they share are not", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(5, 5, 1, 1);
  d.name = "lower";
  cloth.add_cloth(d);
  d.name = "upper";
  const bool sewn = GENERATE(false, true);
  if (sewn) d.pose.position = d.pose.position + Vec3(1, 0, 0);  // along its edge
  cloth.add_cloth(d);
  std::string text;
  for (int k = 0; k < 3; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "coincident")
        text += std::string(w.events().warning_message(e)) + "\n";
  }
  CAPTURE(text);
  CHECK((text.find("cloth \"lower\": 32 triangles lie exactly in cloth \"upper\"") != std::string::npos) == !sewn);
  CHECK(std::count(text.begin(), text.end(), '\n') == (sewn ? 0 : 1));  // one code, one warning a step
}

TEST_CASE("crossings that stay are reported once, and rest", "[cloth]") {
  const auto how = Tangle::layers;
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(7, 7, 1, 1);
  for (std::uint32_t i = 0; i < 49; ++i) d.pins.push_back(i);  // nothing can move
  const ObjectId id = cloth.add_cloth(d);
  tangle(cloth, id, 7, how);
  std::string text;
  int warned = 0;
  for (int k = 0; k < 1000; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "tangled")
        ++warned, text = w.events().warning_message(e);
  }
  CAPTURE(text);
  CHECK(warned == 1);
  CHECK(text.find("set_point") != std::string::npos);
}
