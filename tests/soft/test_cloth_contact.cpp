// Soft bodies and cloth.
#include "soft_contact.h"

namespace feder::test {
namespace {

ClothDesc sheet_at(const Vec3& center, std::uint32_t n) {
  ClothDesc d;
  d.nx = d.ny = n;
  d.pose.position = center;
  return d;
}

}  // namespace

TEST_CASE("a soft block that falls onto a hanging cloth stays on it and passes it nowhere", "[soft]") {
  World w(WorldDesc{}, catalog());
  Cloth& cloth = w.need<Cloth>();
  ClothDesc c = sheet_at(Vec3(0, 1, 0), 17);
  c.pin_names = {"top_left", "top_right", "bottom_left", "bottom_right"};
  const ObjectId sheet = cloth.add_cloth(c);
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.15), Real(0.2)), 6);
  d.density = 100;
  d.pose.position = vec3(Real(0.02), Real(1.15), Real(-0.01));
  const ObjectId id = soft.add_soft(d);
  run_without_crossing(w, 6, [&](Soup& s) { s.add(cloth, sheet); });
  CHECK(number(center_of(soft, id)[1]) > 0.4);
}

TEST_CASE("a cloth over a soft block lies still and passes it nowhere", "[soft]") {
  World w(WorldDesc{}, catalog());
  add_ground(w);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId sheet = cloth.add_cloth(sheet_at(vec3(Real(0.03), Real(0.5), Real(0.02)), 17));
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.3), Real(0.3)), 6);
  d.pose.position = vec3(0, Real(0.17), 0);
  const ObjectId id = soft.add_soft(d);
  run_without_crossing(w, 5, [&](Soup& s) { s.add(cloth, sheet); });
  double highest = 0, mass = 0;
  for (std::size_t i = 0; i < cloth.vertex_count(sheet); ++i) {
    highest = std::max(highest, number(cloth.point(sheet, i)[1]));
    mass += number(cloth.point_mass(sheet, i));
  }
  CHECK(highest > 0.28);
  CHECK(number(soft.max_strain(id)) < 0.1);
  CHECK(w.energy().kinetic < 0.5 * (mass + mass_of(soft, id)) * 0.02 * 0.02);
}

TEST_CASE("a soft block that flies into a cloth in free space keeps momentum", "[soft]") {
  World w(free_space(), catalog());
  Cloth& cloth = w.need<Cloth>();
  const ObjectId sheet = cloth.add_cloth(sheet_at(Vec3(0, 0, 0), 17));
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 4);
  d.density = 200;
  d.pose.position = vec3(Real(0.1), Real(0.3), Real(0.05));
  d.velocity = Vec3(0, -3, 1);
  const ObjectId id = soft.add_soft(d);
  const Momentum before = w.momentum();
  run_without_crossing(w, 0.5, [&](Soup& s) { s.add(cloth, sheet); });
  check_momentum(before, w.momentum(), 3 * mass_of(soft, id));
  CHECK(number(center_of(soft, id)[1]) > -1.2);
  CHECK(number(soft.velocity(id, 0)[1]) > -2.9);
}

}  // namespace feder::test
