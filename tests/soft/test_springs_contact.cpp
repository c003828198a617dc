// Soft bodies and nets with faces.
#include "contact/nets.h"
#include "soft_contact.h"

namespace feder::test {
namespace {

void add_faces(Soup& s, const Springs& springs, ObjectId net, std::span<const std::uint32_t> faces) {
  std::vector<Vec3> x;
  springs.positions(net, x);
  add_skin(s, x, faces);
}

}  // namespace

TEST_CASE("a soft block that falls onto a hanging net stays on it and passes it nowhere", "[soft]") {
  World w(WorldDesc{}, catalog());
  Springs& springs = w.need<Springs>();
  NetDesc n = grid_net(9, 1, Vec3(0, 1, 0), 200);
  n.damping = 4;
  const ObjectId net = springs.add_net(n);
  for (const std::size_t i : {0, 8, 72, 80}) springs.pin(net, i);
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.4), Real(0.2), Real(0.3)), 4);
  d.density = 50;
  d.pose.position = vec3(Real(0.02), Real(1.16), Real(-0.01));
  const ObjectId id = soft.add_soft(d);
  run_without_crossing(w, 6, [&](Soup& s) { add_faces(s, springs, net, n.faces); });
  CHECK(number(center_of(soft, id)[1]) > 0.3);
}

TEST_CASE("a soft block that flies into a net in free space keeps momentum", "[soft]") {
  World w(free_space(), catalog());
  Springs& springs = w.need<Springs>();
  const NetDesc n = grid_net(9, 1, Vec3(0, 0, 0), 300);
  const ObjectId net = springs.add_net(n);
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.2), Real(0.3)), 4);
  d.density = 100;
  d.pose.position = vec3(Real(0.1), Real(0.3), Real(0.05));
  d.velocity = Vec3(0, -3, 1);
  const ObjectId id = soft.add_soft(d);
  const Momentum before = w.momentum();
  run_without_crossing(w, 0.5, [&](Soup& s) { add_faces(s, springs, net, n.faces); });
  check_momentum(before, w.momentum(), 3 * mass_of(soft, id));
  CHECK(number(soft.velocity(id, 0)[1]) > -2.9);
}

}  // namespace feder::test
