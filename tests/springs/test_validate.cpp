// Springs::validate against seeded faults: each must be found.
#include <limits>

#include "feder/net.h"
#include "feder/world.h"
#include "state/particles.h"
#include "support/aborts.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("validate finds nets that went wrong", "[springs][validate]") {
  if constexpr (!kAsserts) return;
  const SystemDescriptor* const catalog[] = {&Springs::descriptor()};
  World world(WorldDesc{}, catalog);
  Springs& springs = world.need<Springs>();
  NetDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}, d.masses = {1, 1, 1};
  d.springs = {SpringDesc{0, 1}, SpringDesc{1, 2}};
  const ObjectId net = springs.add_net(d);
  springs.add_net(d);
  springs.pin(net, 0);
  for (int k = 0; k < 10; ++k) world.step();

  Particles& p = world.store().get<Particles>();
  const auto with = [&](auto&& fault) { return failed_assert([&] { fault(), springs.validate(); }); };
  const auto finds = Catch::Contains("springs/validate.cpp");
  CHECK(with([] {}).empty());
  CHECK_THAT(with([&] { p.velocity[4][0] = std::numeric_limits<Real>::quiet_NaN(); }), finds);
  CHECK_THAT(with([&] { p.inertia[1] = 2; }), finds);  // a coupling that did not take back what the point carried
  CHECK_THAT(with([&] { p.inv_mass[1] = 2; }), finds);
  CHECK_THAT(with([&] { p.net[2] = p.net[3]; }), finds);
  CHECK_THAT(with([&] { p.collider[1] = 0; }), finds);
  CHECK_THAT(with([&] { p.mass.pop_back(); }), finds);
  CHECK_THAT(with([&] { p.position.pop_back(); }), finds);
  CHECK_THAT(with([&] { world.objects().set_index(net, 1); }), finds);
}
