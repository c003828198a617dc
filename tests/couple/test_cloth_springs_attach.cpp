// Points of nets and vertices of cloths attached to a body far from their place: they come to it, and it is not thrown.
#include <cmath>

#include "couple/all_but_fluid.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A square of 5 x 5 points, 1 m wide: 1 kg as net, 0.2 kg as cloth.
ObjectId add_net(World& w) {
  NetDesc d;
  for (std::uint32_t k = 0; k < 25; ++k) {
    d.points.push_back(Vec3(Real(k % 5) / 4, 0, Real(k / 5) / 4));
    d.masses.push_back(Real(0.04));
    if (k % 5) d.springs.push_back({k - 1, k, 50, Real(0.1), -1, kInfinity});
    if (k > 4) d.springs.push_back({k - 5, k, 50, Real(0.1), -1, kInfinity});
  }
  return w.need<Springs>().add_net(d);
}

ObjectId add_cloth(World& w, const std::string& solver) {
  ClothDesc d;
  d.solver = solver;
  d.nx = d.ny = 5;
  d.size[0] = d.size[1] = 1;
  d.self_collision = false;
  return w.need<Cloth>().add_cloth(d);
}

}  // namespace

TEST_CASE("attaching points far from their place does not throw the body", "[couple]") {
  const std::string what = GENERATE("net", "xpbd", "mass_spring", "vbd", "implicit");
  const Real gap = GENERATE(Real(0.5), Real(3));
  const Real mass = GENERATE(Real(0.1), Real(4), Real(100));
  const int points = GENERATE(1, 2);  // two corners at one place: cloth cannot
  CAPTURE(what, gap, mass, points);
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.sleeping = false;
  World w(wd, kAllButFluid);
  BodyDesc b;
  b.shape = make_box(Real(0.3), Real(0.1), Real(0.2));
  b.mass = mass;
  b.position = Vec3(Real(0.5), gap, Real(0.5));
  const ObjectId body = w.need<Rigid>().add_body(b);
  const ObjectId sheet = what == "net" ? add_net(w) : add_cloth(w, what);
  const Vec3 at(Real(0.15), Real(-0.05), Real(0.1));
  for (int k = 0; k < points; ++k) {
    const Vec3 local = k ? Vec3(-at) : at;
    const std::uint32_t point = k ? 24 : 0;
    what == "net" ? w.need<Springs>().attach(sheet, point, body, local)
                  : w.need<Cloth>().attach(sheet, point, body, local);
  }
  double most = 0;
  for (int k = 0; k < 120; ++k) {
    w.step();
    const double now = w.energy().kinetic;
    most = std::isfinite(now) ? std::max(most, now) : HUGE_VAL;
  }
  CHECK(most <= 0.5 * (double(mass) + 1) * 6 * 6);  // twice the 3 m/s at which attachments close
  if (what == "net" && points == 1) {
    for (const Residual& r : w.residuals())
      if (r.name == "springs_rigid.attachment_error_m") CHECK(r.value < 0.01);
  }
}
