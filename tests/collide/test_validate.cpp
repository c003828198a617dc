// Collide::validate against seeded faults: each must be found.
#include "collide/fake_owner.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;

namespace {

bool found(const std::string& text) { return text.find("/validate.cpp:") + 1 || text.find("/state/") + 1; }

// Two spheres on a plane, and one that nothing touches.
struct Resting : FakeWorld {
  Resting() {
    add(make_plane(Vec3(0, 1, 0), 0), Vec3::Zero(), ColliderMotion::fixed);
    add(make_sphere(Real(0.5)), Vec3(-3, Real(0.499), 0));
    add(make_sphere(Real(0.5)), Vec3(3, Real(0.499), 0));
    add(make_sphere(Real(0.5)), Vec3(0, 9, 0));
    step();
  }
  template <class F>
  std::string with(F&& fault) {
    return failed_assert([&] { fault(*this), collide->validate(); });
  }
};

}  // namespace

TEST_CASE("validate finds contacts that do not fit their colliders", "[collide][validate]") {
  if constexpr (!kAsserts) return;
  Resting w;
  REQUIRE(w.collide->contacts().active.size() == 2);
  CHECK(w.with([](FakeWorld&) {}).empty());
  Contacts& k = w.collide->contacts();
  CHECK(found(w.with([&](FakeWorld&) { k.slots[k.order[0]].collider_b = 3; })));
  CHECK(found(w.with([&](FakeWorld&) { k.slots[k.order[0]].touching = 0; })));
  CHECK(found(w.with([&](FakeWorld&) { std::swap(k.order[0], k.order[1]); })));
  CHECK(found(w.with([&](FakeWorld&) { k.active.push_back(k.active[0]); })));
  CHECK(found(w.with([&](FakeWorld&) { k.active[0] = k.active[1]; })));
  CHECK(found(w.with([&](FakeWorld&) { k.free_list.push_back(k.order[0]); })));
  CHECK(found(w.with([&](FakeWorld&) { k.slots.emplace_back(); })));
  CHECK(found(w.with([](FakeWorld& f) { f.c().remove(1); })));  // not forgotten: its end event is lost
  // another touches than is on record
  CHECK(found(w.with([](FakeWorld& f) { f.c().object[1] = f.c().object[3]; })));
  CHECK(found(w.with([](FakeWorld& f) { f.c().shapes[3].reset(); })));
  CHECK(found(w.with([](FakeWorld& f) { f.c().group.pop_back(); })));
}
