// Restore then run equals run, bit for bit: contacts, matching data, touch counts, what waits for the next step.
#include "collide/fake_owner.h"
#include "support/catch.h"

using namespace feder;

namespace {

// What the fake owner keeps beside the colliders.
struct Frame {
  std::string image;
  std::vector<FakeBody> bodies;
  StepContext context;
};

Frame take(FakeWorld& w) {
  Frame f;
  Writer writer(f.image);
  w.collide->save(writer);
  w.store.get<ContactBook>().save(writer);
  f.bodies = w.bodies, f.context = w.context;
  return f;
}

void restore(FakeWorld& w, const Frame& f) {
  Reader reader(f.image);
  w.collide->load(reader);
  w.store.get<ContactBook>().load(reader);
  REQUIRE(reader.at_end());
  w.bodies = f.bodies, w.context = f.context;
}

std::uint64_t run(FakeWorld& w, int steps) {
  Rng rng(4);
  Hash h;
  for (int i = 0; i < steps; ++i) {
    for (std::uint32_t b = 1; b < w.bodies.size(); ++b) {
      if (!w.awake(b)) continue;
      w.bodies[b].pose.position += random_point(rng, i % 4 == 3 ? Real(0.01) : Real(0.0004));
      w.bodies[b].pose.rotation = integrate_rotation(w.bodies[b].pose.rotation, random_point(rng, Real(0.001)));
    }
    w.step();
    for (const Event& e : w.events.list())
      h.bytes(e.kind.text(), std::string_view(e.kind.text()).size()), h.add(e.a.slot), h.add(e.b.slot), h.add(e.point),
          h.add(e.impulse);
    w.collide->hash(h);
    for (const std::uint32_t slot : w.collide->contacts().active) {
      const Contact& contact = w.collide->contacts().slots[slot];
      h.add(slot), h.add(contact.friction_static), h.add(contact.restitution), h.add(contact.fresh);
    }
  }
  return h.value();
}

}  // namespace

TEST_CASE("restore then run equals run", "[collide][snapshot]") {
  FakeWorld w;
  w.add(make_plane(Vec3(0, 1, 0), 0), Vec3::Zero(), ColliderMotion::fixed);
  for (int i = 0; i < 20; ++i)
    w.add(make_box(1, 1, 1), Vec3(Real(i % 5) * Real(1.001), Real(0.5) + Real(i / 5) * Real(0.999), 0));
  w.add(make_sphere(2), Vec3(2, 2, 0), ColliderMotion::fixed);
  w.each(21, [&](std::uint32_t k) { w.c().sensor[k] = 1; });
  w.c().material[3] = w.collide->material("rubber");
  w.collide->set_material_pair({0, w.c().material[3], Real(0.8), Real(0.7), Real(0.4)});
  w.collide->exclude(w.bodies[1].object, w.bodies[2].object);
  run(w, 30);
  w.c().awake[7] = w.c().awake[8] = 0;
  run(w, 3);
  // something waits for the next step: an end, a changed collider, an exclusion
  w.changed(4);
  w.collide->forget(9);
  w.collide->exclude(w.bodies[5].object, w.bodies[6].object);
  const Frame frame = take(w);
  CHECK(take(w).image == frame.image);
  const std::uint64_t first = run(w, 40);
  // what happens after the image leaves nothing behind
  w.c().group[6] = 3;
  w.c().awake[8] = 1;
  run(w, 5);
  restore(w, frame);
  CHECK(take(w).image == frame.image);
  CHECK(run(w, 40) == first);
}

TEST_CASE("a truncated image is refused", "[collide][snapshot]") {
  FakeWorld w;
  w.add(make_sphere(1), Vec3::Zero());
  w.add(make_sphere(1), Vec3(1, 0, 0));
  w.step();
  const Frame f = take(w);
  Reader reader(std::string_view(f.image).substr(0, f.image.size() / 2));
  CHECK_THROWS_AS(w.collide->load(reader), SceneError);
}
