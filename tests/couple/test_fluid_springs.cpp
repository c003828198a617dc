// Fluid and nets with faces: momentum passes both ways, nothing passes a face, a net carries what lies on it.
#include <cmath>

#include "couple/fluid_parts.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("a blob hits a free net: momentum and angular momentum are kept", "[couple][fluid][springs]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.options.set("air_density", 0.0);
  World w(wd, mixed_catalog());
  Springs& springs = w.need<Springs>();
  const ObjectId net = springs.add_net(mat(11, 1, 2, 400));
  check_blow(w, solver, "fluid_springs.impulse_mismatch", 0.1, [&] {
    Vec3 u = Vec3::Zero();
    for (std::size_t i = 0; i < springs.point_count(net); ++i)
      u += springs.point_mass(net, i) * springs.velocity(net, i);
    return u;
  });
}

TEST_CASE("no particle passes the faces of a pinned net", "[couple][fluid][springs]") {
  const double speed = GENERATE(1.0, 10.0, 20.0);
  World w(WorldDesc{}, mixed_catalog());
  Fluid& fluid = w.need<Fluid>();
  Springs& springs = w.need<Springs>();
  const ObjectId net = springs.add_net(mat(11, 1, 10, 4000));
  for (std::size_t i = 0; i < springs.point_count(net); ++i) {
    const Vec3 x = springs.point(net, i);
    if (std::fabs(x[0]) > Real(0.49) || std::fabs(x[2]) > Real(0.49)) springs.pin(net, i);
  }
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(4, 4, 4, Real(0.05), Vec3(Real(0.013), Real(0.3), Real(0.027))),
             Vec3(0, static_cast<Real>(-speed), 0));
  std::vector<Vec3> x;
  int below = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    fluid.positions(id, x);
    for (const Vec3& q : x) {
      // lower than the lowest point of the net
      Real lowest = 0;
      for (std::size_t i = 0; i < springs.point_count(net); ++i) lowest = std::min(lowest, springs.point(net, i)[1]);
      below += q[1] < lowest && std::fabs(q[0]) < Real(0.5) && std::fabs(q[2]) < Real(0.5);
    }
  }
  CAPTURE(speed, below, residual(w, "fluid_springs.guarded"));
  CHECK(below == 0);
  CHECK(w.is_finite());
}
