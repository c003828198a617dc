// Every residual of cloth, nets and their contacts with bodies: made to be something, and right.
#include <cmath>

#include "cloth/sheets.h"
#include "couple/all_but_fluid.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

double residual(const World& w, std::string_view name) {
  for (const Residual& r : w.residuals())
    if (r.name == name) return r.value;
  return NAN;
}

ClothDesc patch(std::uint32_t n, Real size) {
  ClothDesc d;
  d.nx = d.ny = n;
  d.size[0] = d.size[1] = size;
  d.self_collision = false;
  return d;
}

}  // namespace

TEST_CASE("cloth.max_strain is that of the longest edge", "[couple][residuals]") {
  World w(weightless(), kAllButFluid);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(patch(3, 1));
  CHECK(std::fabs(residual(w, "cloth.max_strain")) < 1e-6);
  cloth.set_point(id, 0, cloth.point(id, 0) + Vec3(-Real(0.1), 0, 0));  // edges of 0.5 m
  CHECK(residual(w, "cloth.max_strain") == Approx(0.2).epsilon(1e-5));
}

TEST_CASE("cloth.small_steps and cloth.row_updates count the work of a step", "[couple][residuals]") {
  double updates[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    World w(weightless(), kAllButFluid);
    ClothDesc d = patch(3, 1);
    d.substeps = k ? 7 : 1;
    const ObjectId id = w.need<Cloth>().add_cloth(d);
    w.step();
    CHECK(residual(w, "cloth.small_steps") == d.substeps);
    updates[k] = residual(w, "cloth.row_updates");
    CHECK(updates[k] >= static_cast<double>(w.need<Cloth>().edge_count(id)) * d.substeps * 4);
  }
  CHECK(updates[1] == 7 * updates[0]);
}

TEST_CASE("contact.guarded and contact.widened: 0 where nothing meets, more where cloth strikes cloth",
          "[couple][residuals]") {
  const bool strikes = GENERATE(false, true);
  World w(weightless(), kAllButFluid);
  Cloth& cloth = w.need<Cloth>();
  for (int k = 0; k < 2; ++k) {
    ClothDesc d = patch(7, 1);
    d.self_collision = true;
    d.pose.position = Vec3(0, k ? Real(0.3) : Real(0), k ? Real(0.21) : Real(0));
    if (k) d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), Real(0.4)), d.velocity = Vec3(0, strikes ? -60 : 0, 0);
    cloth.add_cloth(d);
  }
  double projected = 0, widened = 0;
  for (int k = 0; k < 10; ++k) {
    w.step();
    projected += residual(w, "contact.guarded"), widened += residual(w, "contact.widened");
  }
  CAPTURE(projected, widened);
  CHECK((projected > 0) == strikes);
  CHECK((widened > 0) == strikes);
}

TEST_CASE("cloth.sleeping and cloth.quarantined count cloths", "[couple][residuals]") {
  World w(weightless(), kAllButFluid);
  Cloth& cloth = w.need<Cloth>();
  ObjectId id[3];
  for (ObjectId& i : id) {
    ClothDesc d = patch(3, 1);
    d.mask = d.group = 0;
    i = cloth.add_cloth(d);
  }
  CHECK(residual(w, "cloth.sleeping") == 0);
  CHECK(residual(w, "cloth.quarantined") == 0);
  cloth.sleep(id[0]), cloth.sleep(id[1]);
  cloth.set_velocity(id[2], 4, Vec3(std::numeric_limits<Real>::max(), 0, 0));
  w.step();
  CHECK(residual(w, "cloth.sleeping") == 2);
  CHECK(residual(w, "cloth.quarantined") == 1);
}

TEST_CASE("cloth_rigid.penetration_m is the depth that is there at the end of the step", "[couple][residuals]") {
  WorldDesc wd = weightless();
  SECTION("of pinned vertices and triangles between them") {
    const double depth = GENERATE(-0.01, 0.002, 0.043, 0.2);
    const int kind = GENERATE(0, 1, 2);
    World w(wd, kAllButFluid);
    BodyDesc b;
    b.type = BodyType::fixed;
    b.shape = kind == 0 ? make_sphere(Real(0.3)) : kind == 1 ? make_box(1, Real(0.6), 1) : make_capsule(Real(0.3), 1);
    if (kind == 2) b.rotation = from_axis_angle(Vec3(0, 0, 1), kPi / 2);
    w.need<Rigid>().add_body(b);
    ClothDesc d = patch(4, Real(0.6));  // no vertex in the middle: the sphere is deepest in a triangle
    d.pose.position = Vec3(0, Real(0.3 - depth), 0);
    for (std::uint32_t i = 0; i < 16; ++i) d.pins.push_back(i);
    w.need<Cloth>().add_cloth(d);
    const double half = 0.005;
    CAPTURE(depth, kind);
    CHECK(residual(w, "cloth_rigid.penetration_m") == Approx(std::max(depth + half, 0.0)).margin(2e-5));
    for (int k = 0; k < 3; ++k) w.step();
    CHECK(residual(w, "cloth_rigid.penetration_m") == Approx(std::max(depth + half, 0.0)).margin(2e-5));
  }
  SECTION("of a free sheet that starts inside: while it is being pushed out") {
    World w(wd, kAllButFluid);
    BodyDesc b;
    b.type = BodyType::fixed;
    b.shape = make_box(2, Real(0.6), 2);
    w.need<Rigid>().add_body(b);
    ClothDesc d = patch(4, Real(0.6));
    d.pose.position = Vec3(0, Real(0.2), 0);
    Cloth& cloth = w.need<Cloth>();
    const ObjectId id = cloth.add_cloth(d);
    for (int k = 0; k < 12; ++k) {
      w.step();
      double deepest = 0;
      for (std::size_t i = 0; i < 16; ++i)
        deepest = std::max(deepest, 0.305 - static_cast<double>(cloth.point(id, i)[1]));
      CAPTURE(k);
      CHECK(residual(w, "cloth_rigid.penetration_m") == Approx(deepest).margin(2e-5));
      if (k == 1) CHECK(deepest > 0.05);
    }
    CHECK(residual(w, "cloth_rigid.penetration_m") < 1e-3);
  }
}

TEST_CASE("cloth_rigid.attachment_error_m and springs_rigid.attachment_error_m are distances", "[couple][residuals]") {
  World w(weightless(), kAllButFluid);
  BodyDesc b;
  b.shape = make_sphere(Real(0.1));
  b.position = Vec3(0, 5, 0);
  const ObjectId body = w.need<Rigid>().add_body(b);
  CHECK(std::isnan(residual(w, "cloth_rigid.attachment_error_m")));
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(patch(3, 1));
  const Vec3 anchor(Real(0.05), 0, 0);
  cloth.attach(id, 4, body, anchor);
  cloth.set_point(id, 4, Vec3(Real(0.05), Real(5.03), Real(0.04)));
  CHECK(residual(w, "cloth_rigid.attachment_error_m") == Approx(0.05).epsilon(1e-4));
  NetDesc n;
  n.points = {Vec3(0, Real(5.12), Real(0.05)), Vec3(1, 5, 0)};
  n.masses = {1, 1};
  n.springs.push_back({0, 1, 10, 0, 1, kInfinity});
  const ObjectId net = w.need<Springs>().add_net(n);
  w.need<Springs>().attach(net, 0, body, Vec3(0, 0, 0));
  CHECK(residual(w, "springs_rigid.attachment_error_m") == Approx(0.13).epsilon(1e-4));
}

TEST_CASE("contact: pairs that may touch, what was passed on, and that both sides got it", "[couple][residuals]") {
  World w(weightless(), kAllButFluid);
  Cloth& cloth = w.need<Cloth>();
  const auto add = [&](Real y, Real speed) {
    ClothDesc d = patch(6, Real(0.5));
    d.pose.position = Vec3(0, y, 0);
    d.velocity = Vec3(0, speed, 0);
    d.friction = 0;
    return cloth.add_cloth(d);
  };
  add(0, 0);
  const ObjectId high = add(Real(0.05), -2);
  add(9, 0);
  w.step();
  CHECK(residual(w, "contact.pairs") == 1);
  CHECK(residual(w, "contact.impulse_ns") == 0);
  CHECK(residual(w, "contact.impulse_mismatch") == 0);
  double passed = 0, lost = 0;
  for (int k = 0; k < 12; ++k) {
    w.step();
    passed += residual(w, "contact.impulse_ns");
    lost += residual(w, "contact.impulse_mismatch") * residual(w, "contact.impulse_ns");
  }
  // fully plastic: both go on with half the speed
  double momentum = 0;
  for (std::size_t i = 0; i < 36; ++i)
    momentum += static_cast<double>(cloth.point_mass(high, i)) * static_cast<double>(cloth.velocity(high, i)[1] + 2);
  CHECK(momentum == Approx(0.05).epsilon(0.02));
  CHECK(passed == Approx(momentum).epsilon(0.02));
  CHECK(lost > 0);  // rounding
  CHECK(lost < 1e-5 * passed);
  CHECK(residual(w, "contact.pairs") == 1);
}

TEST_CASE("springs: strain, quarantined nets, ends at one spot, solves that missed", "[couple][residuals]") {
  World w(weightless(), kAllButFluid);
  Springs& springs = w.need<Springs>();
  NetDesc n;
  n.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)};
  n.masses = {1, 1, 1};
  n.springs.push_back({0, 1, 10, 0, 1, kInfinity});
  n.springs.push_back({1, 2, 10, 0, 1, kInfinity});
  const ObjectId net = springs.add_net(n);
  CHECK(residual(w, "springs.max_strain") == Approx(0).margin(1e-6));
  springs.set_point(net, 2, Vec3(Real(1.6), 0, 0));  // compression counts too
  CHECK(residual(w, "springs.max_strain") == Approx(0.4).epsilon(1e-4));
  CHECK(residual(w, "springs.coincident_ends") == 0);
  springs.set_point(net, 2, Vec3(1, 0, 0));
  w.step();
  CHECK(residual(w, "springs.coincident_ends") == 1);
  CHECK(residual(w, "springs.quarantined_nets") == 0);
  springs.set_velocity(net, 0, Vec3(std::numeric_limits<Real>::max(), 0, 0));
  w.step();
  CHECK(residual(w, "springs.quarantined_nets") == 1);
}

TEST_CASE("springs.unconverged_solves counts solves that ended at their cap", "[couple][residuals]") {
  const int iterations = GENERATE(2, 50);
  World w(weightless(), kAllButFluid);
  Springs& springs = w.need<Springs>();
  NetDesc n;
  n.points = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 3, 0)};
  n.masses = {1, 1, 1};
  for (std::uint32_t i = 0; i < 3; ++i)
    for (std::uint32_t j = i + 1; j < 3; ++j) n.springs.push_back({i, j, Real(1e6), 0, 1, kInfinity});
  n.integrator = "implicit_euler";
  n.integrator_options.set("iterations", static_cast<double>(iterations));
  springs.add_net(n);
  for (int k = 0; k < 5; ++k) w.step();
  CAPTURE(iterations);
  const double missed = residual(w, "springs.unconverged_solves");
  CHECK(missed <= 5 * 4);
  CHECK((missed > 0) == (iterations == 2));
}
