// Rigid::validate and World::validate against seeded faults: each must be found.
#include <limits>

#include "feder/query.h"
#include "feder/rigid.h"
#include "feder/world.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "state/solver_bodies.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;

namespace {

const SystemDescriptor* const kCatalog[] = {&Collide::descriptor(), &Rigid::descriptor()};
bool found(const std::string& text) { return text.find("/validate.cpp:") + 1 || text.find("/state/") + 1; }
constexpr Real kNaN = std::numeric_limits<Real>::quiet_NaN();

// On a floor: two crates on each other that sleep, two on a hinge that do not.
struct Scene {
  World world{WorldDesc{}, kCatalog};
  Rigid& rigid = world.need<Rigid>();
  std::uint32_t floor, low, high, left, right;

  Scene() {
    BodyDesc d;
    d.type = BodyType::fixed, d.shape = make_plane(Vec3(0, 1, 0), 0);
    floor = rigid.index(rigid.add_body(d));
    d.type = BodyType::dynamic, d.shape = make_box(1, 1, 1);
    low = crate(d, Vec3(0, Real(0.5), 0)), high = crate(d, Vec3(0, Real(1.5), 0));
    d.can_sleep = false;
    left = crate(d, Vec3(5, Real(0.5), 0)), right = crate(d, Vec3(7, Real(0.5), 0));
    JointDesc j;
    j.type = "hinge", j.a = b().object[left], j.b = b().object[right], j.anchor_a = Vec3(6, Real(0.5), 0);
    rigid.add_joint(j);
    for (int k = 0; k < 240; ++k) world.step();
  }
  std::uint32_t crate(BodyDesc& d, const Vec3& at) {
    d.position = at;
    return rigid.index(rigid.add_body(d));
  }
  Bodies& b() { return world.store().get<Bodies>(); }
  Colliders& c() { return world.find<Collide>()->colliders(); }
  template <class F>
  std::string with(F&& fault) {
    return failed_assert([&] { fault(), rigid.validate(); });
  }
};

}  // namespace

TEST_CASE("validate finds bodies that went wrong", "[rigid][validate]") {
  if constexpr (!kAsserts) return;
  Scene s;
  REQUIRE(!s.b().awake[s.low]);
  REQUIRE(s.b().awake[s.left]);
  CHECK(s.with([] {}).empty());
  CHECK_THAT(s.with([&] { s.b().velocity[s.left][1] = kNaN; }), Catch::Contains("velocity"));
  CHECK_THAT(s.with([&] { s.b().position[s.left][1] = kNaN; }), Catch::Contains("position"));
  CHECK(found(s.with([&] { s.b().rotation[s.left].w = 2; })));
  CHECK(found(s.with([&] { s.b().velocity[s.low] = Vec3(1, 0, 0); })));  // moves in its sleep
  CHECK(found(s.with([&] { s.b().awake[s.low] = 1; })));                 // and so do not all of its island
  CHECK(found(s.with([&] { s.b().island[s.high] = s.high; })));
  CHECK(found(s.with([&] { s.b().type[s.left] = BodyType::kinematic; })));
  CHECK(found(s.with([&] { s.b().solver_slot[s.left] = 99; })));
  CHECK(found(s.with([&] { s.b().free_list.push_back(s.left); })));
  CHECK(found(s.with([&] { s.b().mass.pop_back(); })));
  CHECK(found(s.with([&] { s.b().first_collider[s.left] = s.b().first_collider[s.right]; })));
  CHECK(found(s.with([&] { s.c().next_of_body[s.b().first_collider[s.left]] = s.b().first_collider[s.left]; })));
  CHECK(found(s.with([&] { s.c().motion[s.b().first_collider[s.left]] = ColliderMotion::fixed; })));
  CHECK(found(s.with([&] { s.world.objects().set_index(s.b().object[s.left], s.right); })));
  CHECK(found(s.with([&] { s.world.objects().remove(s.b().object[s.left], ""); })));
}

// The next step finds these before it uses them.
TEST_CASE("a step finds bodies that share a solver slot", "[rigid][validate]") {
  if constexpr (!kAsserts) return;
  Scene s;
  CHECK(failed_assert([&] { s.world.step(); }).empty());
  CHECK_THAT(failed_assert([&] { s.b().solver_slot[s.left] = s.b().solver_slot[s.right], s.world.step(); }),
             Catch::Contains("rigid/rows.cpp"));
  CHECK_THAT(failed_assert([&] {
               s.world.store().get<SolverBodies>().free_list.push_back(s.b().solver_slot[s.left]);
               BodyDesc d;
               d.shape = make_box(1, 1, 1), d.position = Vec3(0, 20, 0);
               s.rigid.add_body(d);
             }),
             Catch::Contains("state/solver_bodies.h"));
}
