// Groups of cloths: what may act on each other shares its substeps, and nothing else does.
#include <functional>

#include "cloth/sheets.h"
#include "couple/cloth_and_rigid.h"
#include "feder/query.h"
#include "state/surface.h"

using namespace feder;
using namespace feder::test;

namespace {

ClothDesc hanging(Real x, std::uint32_t rows, Real stretch) {
  ClothDesc d = sheet(5, rows, 1, Real(0.25) * static_cast<Real>(rows - 1));
  d.pin_names = {"top"}, d.stretch = stretch;
  d.pose.position = Vec3(x, 0, 0);
  return d;
}

BodyDesc ball(BodyType type, const Vec3& at, Real radius) {
  BodyDesc d;
  d.type = type, d.shape = make_sphere(radius), d.position = at;
  return d;
}

double updates(World& w) {
  for (const Residual& r : w.residuals())
    if (r.name == "cloth.row_updates") return r.value;
  return 0;
}

// Work of 30 steps, in links, hinges and contacts.
double work(bool taut, int slack) {
  World w(WorldDesc{}, kClothAndRigid);
  Cloth& cloth = w.need<Cloth>();
  if (taut) cloth.add_cloth(hanging(0, 40, 20000));
  for (int k = 1; k <= slack; ++k) cloth.add_cloth(hanging(Real(3) * static_cast<Real>(k), 6, 200));
  double sum = 0;
  for (int k = 0; k < 30; ++k) w.step(), sum += updates(w);
  return sum;
}

// Positions of the first cloth after 40 steps, beside what `more` adds.
std::vector<Vec3> beside(const std::function<void(World&)>& more, int threads = 1) {
  WorldDesc wd;
  wd.threads = threads;
  World w(wd, kClothAndRigid);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId first = cloth.add_cloth(hanging(0, 12, 2000));
  BodyDesc pusher = ball(BodyType::kinematic, Vec3(0, Real(-0.4), -1), Real(0.3));
  pusher.velocity = Vec3(0, 0, 2);
  w.need<Rigid>().add_body(pusher);
  more(w);
  for (int k = 0; k < 40; ++k) w.step();
  std::vector<Vec3> x;
  cloth.positions(first, x);
  return x;
}

}  // namespace

TEST_CASE("one taut sheet beside ten slack ones costs what they cost alone", "[couple][cloth][groups]") {
  const double taut = work(true, 0), slack = work(false, 10);
  CHECK(work(true, 10) <= 1.001 * (taut + slack));
}

TEST_CASE("a cloth moves the same bits beside others that it does not meet", "[couple][cloth][groups]") {
  const std::vector<Vec3> alone = beside([](World&) {});
  const auto others = [](World& w) {
    w.need<Cloth>().add_cloth(hanging(4, 40, 20000));
    // the same moving body touches this one: it connects nothing
    w.need<Cloth>().add_cloth(hanging(Real(-1.4), 12, 3000));
  };
  const std::vector<Vec3> together = beside(others), threads = beside(others, 4);
  REQUIRE(alone.size() == together.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    CHECK(alone[i] == together[i]);
    CHECK(alone[i] == threads[i]);
  }
}

TEST_CASE("cloths are one group while they may touch, or act on one dynamic body", "[couple][cloth][groups]") {
  World w(WorldDesc{}, kClothAndRigid);
  Cloth& cloth = w.need<Cloth>();
  Rigid& rigid = w.need<Rigid>();
  cloth.add_cloth(hanging(0, 6, 200));
  cloth.add_cloth(hanging(3, 12, 20000));
  const ObjectId third = cloth.add_cloth(hanging(6, 6, 200));
  const Surfaces& shown = w.store().get<Surfaces>();
  w.step();
  CHECK(shown.group_count == 3);
  SECTION("a dynamic body that two hold") {
    const ObjectId held = rigid.add_body(ball(BodyType::dynamic, Vec3(4, Real(-0.5), 0), Real(0.1)));
    cloth.attach(cloth.info(1).object, 20, held, Vec3(-1, 0, 0));
    w.step();
    CHECK(shown.group_count == 3);
    cloth.attach(third, 20, held, Vec3(1, 0, 0));
    w.step();
    CHECK(shown.group_count == 2);
    CHECK(shown.group_of(1) == shown.group_of(2));
    CHECK(shown.group_of(0) == 0);
    rigid.destroy_body(held, "");
    w.step();
    CHECK(shown.group_count == 3);
  }
  SECTION("a floor connects nothing") {
    BodyDesc floor;
    floor.type = BodyType::fixed, floor.shape = make_box(20, 1, 20), floor.position = Vec3(0, Real(-0.52), 0);
    rigid.add_body(floor);
    for (int k = 0; k < 3; ++k) w.step();
    CHECK(shown.group_count == 3);
  }
  SECTION("one that comes near") {
    for (std::size_t i = 0; i < cloth.vertex_count(third); ++i)
      cloth.set_point(third, i, cloth.point(third, i) - Vec3(3, Real(0.02), 0));
    w.step();
    CHECK(shown.group_count == 2);
    CHECK(shown.group_of(1) == shown.group_of(2));
  }
}

TEST_CASE("the count of substeps of a group comes back with a snapshot", "[couple][cloth][groups]") {
  World w(WorldDesc{}, kClothAndRigid);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(hanging(0, 40, 20000));
  w.step();
  const int calm = cloth.substeps(id);
  for (std::size_t i = 5; i < cloth.vertex_count(id); ++i) cloth.set_velocity(id, i, Vec3(0, 0, 40));
  w.step();
  const int busy = cloth.substeps(id);
  CHECK(busy > calm);
  const std::string image = w.snapshot();
  const auto hashes = [&] {
    std::vector<std::uint64_t> list;
    for (int k = 0; k < 10; ++k) w.step(), list.push_back(w.hash());
    stop(cloth, id);
    for (int k = 0; k < 10; ++k) w.step(), list.push_back(w.hash());
    return list;
  };
  const std::vector<std::uint64_t> first = hashes();
  CHECK(cloth.substeps(id) < busy);
  w.restore(image);
  CHECK(first == hashes());
}
