// Two cloths: momentum passes both ways, none crosses the other, contacts begin and end, rows only where there are two.
#include <algorithm>
#include <cmath>

#include "cloth/crossings.h"
#include "cloth/sheets.h"
#include "contact/surface_contact.h"

using namespace feder;
using namespace feder::test;

namespace {

const SystemDescriptor* const kClothAlone[] = {&SurfaceContact::descriptor(), &Cloth::descriptor()};

bool has_pass(World& w, const std::string& name) {
  const auto nodes = w.plan().nodes();
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](const PlanNode& n) { return std::string(n.system) == "contact" && n.name == name; });
}

}  // namespace

TEST_CASE("a world of one cloth has no pass for cloth on cloth; the second brings it, and takes it away",
          "[contact][cloth]") {
  World w(WorldDesc{}, kClothAlone);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc alone = sheet(5, 5, 1, 1);
  alone.self_collision = false;
  cloth.add_cloth(alone);
  w.step();
  for (const char* pass : {"surface pairs", "near surfaces", "contacts", "non-penetration", "contact states", "coast"})
    CHECK_FALSE(has_pass(w, pass));
  ClothDesc d = sheet(5, 5, 1, 1);
  d.pose.position = Vec3(0, 1, 0);
  const ObjectId second = cloth.add_cloth(d);
  w.step();
  CHECK(has_pass(w, "surface pairs"));
  CHECK(has_pass(w, "near surfaces"));
  cloth.destroy_cloth(second, "");
  w.step();
  CHECK_FALSE(has_pass(w, "surface pairs"));
}

TEST_CASE("the end of a contact between cloths comes with the end of one of them, and after a restore",
          "[couple][cloth]") {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothAlone);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc low = sheet(9, 9, 1, 1);
  low.pin_names = {"top", "bottom", "left", "right"};
  const ObjectId a = cloth.add_cloth(low);
  ClothDesc high = sheet(7, 7, Real(0.5), Real(0.5));
  high.pose.position = Vec3(Real(0.03), Real(0.1), Real(0.02));
  const ObjectId b = cloth.add_cloth(high);
  int begins = 0, ends = 0;
  const auto run = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      w.step();
      for (const Event& e : w.events().list()) {
        if (e.kind != EventKind::contact_begin && e.kind != EventKind::contact_end) continue;
        CHECK(e.a == a);
        CHECK(e.b == b);
        ++(e.kind == EventKind::contact_begin ? begins : ends);
      }
    }
  };
  run(60);
  CHECK(begins - ends == 1);
  const std::string image = w.snapshot();
  run(30);
  const std::uint64_t hash = w.hash();
  w.restore(image);
  begins = 1, ends = 0;
  run(30);
  CHECK(w.hash() == hash);
  CHECK(begins - ends == 1);
  cloth.destroy_cloth(b, "");
  run(2);
  CHECK(begins == ends);
}

TEST_CASE("a cloth that falls on a sleeping one wakes it", "[couple][cloth]") {
  World w(WorldDesc{}, kClothAlone);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc low = sheet(9, 9, 1, 1);
  low.pin_names = {"top", "bottom", "left", "right"};
  const ObjectId a = cloth.add_cloth(low);
  ClothDesc high = sheet(7, 7, Real(0.5), Real(0.5));
  high.pose.position = Vec3(Real(0.03), Real(0.3), Real(0.02));
  const ObjectId b = cloth.add_cloth(high);
  cloth.sleep(a);
  int woken = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      woken += e.kind == EventKind::wake && e.a == a && e.b == b && e.cause == kClothCause;
  }
  CHECK(woken == 1);
}

TEST_CASE("cloth falls on cloth and stays on it", "[cloth]") {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothAlone);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc low = sheet(17, 17, 1, 1);
  low.pin_names = {"top", "bottom", "left", "right"};
  const ObjectId a = cloth.add_cloth(low);
  ClothDesc high = sheet(13, 13, Real(0.5), Real(0.5));
  high.pose.position = Vec3(Real(0.03), Real(0.4), Real(0.02));
  high.pose.rotation = from_axis_angle(Vec3(1, 2, 0), Real(0.5));
  const ObjectId b = cloth.add_cloth(high);
  std::size_t frames = 0;
  int begins = 0;
  for (int k = 0; k < 240; ++k) {
    w.step();
    Soup s;
    s.add(cloth, a), s.add(cloth, b);
    frames += count_crossings(s) > 0;
    for (const Event& e : w.events().list()) begins += e.kind == EventKind::contact_begin && e.a == a && e.b == b;
  }
  CHECK(frames == 0);
  CHECK(begins >= 1);
  for (const std::size_t i : {0u, 84u, 168u}) CHECK(cloth.point(b, i)[1] > Real(-0.25));
}

TEST_CASE("two free cloths that collide exchange momentum and keep the sum", "[cloth]") {
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.sleeping = false;
  wd.options.set("air_density", 0.0);
  World w(wd, kClothAlone);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(11, 11, 1, 1);
  d.substeps = 8;  // of itself, cloth loses angular momentum in proportion to the solver substep
  d.pose.position = Vec3(Real(0.1), Real(0.05), 0);
  d.velocity = Vec3(0, -2, Real(0.5));
  const ObjectId high = cloth.add_cloth(d);
  ClothDesc other = sheet(9, 9, Real(0.7), Real(0.7));
  other.area_density = Real(0.5);
  other.substeps = 8;
  const ObjectId low = cloth.add_cloth(other);
  const Momentum before = w.momentum();
  std::size_t frames = 0;
  int begins = 0, ends = 0;
  double lost = 0, pushed = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    double mismatch = 0;
    for (const Residual& r : w.residuals()) {
      if (r.name == "contact.impulse_mismatch") mismatch = r.value;
      if (r.name == "contact.impulse_ns") pushed += r.value, lost += mismatch * r.value;
    }
    Soup s;
    s.add(cloth, high), s.add(cloth, low);
    frames += count_crossings(s) > 0;
    for (const Event& e : w.events().list())
      begins += e.kind == EventKind::contact_begin, ends += e.kind == EventKind::contact_end;
  }
  CHECK(pushed > 0.05);
  CHECK(lost < 1e-4 * pushed);
  const Momentum after = w.momentum();
  const double p = std::hypot(before.linear[1], before.linear[2]),
               l = std::hypot(before.angular[0], before.angular[1], before.angular[2]);
  for (int k = 0; k < 3; ++k) {
    CAPTURE(k);
    CHECK(std::fabs(after.linear[k] - before.linear[k]) < 1e-4 * p);
    CHECK(std::fabs(after.angular[k] - before.angular[k]) < 0.03 * std::max(l, 0.1 * p));
  }
  CHECK(frames == 0);
  CHECK(begins >= 1);
  CHECK(begins - ends <= 1);
  double passed = 0;
  for (std::size_t i = 0; i < 81; ++i)
    passed += static_cast<double>(cloth.point_mass(low, i)) * component(cloth.velocity(low, i), 1);
  CHECK(passed < -0.05);  // of -0.4
}
