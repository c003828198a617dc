// Picking, dragging, throwing, pinning and shooting without a window.
#include "feder/net.h"
#include "feder/rigid.h"
#include "live.h"
#include "state/bodies.h"

using namespace feder;
using view::LiveScene;

namespace {

view::Ray ray_to(const Vec3& from, const Vec3& at) { return {from, normalized_or(at - from, Vec3(0, 0, -1))}; }

Vec3 position(LiveScene& live, const char* name) {
  return live.world().find<Rigid>()->pose(live.world().objects().find(name)).position;
}

struct Busy {
  test::SceneFolder folder;
  LiveScene live{test::live_options()};
  Busy() { REQUIRE(live.open(folder.write("busy.lua", test::kBusyScene))); }
};

}  // namespace

TEST_CASE("a ray picks the first thing, and a net point near it", "[view][picking]") {
  Busy b;
  World& w = b.live.world();
  const std::uint64_t hash = w.hash();
  auto crate = view::pick(w, ray_to(Vec3(0, Real(1.2), 10), Vec3(0, Real(1.2), 0)), Real(0.01));
  REQUIRE(crate);
  CHECK(w.objects().name(crate->object) == "crate1");
  CHECK(crate->movable);
  CHECK(crate->depth == Approx(9.5));
  auto ground = view::pick(w, ray_to(Vec3(20, 5, 10), Vec3(20, 0, 0)), Real(0.01));
  REQUIRE(ground);
  CHECK_FALSE(ground->movable);
  auto point = view::pick(w, ray_to(Vec3(4, 3, 10), Vec3(4, Real(3.05), 0)), Real(0.01));
  REQUIRE(point);
  CHECK(point->point == 2);
  CHECK_FALSE(view::pick(w, ray_to(Vec3(4, 3, 10), Vec3(4, 9, 0)), Real(0.01)));
  CHECK(w.hash() == hash);
}

TEST_CASE("a held body follows the mouse and keeps its speed when let go", "[view][picking]") {
  Busy b;
  test::run_to(b.live, 30);
  const auto pick = view::pick(b.live.world(), ray_to(Vec3(0, 3, 10), position(b.live, "crate3")), Real(0.01));
  REQUIRE(pick);
  REQUIRE(b.live.world().objects().name(pick->object) == "crate3");
  b.live.hold(view::grip(b.live.world(), *pick));
  const Vec3 target(2, 6, 1);
  for (int i = 1; i <= 120; ++i) {
    b.live.move_hold(target);
    test::run_to(b.live, 30 + static_cast<std::uint64_t>(i));
  }
  CHECK(length(view::grip_position(b.live.world(), *b.live.held()) - target) < Real(0.05));
  // a fast move throws
  for (int i = 1; i <= 10; ++i) {
    b.live.move_hold(target + Vec3(Real(0.3) * Real(i), 0, 0));
    test::run_to(b.live, 150 + static_cast<std::uint64_t>(i));
  }
  b.live.let_go(false);
  CHECK(b.live.world().find<Rigid>()->bodies().velocity[b.live.world().find<Rigid>()->index(pick->object)][0] > 3);
  CHECK_FALSE(b.live.held());
  // what was done by hand is lived again
  const std::uint64_t hash = (test::run_to(b.live, 200), b.live.world().hash());
  test::run_to(b.live, 220);
  b.live.scrub(200);
  b.live.run_text("nil", {});
  while (b.live.catching_up()) b.live.tick(0, 0);
  CHECK(b.live.world().hash() == hash);
  CHECK(b.live.notice() == "");
}

TEST_CASE("a held net point follows, and is let go or pinned", "[view][picking]") {
  const bool pin = GENERATE(false, true);
  Busy b;
  test::run_to(b.live, 10);
  Springs& springs = *b.live.world().find<Springs>();
  const ObjectId rope = b.live.world().objects().find("rope");
  const auto pick = view::pick(b.live.world(), ray_to(Vec3(4, 3, 10), springs.point(rope, 2)), Real(0.01));
  REQUIRE(pick);
  REQUIRE(pick->point == 2);
  b.live.hold(view::grip(b.live.world(), *pick));
  b.live.move_hold(Vec3(5, 4, 0));
  test::run_to(b.live, 60);
  CHECK(length(springs.point(rope, 2) - Vec3(5, 4, 0)) < Real(0.02));
  b.live.let_go(pin);
  CHECK(springs.pinned(rope, 2) == pin);
  test::run_to(b.live, 120);
  CHECK((springs.point(rope, 2)[1] < 3) != pin);
}

TEST_CASE("pinning a body and shooting a ball", "[view][picking]") {
  Busy b;
  test::run_to(b.live, 5);
  const ObjectId crate = b.live.world().objects().find("crate3");
  const view::Pick pick{crate, kNone, Vec3::Zero(), 0, true};
  b.live.act(view::pin_command(b.live.world(), pick), "pin");
  CHECK(view::is_pinned(b.live.world(), pick));
  const Vec3 before = position(b.live, "crate3");
  test::run_to(b.live, 60);
  CHECK(position(b.live, "crate3") == before);
  b.live.act(view::pin_command(b.live.world(), pick), "free");
  b.live.run_text(view::shot_text(b.live.world(), ray_to(Vec3(0, 3, 10), before), Real(0.2), 20, 1), {});
  REQUIRE(b.live.world().objects().find("shot1"));
  test::run_to(b.live, 100);
  CHECK(b.live.world().is_finite());
  CHECK(position(b.live, "crate3")[2] < before[2] - Real(0.1));
}
