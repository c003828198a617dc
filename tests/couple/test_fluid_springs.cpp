// Fluid and nets with faces: momentum passes both ways, nothing passes a face, a net carries what lies on it.
#include <cmath>

#include "couple/fluid_parts.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("a blob hits a free net: momentum and angular momentum are kept", "[couple][fluid][springs]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"), std::string("dfsph"));
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

TEST_CASE("a drop that slides on the faces of a net is slowed by friction", "[couple][fluid][springs]") {
  World w(WorldDesc{}, mixed_catalog());
  Springs& springs = w.need<Springs>();
  const ObjectId net = springs.add_net(mat(11, 2, 10, 4000));
  for (std::size_t i = 0; i < springs.point_count(net); ++i) springs.pin(net, i);
  check_slide(w, 0);
}

namespace {

// A mat of 1 m whose rim is held.
ObjectId add_pinned_mat(Springs& springs) {
  const ObjectId net = springs.add_net(mat(11, 1, 10, 4000));
  for (std::size_t i = 0; i < springs.point_count(net); ++i) {
    const Vec3 x = springs.point(net, i);
    if (std::fabs(x[0]) > Real(0.49) || std::fabs(x[2]) > Real(0.49)) springs.pin(net, i);
  }
  return net;
}

}  // namespace

// At 80 m/s some do: nets do not meet themselves, and layers of them pass through each other with what lies between.
TEST_CASE("no particle passes the faces of a pinned net", "[couple][fluid][springs]") {
  const double speed = GENERATE(1.0, 10.0, 20.0);
  World w(WorldDesc{}, mixed_catalog());
  Fluid& fluid = w.need<Fluid>();
  Springs& springs = w.need<Springs>();
  const ObjectId net = add_pinned_mat(springs);
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

TEST_CASE("fluid and nets: contacts begin and end in pairs, one per fluid and net", "[couple][fluid][springs]") {
  const bool destroyed = GENERATE(false, true);
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  World w(wd, mixed_catalog());
  w.events().set_wanted(EventKind::hit, true);
  Springs& springs = w.need<Springs>();
  Fluid& fluid = w.need<Fluid>();
  const ObjectId net = springs.add_net(mat(9, 1, 4, 4000));
  for (std::size_t i = 0; i < springs.point_count(net); ++i)
    if (std::fabs(springs.point(net, i)[0]) > Real(0.49)) springs.pin(net, i);
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(3, 3, 3, Real(0.05), Vec3(0, Real(0.3), 0)), Vec3(0, -3, 0));
  int begins = 0, ends = 0, hits = 0;
  std::uint32_t most = 0;
  for (int k = 0; k < 120; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::contact_begin && e.kind != EventKind::contact_end && e.kind != EventKind::hit) continue;
      CHECK(e.a == net);
      CHECK(e.b == id);
      if (e.kind == EventKind::hit) {
        ++hits;
        if (hits == 1) CHECK(e.speed == Approx(3).epsilon(0.1));
        CHECK(e.impulse > 0);
        continue;
      }
      const bool begin = e.kind == EventKind::contact_begin;
      ++(begin ? begins : ends);
      CHECK((begins == ends || begins == ends + 1));
      CHECK(begin == (e.index > 0));
      most = std::max(most, e.index);
      CHECK((!begin || e.normal[1] > Real(0.5)));
      CHECK((!begin || e.point[1] < Real(0.3)));
    }
    if (destroyed && begins > 0 && springs.net_count() > 0) springs.destroy_net(net, "");
  }
  CAPTURE(destroyed, begins, ends, most);
  CHECK(begins >= 1);
  CHECK(hits >= 1);
  CHECK(begins == ends);  // it bounced off, or the net is gone
  CHECK(most >= 1);
  CHECK(most <= 27);
}

TEST_CASE("fluid that lies on a net stays in contact", "[couple][fluid][springs]") {
  World w(WorldDesc{}, mixed_catalog());
  Springs& springs = w.need<Springs>();
  Fluid& fluid = w.need<Fluid>();
  add_pinned_mat(springs);
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(6, 2, 6, Real(0.05), Vec3(0, Real(0.1), 0)), Vec3::Zero());
  int begins = 0, ends = 0;
  std::string image;
  for (int k = 0; k < 150; ++k) {
    if (k == 120) {
      begins = ends = 0;
      image = w.snapshot();
    }
    w.step();
    for (const Event& e : w.events().list())
      begins += e.kind == EventKind::contact_begin, ends += e.kind == EventKind::contact_end;
  }
  CHECK((begins == 0 && ends == 0));
  const std::uint64_t hash = w.hash();
  w.restore(image);
  for (int k = 0; k < 30; ++k) {
    w.step();
    for (const Event& e : w.events().list()) begins += e.kind == EventKind::contact_begin;
  }
  CHECK(begins == 0);  // restored in contact
  CHECK(w.hash() == hash);
  fluid.destroy_fluid(id, "");
  w.step();
  for (const Event& e : w.events().list()) ends += e.kind == EventKind::contact_end;
  CHECK(ends == 1);
}
