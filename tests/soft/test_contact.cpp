// Soft bodies against each other and against fast bodies: they keep apart, and nothing passes.
#include "soft_contact.h"
#include "state/bodies.h"

namespace feder::test {

TEST_CASE("two jelly balls dropped on each other keep their centres three quarters of a diameter apart", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  add_ground(w);
  SoftDesc d;
  d.shape = make_sphere(Real(0.5)), d.young = Real(5e5), d.resolution = 6;
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  d.pose.position = vec3(0, Real(0.55), 0);
  const ObjectId lower = soft.add_soft(d);
  d.pose.position = vec3(Real(0.02), Real(1.9), Real(0.01));
  const ObjectId upper = soft.add_soft(d);
  double least = 1e9;
  for (int k = 0; k < 90; ++k) {
    run_without_crossing(w, 1.0 / 60, [](Soup&) {});
    least = std::min(least, number(length(Vec3(center_of(soft, upper) - center_of(soft, lower)))));
  }
  CHECK(least >= 0.75);
  CHECK(least < 1.05);  // they met
  CHECK(soft.inverted(lower) + soft.inverted(upper) == 0);
}

TEST_CASE("two blocks that meet in free space exchange momentum and no more", "[soft]") {
  World w(free_space(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 4);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  d.velocity = Vec3(3, 0, 0);
  const ObjectId a = soft.add_soft(d);
  d.velocity = Vec3(0, 0, 0);
  d.pose.position = vec3(Real(0.3), Real(0.05), Real(0.02));
  d.pose.rotation = from_axis_angle(Vec3(1, 2, 3), Real(0.7));
  const ObjectId b = soft.add_soft(d);
  const Momentum before = w.momentum();
  run_without_crossing(w, 0.5, [](Soup&) {});
  // backward Euler takes one solver substep where xpbd takes five
  check_momentum(before, w.momentum(), 3 * mass_of(soft, a), is_backward_euler(d.solver) ? 2e-3 : 1e-3);
  CHECK(number(center_of(soft, b)[0]) > 0.4);
}

TEST_CASE("a fast ball does not pass a soft block", "[soft]") {
  const double speed = GENERATE(10.0, 30.0, 100.0, 400.0);
  CAPTURE(speed);
  World w(free_space(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc block = soft_box(vec3(Real(0.3), Real(0.3), Real(0.3)), 6);
  block.solver = any_soft_solver();
  CAPTURE(block.solver);
  const ObjectId id = soft.add_soft(block);
  BodyDesc ball;
  ball.shape = make_sphere(Real(0.05));
  ball.position = vec3(Real(-0.6), Real(0.02), Real(0.03));
  ball.velocity = vec3(static_cast<Real>(speed), 0, 0);
  const ObjectId body = w.need<Rigid>().add_body(ball);
  const auto place = [&] { return w.need<Rigid>().bodies().position[w.need<Rigid>().index(body)]; };
  const Momentum before = w.momentum();
  for (int k = 0; k < 60; ++k) w.step();
  // within the skin or beyond it: a ray from the ball back to where it came from meets the skin
  const Soft::Info info = soft.info(id);
  const Vec3 x = place();
  CAPTURE(x[0], x[1], x[2]);
  int met = 0;
  for (std::size_t t = 0; t < info.skin.size(); t += 3) {
    Point p[5];
    for (std::size_t k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) p[k][std::size_t(i)] = number(info.points[info.skin[t + k]][i]);
    for (int i = 0; i < 3; ++i) p[3][std::size_t(i)] = p[4][std::size_t(i)] = number(x[i]);
    p[4][0] -= 1000;
    met += crosses(p[3], p[4], p[0], p[1], p[2], 0);
  }
  CHECK(met == 0);
  CHECK(number(center_of(soft, id)[0]) > number(x[0]));
  CHECK(w.is_finite());
  check_linear(before, w.momentum(), before.linear[0]);
}

}  // namespace feder::test
