// Fluid and nets with faces: momentum passes both ways, nothing passes a face, a net carries what lies on it.
#include <cmath>

#include "couple/fluid_parts.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A square of n x n points in the xz plane.
NetDesc mat(std::uint32_t n, Real size, Real mass, Real stiffness) {
  NetDesc d;
  const Real cell = size / static_cast<Real>(n - 1);
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i)
      d.points.push_back(Vec3(cell * static_cast<Real>(i) - size / 2, 0, cell * static_cast<Real>(j) - size / 2));
  d.masses.assign(d.points.size(), mass / static_cast<Real>(d.points.size()));
  const auto spring = [&](std::uint32_t a, std::uint32_t b) {
    SpringDesc s;
    s.i = a, s.j = b, s.stiffness = stiffness, s.damping = Real(0.002) * stiffness;
    d.springs.push_back(s);
  };
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t k = j * n + i;
      if (i + 1 < n) spring(k, k + 1);
      if (j + 1 < n) spring(k, k + n);
      if (i + 1 == n || j + 1 == n) continue;
      spring(k, k + n + 1), spring(k + 1, k + n);
      d.faces.insert(d.faces.end(), {k, k + 1, k + n, k + 1, k + n + 1, k + n});
    }
  return d;
}

}  // namespace

TEST_CASE("a blob hits a free net: momentum and angular momentum are kept", "[couple][fluid][springs]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
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
