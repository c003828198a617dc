// Contacts: filters, mixing, recycling, waking, sleeping pairs, margins, warm start, exclusions, allocation.
#include <utility>

#include "broad/broad_phase.h"
#include "collide/fake_owner.h"
#include "narrow/narrow_phase.h"
#include "support/catch.h"

using namespace feder;

namespace {

const Contact& only_contact(FakeWorld& w) {
  const Contacts& contacts = w.collide->contacts();
  REQUIRE(contacts.order.size() + contacts.resting.count == 1);
  for (const Contact& contact : contacts.slots)
    if (contact.collider_a != kNone) return contact;
  throw std::logic_error("no slot is in use");
}

std::uint32_t ground(FakeWorld& w) { return w.add(make_plane(Vec3(0, 1, 0), 0), Vec3::Zero(), ColliderMotion::fixed); }

}  // namespace

TEST_CASE("a box on a plane has four points, arms and an active contact", "[collide]") {
  FakeWorld w;
  ground(w);
  const std::uint32_t b = w.add(make_box(1, 1, 1), Vec3(2, Real(0.499), 0));
  w.step();
  const Contact& contact = only_contact(w);
  CHECK(contact.point_count == 4);
  CHECK(contact.touching);
  CHECK(contact.fresh);
  CHECK(contact.normal[1] == Approx(1));  // from the plane (a) to the box (b)
  CHECK(w.collide->contacts().active.size() == 1);
  for (int k = 0; k < 4; ++k) {
    CHECK(contact.points[k].separation == Approx(-0.001).margin(1e-6));
    CHECK(contact.points[k].arm_b[1] == Approx(-0.4995).margin(1e-5));
  }
  CHECK(w.collide->max_penetration() == Approx(0.001).margin(1e-6));
  // above the margin, and boxes apart: no slot, nothing to solve
  for (const Real y : {Real(0.53), Real(2)}) {
    w.bodies[b].pose.position[1] = y;
    w.step();
    CHECK(w.collide->contacts().order.empty());
    CHECK(w.collide->contacts().active.empty());
    CHECK(w.collide->contacts().free_list.size() == 1);
  }
  // and back, in the same slot
  w.bodies[b].pose.position[1] = Real(0.499);
  w.step();
  CHECK(only_contact(w).point_count == 4);
  CHECK(w.collide->contacts().slots.size() == 1);
}

TEST_CASE("slots of new contacts do not depend on the number of threads", "[collide][threads]") {
  const auto slots = [](int threads) {
    FakeWorld w(threads);
    ground(w);
    for (int i = 0; i < 600; ++i)
      w.add(make_box(1, 1, 1), Vec3(Real(i % 30) * Real(1.01), Real(0.499) + Real(i / 30) * Real(0.999), 0));
    std::vector<std::uint32_t> out;
    for (int step = 0; step < 12; ++step) {  // some leave, others come
      for (std::uint32_t b = 1; b < w.bodies.size(); ++b)
        w.bodies[b].pose.position[0] += Real(0.02) * Real((b * 7 + std::uint32_t(step)) % 5) - Real(0.04);
      w.step();
      for (const Contact& k : w.collide->contacts().slots) out.push_back(k.collider_a), out.push_back(k.collider_b);
    }
    return out;
  };
  const std::vector<std::uint32_t> one = slots(1);
  CHECK(one.size() > 10'000);
  for (const int threads : {2, 4}) CHECK(slots(threads) == one);
}

TEST_CASE("margins shrink with tiny shapes", "[collide]") {
  FakeWorld w;
  ground(w);
  const Real r = Real(0.01);  // margin 1 mm
  const std::uint32_t b = w.add(make_sphere(r), Vec3(0, r + Real(0.0008), 0));
  w.step();
  CHECK(only_contact(w).point_count == 1);
  w.bodies[b].pose.position[1] = r + Real(0.0015);
  w.step();
  CHECK(w.collide->contacts().order.empty());
}

TEST_CASE("recycled contacts follow the motion as real tests do", "[collide][recycling]") {
  FakeWorld w;
  const std::uint32_t floor = w.add(make_box(4, 1, 4), Vec3(0, Real(-0.5), 0), ColliderMotion::fixed);
  const std::uint32_t b = w.add(make_box(1, 1, 1), Vec3(0, Real(0.5), 0));
  (void)floor;
  w.step();
  REQUIRE(only_contact(w).fresh);
  Rng rng(5);
  int recycled = 0, tested = 0;
  for (int i = 0; i < 400; ++i) {
    // wanders about its place, now and then far enough for a real test
    const Real s = i % 20 == 19 ? Real(0.02) : Real(0.0003);
    w.bodies[b].pose.position = Vec3(0, Real(0.5), 0) + random_point(rng, s);
    w.bodies[b].pose.rotation = integrate_rotation(Quat{}, random_point(rng, s));
    w.step();
    const Contact& contact = only_contact(w);
    (contact.fresh ? tested : recycled)++;
    if (contact.fresh) continue;
    PairCache cache;
    Manifold real[kMaxManifolds];
    Colliders& c = w.c();
    const int n = w.collide->narrow().collide(*c.shape[0], c.pose[0], *c.shape[1], c.pose[1], Real(0.02), cache, real);
    REQUIRE(n == 1);
    REQUIRE(dot(real[0].normal, contact.normal) > Real(0.9999));
    Real deepest = 1, real_deepest = 1;
    for (int k = 0; k < contact.point_count; ++k) deepest = std::min(deepest, contact.points[k].separation);
    for (int k = 0; k < real[0].count; ++k) real_deepest = std::min(real_deepest, real[0].points[k].separation);
    // second order in the angle (5e-4 rad at 0.9 m), and anchors that slid by up to 2.5 mm
    REQUIRE(std::abs(deepest - real_deepest) < Real(1e-5));
  }
  CHECK(recycled > 300);
  CHECK(tested > 10);
}

TEST_CASE("recycling does not accumulate: a slow drift is tested again", "[collide][recycling]") {
  FakeWorld w;
  ground(w);
  const std::uint32_t b = w.add(make_box(1, 1, 1), Vec3(0, Real(0.499), 0));
  int tested = 0;
  for (int i = 0; i < 100; ++i) {
    w.bodies[b].pose.position[0] += Real(0.0005);
    w.step();
    tested += only_contact(w).fresh;
    // an anchor is never farther from its place than the threshold
    for (int k = 0; k < 4; ++k) CHECK(std::abs(std::abs(only_contact(w).points[k].arm_b[0]) - Real(0.5)) < Real(1e-5));
  }
  CHECK(tested >= 15);  // 50 mm in steps of at most 2.5 mm, and the step that finds it too far
  CHECK(tested <= 30);
}

TEST_CASE("a pair that turns together is tested again", "[collide][recycling]") {
  FakeWorld w;
  w.add(make_box(1, 1, 1), Vec3::Zero());
  w.add(make_box(1, 1, 1), Vec3(0, Real(0.999), 0));
  for (int i = 0; i < 50; ++i) {
    const Quat turn = from_axis_angle(Vec3(0, 0, 1), Real(0.004) * Real(i));
    w.bodies[0].pose.rotation = turn;
    w.bodies[1].pose = {rotate(turn, Vec3(0, Real(0.999), 0)), turn};
    w.step();
    const Vec3 up = rotate(turn, Vec3(0, 1, 0));
    CHECK(dot(only_contact(w).normal, up) > Real(0.9999));
    CHECK(w.collide->max_penetration() == Approx(0.001).margin(2e-4));
  }
}

TEST_CASE("impulses stay with their points when the manifold is made anew", "[collide]") {
  FakeWorld w;
  ground(w);
  const std::uint32_t b = w.add(make_box(1, 1, 1), Vec3(0, Real(0.499), 0));
  w.pressing = false;
  w.step();
  Contact& contact = w.collide->contacts().slots[0];
  // by corner, named by its impulse
  const auto mark = [](const Vec3& arm) { return arm[0] * 2 + arm[2] + 10; };
  for (ContactPoint& p : contact.points) p.normal_impulse = mark(p.arm_b);
  Vec3 t1, t2;
  tangent_frame(contact.normal, t1, t2);
  contact.tangent_impulse[0] = 3, contact.tangent_impulse[1] = -2;
  const Vec3 friction = t1 * Real(3) - t2 * Real(2);
  w.bodies[b].pose.position[0] += Real(0.01);
  w.step();
  REQUIRE(contact.fresh);
  for (const ContactPoint& p : contact.points) CHECK(p.normal_impulse == Approx(mark(p.arm_b)).margin(1e-4));
  CHECK(contact.point_count == 4);
  tangent_frame(contact.normal, t1, t2);
  CHECK(length(t1 * contact.tangent_impulse[0] + t2 * contact.tangent_impulse[1] - friction) < Real(1e-5));
}

TEST_CASE("mixing of friction, restitution, rolling and belts", "[collide]") {
  FakeWorld w;
  const std::uint32_t g = ground(w), b = w.add(make_box(1, 1, 1), Vec3(0, Real(0.499), 0));
  Colliders& c = w.c();
  const std::uint32_t kg = w.bodies[g].colliders[0], kb = w.bodies[b].colliders[0];
  c.friction_static[kg] = Real(0.9), c.friction_static[kb] = Real(0.4);
  c.friction_dynamic[kg] = Real(0.25), c.friction_dynamic[kb] = 1;
  c.restitution[kg] = Real(0.1), c.restitution[kb] = Real(0.7);
  c.rolling_friction[kg] = Real(0.01), c.rolling_friction[kb] = Real(0.02);
  w.step();
  CHECK(only_contact(w).friction_static == Approx(0.6));
  CHECK(only_contact(w).friction_dynamic == Approx(0.5));
  CHECK(only_contact(w).restitution == Approx(0.7));
  CHECK(only_contact(w).rolling_friction == Approx(0.02));
  // a change applies to a recycled contact, asleep or not
  for (const bool awake : {true, false}) {
    c.awake[kb] = awake;
    w.step();
    c.friction_static[kb] = awake ? Real(0.1) : Real(0.9);
    w.step();
    CHECK(only_contact(w).friction_static == Approx(awake ? 0.3 : 0.9));
  }
  c.awake[kb] = 1;
  // material pairs override what they state
  c.material[kg] = w.collide->material("ice"), c.material[kb] = w.collide->material("steel");
  CHECK(w.collide->material("ice") == c.material[kg]);
  w.collide->set_material_pair({c.material[kb], c.material[kg], Real(0.05), Real(0.03), -1});
  w.step();
  CHECK(only_contact(w).friction_static == Approx(0.05));
  CHECK(only_contact(w).friction_dynamic == Approx(0.03));
  CHECK(only_contact(w).restitution == Approx(0.7));
  w.collide->set_material_pair({c.material[kb], c.material[kg], -1, -1, Real(0.2)});
  w.step();
  CHECK(only_contact(w).friction_static == Approx(0.9));
  CHECK(only_contact(w).restitution == Approx(0.2));
  // a belt under the box carries it along; one in the box pushes it back; only the tangential part counts
  c.surface_velocity[kg] = Vec3(2, 5, 0);
  w.step();
  CHECK(length(only_contact(w).surface_velocity - Vec3(2, 0, 0)) < Real(1e-5));
  c.surface_velocity[kg] = Vec3::Zero();
  c.surface_velocity[kb] = Vec3(2, 0, 0);
  w.bodies[b].pose.rotation = from_axis_angle(Vec3(0, 1, 0), kPi / 2);  // x of the box is -z of the world
  w.step();
  CHECK(length(only_contact(w).surface_velocity - Vec3(0, 0, 2)) < Real(1e-4));
  c.surface_velocity[kb] = Vec3::Zero();
  w.step();
  CHECK(only_contact(w).surface_velocity == Vec3::Zero());
}

TEST_CASE("filters: masks, same object, two immovable ones, exclusions", "[collide]") {
  FakeWorld w;
  const std::uint32_t x = w.add(make_sphere(1), Vec3::Zero());
  const std::uint32_t y = w.add(make_sphere(1), Vec3(1, 0, 0));
  Colliders& c = w.c();
  const std::uint32_t kx = w.bodies[x].colliders[0], ky = w.bodies[y].colliders[0];
  const auto contacts = [&] {
    w.step();
    return w.collide->contacts().order.size();
  };
  CHECK(contacts() == 1);
  c.mask[kx] = 2;
  CHECK(contacts() == 0);
  CHECK(w.of(EventKind::contact_end).size() == 1);
  c.group[ky] = 2;
  CHECK(contacts() == 1);
  c.group[kx] = 4, c.mask[ky] = 1;  // one direction is not enough
  CHECK(contacts() == 0);
  c.mask[ky] = 4;
  CHECK(contacts() == 1);
  for (Array<std::uint32_t>* bits : {&c.mask, &c.group}) {  // with none at all
    const std::uint32_t before = std::exchange((*bits)[kx], 0u);
    CHECK(contacts() == 0);
    CHECK(contacts() == 0);
    (*bits)[kx] = before;
    CHECK(contacts() == 1);
  }
  const ObjectId ox = w.bodies[x].object, oy = w.bodies[y].object;
  w.collide->exclude(ox, oy);
  w.collide->exclude(oy, ox);
  CHECK(contacts() == 0);
  w.collide->include(ox, oy);
  CHECK(contacts() == 0);
  w.collide->include(ox, oy);
  CHECK(contacts() == 1);
  c.motion[kx] = ColliderMotion::kinematic, c.motion[ky] = ColliderMotion::fixed;
  CHECK(contacts() == 0);
  c.sensor[kx] = 1;
  CHECK(contacts() == 0);  // a sensor has no points
  CHECK(w.of(EventKind::sensor_enter).size() == 1);
  CHECK(w.collide->contacts().active.empty());
  c.sensor[ky] = 1;  // sensors do not see each other
  CHECK(contacts() == 0);
  CHECK(w.of(EventKind::sensor_leave).size() == 1);
  FakeWorld compound;
  compound.add({{make_sphere(1), {}}, {make_sphere(1), {Vec3(Real(0.5), 0, 0), {}}}}, {});
  compound.step();
  CHECK(compound.collide->contacts().order.empty());
}

TEST_CASE("what sleeps keeps its contacts and wakes when touched", "[collide][sleep]") {
  FakeWorld w;
  ground(w);
  const std::uint32_t low = w.add(make_box(1, 1, 1), Vec3(0, Real(0.499), 0));
  w.add(make_box(1, 1, 1), Vec3(0, Real(1.497), 0));
  w.step();
  CHECK(w.of(EventKind::contact_begin).size() == 2);
  for (std::uint32_t k = 0; k < w.c().size(); ++k) w.c().awake[k] = 0;
  for (int i = 0; i < 5; ++i) {
    w.step();
    CHECK(w.collide->contacts().resting.count == (i == 0 ? 0 : 2));  // the first step still looks at them
    CHECK(w.collide->contacts().order.size() == (i == 0 ? 2 : 0));
    CHECK(w.collide->contacts().active.empty());
    CHECK(w.events.list().empty());
  }
  // hovers beside the sleepers: contact within the margin, nobody wakes
  const std::uint32_t ball = w.add(make_sphere(Real(0.5)), Vec3(Real(1.01), Real(0.6), 0));
  w.step();
  CHECK(w.wakes.empty());
  // comes closer than a touch within the step: the sleeper wakes and the contacts of both are solved at once
  w.bodies[ball].velocity = Vec3(-1, 0, 0);
  w.step();
  REQUIRE(w.wakes.size() == 1);
  CHECK(w.wakes[0].first == w.bodies[low].colliders[0]);
  CHECK(w.wakes[0].second == w.bodies[ball].colliders[0]);
  CHECK(w.collide->contacts().active.size() == 3);
  w.step();
  CHECK(w.wakes.size() == 1);
}

TEST_CASE("sensors see sleeping and fixed bodies, once per object", "[collide][sensor]") {
  FakeWorld w;
  const std::uint32_t zone = w.add(make_box(4, 4, 4), Vec3::Zero(), ColliderMotion::fixed);
  w.each(zone, [&](std::uint32_t k) { w.c().sensor[k] = 1; });
  const std::uint32_t sleeper =
      w.add({{make_sphere(Real(0.3)), {}}, {make_sphere(Real(0.3)), {Vec3(1, 0, 0), {}}}}, {});
  w.each(sleeper, [&](std::uint32_t k) { w.c().awake[k] = 0; });
  const std::uint32_t wall = w.add(make_box(1, 1, 1), Vec3(0, 2, 0), ColliderMotion::fixed);
  w.step();
  const auto entered = w.of(EventKind::sensor_enter);
  REQUIRE(entered.size() == 2);
  for (const Event& e : entered) CHECK(e.a == w.bodies[zone].object);
  CHECK(w.of(EventKind::contact_begin).empty());
  w.step();
  CHECK(w.events.list().empty());
  // one part leaves, then the other
  w.each(sleeper, [&](std::uint32_t k) { w.c().awake[k] = 1; });
  w.bodies[sleeper].pose.position[0] = Real(1.5);
  w.step();
  CHECK(w.events.list().empty());
  w.bodies[sleeper].pose.position[0] = Real(2.5);
  w.step();
  REQUIRE(w.of(EventKind::sensor_leave).size() == 1);
  CHECK(w.of(EventKind::sensor_leave)[0].b == w.bodies[sleeper].object);
  const ObjectId gone = w.bodies[wall].object;
  w.remove(wall);
  w.step();
  REQUIRE(w.of(EventKind::sensor_leave).size() == 1);
  CHECK(w.of(EventKind::sensor_leave)[0].b == gone);
}

TEST_CASE("a sensor of what moves leaves fixed bodies out", "[collide][sensor]") {
  FakeWorld w;
  const std::uint32_t zone = w.add(make_box(4, 4, 4), Vec3::Zero(), ColliderMotion::fixed);
  w.each(zone, [&](std::uint32_t k) { w.c().sensor[k] = kSensesMoving; });
  const std::uint32_t wall = w.add(make_box(1, 1, 1), Vec3(0, 2, 0), ColliderMotion::fixed);
  w.add(make_box(1, 1, 1), Vec3(0, -2, 0), ColliderMotion::kinematic);
  w.add(make_sphere(1), Vec3::Zero());
  w.step();
  CHECK(w.of(EventKind::sensor_enter).size() == 2);
  const auto becomes = [&](std::uint32_t body, ColliderMotion motion) {
    w.changed(body);
    w.each(body, [&](std::uint32_t k) { w.c().motion[k] = motion; });
    w.step();
  };
  becomes(wall, ColliderMotion::kinematic);
  REQUIRE(w.of(EventKind::sensor_enter).size() == 1);
  CHECK(w.of(EventKind::sensor_enter)[0].b == w.bodies[wall].object);
  becomes(wall, ColliderMotion::fixed);
  CHECK(w.of(EventKind::sensor_leave).size() == 1);
  w.changed(zone);
  w.each(zone, [&](std::uint32_t k) { w.c().sensor[k] = kSensesAll; });
  w.step();
  CHECK(w.of(EventKind::sensor_enter).size() == 1);
}

TEST_CASE("a compound on a floor begins once, hits once, and ends with its name", "[collide][events]") {
  FakeWorld w;
  ground(w);
  const std::uint32_t b = w.add({{make_sphere(Real(0.5)), {}}, {make_sphere(Real(0.5)), {Vec3(2, 0, 0), {}}}},
                                {Vec3(0, Real(0.51), 0), {}});
  w.bodies[b].velocity = Vec3(0, -3, 0);
  w.step();
  CHECK(w.events.list().empty());  // within the margin, not touching, no impulse
  w.bodies[b].pose.position[1] = Real(0.49);
  w.step();
  REQUIRE(w.of(EventKind::contact_begin).size() == 1);
  REQUIRE(w.of(EventKind::hit).size() == 1);
  CHECK(w.of(EventKind::hit)[0].speed == Approx(3));
  CHECK(w.of(EventKind::hit)[0].impulse == Approx(0.02).margin(1e-5));  // two points of the fake solver
  CHECK(w.of(EventKind::contact_begin)[0].normal[1] == Approx(1));
  w.bodies[b].velocity = Vec3(Real(0.5), 0, 0);
  w.step();
  REQUIRE(w.of(EventKind::contact_stay).size() == 1);
  CHECK(w.of(EventKind::contact_stay)[0].impulse == Approx(0.02).margin(1e-5));
  CHECK(w.of(EventKind::contact_stay)[0].slip == Approx(0.5));
  std::vector<Collide::ContactInfo> info;
  w.collide->contacts_of(w.bodies[b].object, info);
  REQUIRE(info.size() == 2);
  CHECK(info[0].normal[1] == Approx(-1));  // away from the body
  CHECK(info[0].other == w.bodies[0].object);
  // rest within the two thresholds does not flicker
  for (int i = 0; i < 20; ++i) {
    w.bodies[b].pose.position[1] = Real(i % 2 ? 0.4999 : 0.5012);
    w.step();
    CHECK(w.of(EventKind::contact_begin).empty());
    CHECK(w.of(EventKind::contact_end).empty());
  }
  const ObjectId name = w.bodies[b].object;
  w.remove(b);
  w.step();
  REQUIRE(w.of(EventKind::contact_end).size() == 1);
  CHECK(w.of(EventKind::contact_end)[0].b == name);
  w.step();
  CHECK(w.events.list().empty());
}

TEST_CASE("points of a net are one contact with a body, which tells the first", "[collide][events]") {
  FakeWorld w;
  ground(w);
  const std::uint32_t net = w.add({{make_sphere(Real(0.1)), {}}, {make_sphere(Real(0.1)), {Vec3(1, 0, 0), {}}}},
                                  {Vec3(0, Real(0.09), 0), {}});
  std::uint32_t sub = 6;
  w.each(net, [&](std::uint32_t k) { w.c().owner[k] = ColliderOwner::point, w.c().sub[k] = ++sub; });
  w.step();
  const auto begun = w.of(EventKind::contact_begin);
  REQUIRE(begun.size() == 1);
  CHECK(begun[0].index == 7);
}

TEST_CASE("unknown choices name the known ones", "[collide]") {
  REQUIRE_THROWS_AS(FakeWorld(1, "oct_tree"), SceneError);
  try {
    FakeWorld w(1, "oct_tree");
  } catch (const SceneError& e) {
    for (const auto& row : broad_phases()) CHECK(std::string(e.what()).find(row.name) != std::string::npos);
  }
}

TEST_CASE("a step allocates nothing after warm-up", "[collide]") {
  FakeWorld w;
  ground(w);
  for (int i = 0; i < 30; ++i)
    w.add(make_box(1, 1, 1), Vec3(Real(i % 6) * Real(0.99), Real(0.499) + Real(i / 6) * Real(0.99), 0));
  const auto allocations = [&] {
    std::uint64_t sum = 0;
    for (const auto& arena : w.store.arenas()) sum += arena->allocations();
    return sum;
  };
  Rng rng(9);
  std::uint64_t before = 0;
  for (int i = 0; i < 200; ++i) {
    if (i == 100) before = allocations();
    for (std::uint32_t b = 1; b < w.bodies.size(); ++b) {
      const Vec3 home(Real((b - 1) % 6) * Real(0.99), Real(0.499) + Real((b - 1) / 6) * Real(0.99), 0);
      w.bodies[b].pose.position = home + random_point(rng, i % 3 ? Real(0.001) : Real(0.02));
    }
    w.step();
  }
  CHECK(allocations() == before);
}

// As when a body is quarantined at the end of a step.
TEST_CASE("a collider forgotten after the narrow phase does not hide what waits for the solve", "[collide][events]") {
  FakeWorld w;
  const std::uint32_t floor = ground(w);
  const std::uint32_t gone = w.add(make_sphere(Real(0.5)), Vec3(-3, Real(0.499), 0));
  const std::uint32_t near = w.add(make_sphere(Real(0.5)), Vec3(3, Real(0.51), 0));  // touches if it takes an impulse
  w.meanwhile = [&] {
    for (const std::uint32_t k : w.bodies[gone].colliders) w.collide->forget(k);
    Contacts& contacts = w.collide->contacts();
    for (const std::uint32_t slot : contacts.order) contacts.slots[slot].points[0].total_impulse = 1;
  };
  w.step();
  const std::vector<Event> begun = w.of(EventKind::contact_begin);
  REQUIRE(begun.size() == 1);
  CHECK(begun[0].a == w.bodies[floor].object);
  CHECK(begun[0].b == w.bodies[near].object);
}
