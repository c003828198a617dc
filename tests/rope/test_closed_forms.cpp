// Ropes against closed forms, at default settings.
#include "base/double3.h"
#include "ropes.h"

namespace feder::test {
namespace {

// Sag of a catenary of length `l` between two points of equal height at a distance of 1.
double catenary_sag(double l) {
  double lo = 1e-6, hi = 100;  // 1/(2 a): l = sinh(k)/k
  for (int i = 0; i < 200; ++i) {
    const double k = (lo + hi) / 2;
    (std::sinh(k) / k < l ? lo : hi) = k;
  }
  return (std::cosh(lo) - 1) / (2 * lo);
}

// Static cylinder along z of `radius`, and a rope that wraps it by `angle` with straight ends of 0.3 m; r of the rope.
RopeDesc wrapped_rope(double radius, double angle, double r, int wrapped) {
  RopeDesc d;
  d.radius = static_cast<Real>(r);
  const double path = radius + r, step = path * angle / wrapped, from = M_PI / 2 + angle / 2;
  const auto add = [&](double x, double y) { d.points.push_back(vec3(static_cast<Real>(x), static_cast<Real>(y), 0)); };
  const int straight = static_cast<int>(0.3 / step);
  for (int i = straight; i > 0; --i)  // against the tangent at the start
    add(path * std::cos(from) - i * step * std::sin(from), path * std::sin(from) + i * step * std::cos(from));
  for (int i = 0; i <= wrapped; ++i)
    add(path * std::cos(from - angle * i / wrapped), path * std::sin(from - angle * i / wrapped));
  const double to = from - angle;
  for (int i = 1; i <= straight; ++i)
    add(path * std::cos(to) + i * step * std::sin(to), path * std::sin(to) - i * step * std::cos(to));
  return d;
}

// How far the loaded end slips in 2 s when it is pulled `ratio` times as hard as the other.
double slip(double angle, double ratio, double friction) {
  WorldDesc desc;
  desc.gravity = Vec3(0, 0, 0);
  World w(desc, catalog());
  BodyDesc post;
  post.type = BodyType::fixed;
  post.shape = make_cylinder(Real(0.06), 1);
  post.rotation = from_axis_angle(Vec3(1, 0, 0), Real(M_PI / 2));
  post.friction_static = post.friction_dynamic = static_cast<Real>(friction);
  w.need<Rigid>().add_body(post);
  RopeDesc d = wrapped_rope(0.06, angle, 0.01, static_cast<int>(angle / M_PI * 24));
  d.friction = static_cast<Real>(friction);
  d.self_collision = false;  // a whole turn in one plane passes through itself
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(d);
  const std::size_t last = d.points.size() - 1;
  const Vec3 pulls[2] = {normalized_or(Vec3(d.points[0] - d.points[1]), Vec3(1, 0, 0)),
                         normalized_or(Vec3(d.points[last] - d.points[last - 1]), Vec3(1, 0, 0))};
  const Real small = 5;
  rope.set_script_force(id, 0, small * pulls[0]);
  rope.set_script_force(id, last, small * pulls[1]);
  for (int k = 0; k < 60; ++k) w.step();
  const Vec3 x = rope.point(id, last);
  rope.set_script_force(id, last, static_cast<Real>(ratio) * small * pulls[1]);
  for (int k = 0; k < 120; ++k) w.step();
  return number(dot(Vec3(rope.point(id, last) - x), pulls[1]));
}

}  // namespace

TEST_CASE("a limp rope hangs as a catenary", "[rope]") {
  const double ratio = GENERATE(1.1, 2.0, 3.0);
  const int n = 60;
  RopeDesc d;
  // a V of the rope's length
  const double depth = std::sqrt(ratio * ratio - 1) / 2;
  for (int i = 0; i <= n; ++i) {
    const double s = double(i) / n;
    d.points.push_back(vec3(static_cast<Real>(s), static_cast<Real>(-depth * (1 - std::fabs(2 * s - 1))), 0));
  }
  d.pins = {0, n};
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(d);
  settle(w, id, 20);
  Real lowest = 0;
  for (int i = 0; i <= n; ++i) lowest = std::min(lowest, rope.point(id, static_cast<std::size_t>(i))[1]);
  CAPTURE(ratio, lowest, catenary_sag(ratio), number(rope.max_strain(id)));
  CHECK(std::fabs(-number(lowest) / catenary_sag(ratio) - 1) < 0.01);
}

TEST_CASE("a rope round a post holds e^(mu phi) times its load", "[rope]") {
  const double angle = GENERATE(M_PI / 2, M_PI, 2 * M_PI), friction = 0.3;
  const double ratio = std::exp(friction * angle);
  CAPTURE(angle, ratio);
  const double held = slip(angle, 0.97 * ratio, friction), slipped = slip(angle, 1.03 * ratio, friction);
  CAPTURE(held, slipped);
  CHECK(held < 0.004);
  CHECK(slipped > 0.03);
}

// Both ends lie in one plane; the post turns below the rope, so that friction is what it may be at all points.
TEST_CASE("a rope that slips on a turning post bears e^(mu phi) times its load, or that much less", "[rope]") {
  const double turn = GENERATE(0.5, 1.0, 2.0, 3.0), friction = GENERATE(0.2, 0.5);
  const int way = GENERATE(1, -1), wrapped = GENERATE(12, 24);
  World w(vacuum(), catalog());
  BodyDesc post;
  post.type = BodyType::kinematic;
  post.shape = make_cylinder(Real(0.06), 1);
  post.rotation = from_axis_angle(Vec3(1, 0, 0), Real(M_PI / 2));
  post.angular_velocity = vec3(0, 0, static_cast<Real>(-2 * way));
  post.friction_static = post.friction_dynamic = static_cast<Real>(friction);
  w.need<Rigid>().add_body(post);
  const double angle = M_PI * turn, ratio = std::exp(way * friction * angle);
  RopeDesc d = wrapped_rope(0.06, angle, 0.01, static_cast<int>(turn * wrapped));
  // turned so that its second end hangs
  const double c = std::cos((angle - M_PI) / 2), sine = std::sin((angle - M_PI) / 2);
  for (Vec3& x : d.points)
    x = narrow({c * number(x[0]) - sine * number(x[1]), sine * number(x[0]) + c * number(x[1]), 0});
  d.friction = static_cast<Real>(friction), d.pins = {0}, d.gravity_scale = 0, d.self_collision = false;
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(d);
  const std::size_t last = d.points.size() - 1;
  BodyDesc weight;
  weight.shape = make_sphere(Real(0.05));
  const double pull = 500 / std::max(1.0, ratio);  // N
  weight.density = static_cast<Real>(pull / 9.81 / (4.0 / 3 * M_PI * 0.05 * 0.05 * 0.05));
  weight.position = d.points[last] - vec3(0, Real(0.05), 0);
  weight.mask = 0;
  rope.attach(id, last, w.need<Rigid>().add_body(weight), vec3(0, Real(0.05), 0));
  double sum = 0;
  for (int k = 0; k < 120; ++k) {
    w.step();
    if (k >= 60) sum += number(rope.tension(id, 0)) / 60;
  }
  CAPTURE(turn, friction, way, wrapped, ratio, sum / pull);
  // of second order in the angle at a point, and 1 % for the rest
  CHECK(std::fabs(sum / pull / ratio - 1) < (wrapped == 24 ? 0.02 : 0.06));
}

TEST_CASE("a clamped rope bends as the elastica", "[rope]") {
  // deflection of the tip over the length under its own weight: Gamma = w L^3/(E I) = 1, 10
  const double gamma = GENERATE(1.0, 10.0);
  RopeDesc d = straight_rope(Vec3(0, 0, 0), Vec3(1, 0, 0), 40);
  d.clamp_first = true;
  d.radius = Real(0.01);
  const double weight = M_PI * 1e-4 * 1000 * 9.81;  // N/m
  d.bend = static_cast<Real>(weight / gamma);
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(d);
  settle(w, id, 20, 1e-5);
  // reference: shooting of theta'' = -gamma (1 - s) cos(theta), theta(0) = 0, theta'(1) = 0
  const auto shoot = [&](double slope, double& drop) {
    double theta = 0, rate = slope;
    drop = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
      const double s = (i + 0.5) / n, mid = theta + rate / (2 * n);
      drop += std::sin(mid) / n;
      rate += -gamma * (1 - s) * -std::cos(mid) / n;
      theta += rate / n;
    }
    return rate;
  };
  double lo = -20, hi = 0, drop = 0;
  for (int i = 0; i < 80; ++i) {
    const double k = (lo + hi) / 2;
    (shoot(k, drop) > 0 ? hi : lo) = k;
  }
  const double tip = number(rope.point(id, 40)[1]);
  CAPTURE(gamma, tip, drop);
  CHECK(std::fabs(tip / drop - 1) < 0.03);
}

TEST_CASE("a limp rope swings in its first mode", "[rope]") {
  const int n = 40;
  RopeDesc d;
  for (int i = 0; i <= n; ++i) {  // J0(2.4048 sqrt(s)) from the free end: here by its shape under small angles
    const double s = 1 - double(i) / n, z = 2.404826 * std::sqrt(s);
    double j0 = 0, term = 1;
    for (int k = 0; k < 20; ++k) j0 += term, term *= -(z * z / 4) / ((k + 1.0) * (k + 1.0));
    d.points.push_back(vec3(static_cast<Real>(0.02 * j0), static_cast<Real>(s - 1), 0));
  }
  d.pins = {0};
  World w(vacuum(), catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(d);
  // quarter periods: crossings of the tip
  std::vector<double> crossings;
  double last = 1, first_peak = 0, later_peak = 0;
  for (int k = 0; k < 60 * 9; ++k) {
    w.step();
    const double x = number(rope.point(id, n)[0]), t = (k + 1) / 60.0;
    if (last > 0 && x <= 0) crossings.push_back(t - x / (x - last) / 60.0);
    if (t < 2) first_peak = std::max(first_peak, x);
    if (t > 7) later_peak = std::max(later_peak, x);
    last = x;
  }
  REQUIRE(crossings.size() >= 4);
  const double period = (crossings[3] - crossings[0]) / 3, wanted = 2 * M_PI / (2.404826 / 2 * std::sqrt(9.81));
  CAPTURE(period, wanted, first_peak, later_peak);
  CHECK(std::fabs(period / wanted - 1) < 0.01);
  CHECK(later_peak > 0.8 * first_peak);
}

TEST_CASE("a free rope falls as a stone and keeps its momenta", "[rope]") {
  World w(vacuum(), catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d;
  for (int i = 0; i <= 30; ++i)
    d.points.push_back(vec3(Real(0.03) * static_cast<Real>(i), Real(0.05) * static_cast<Real>(i % 3), 5));
  d.self_collision = false;
  d.bend = Real(0.01);
  const ObjectId id = rope.add_rope(d);
  const auto mean = [&] {
    Double3 x{0, 0, 0};
    double mass = 0;
    for (std::size_t i = 0; i <= 30; ++i)
      x = x + number(rope.point_mass(id, i)) * wide(rope.point(id, i)), mass += number(rope.point_mass(id, i));
    return (1 / mass) * x;
  };
  for (std::size_t i = 0; i <= 30; ++i)
    rope.set_velocity(id, i, vec3(0, static_cast<Real>(i % 7) - 3, static_cast<Real>(i) / 5));
  const Double3 x0 = mean();
  const Momentum p0 = w.momentum();
  double mass = 0;
  for (std::size_t i = 0; i <= 30; ++i) mass += number(rope.point_mass(id, i));
  for (int k = 0; k < 60; ++k) w.step();
  const Momentum p = w.momentum();
  const Double3 x1 = mean();
  CHECK(std::fabs(p.linear[1] - p0.linear[1] + mass * 9.81) < 1e-4 * mass * 9.81);
  CHECK(std::fabs(x1.y - (x0.y + p0.linear[1] / mass - 0.5 * 9.81)) < 1e-3);
  CHECK(std::fabs(p.linear[2] - p0.linear[2]) < 1e-5 * std::fabs(p0.linear[2]));
}

TEST_CASE("angular momentum of a tumbling rope", "[rope]") {
  World w(vacuum(Vec3(0, 0, 0)), catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = straight_rope(Vec3(-1, 0, 0), Vec3(1, 0, 0), 40);
  const ObjectId id = rope.add_rope(d);
  for (std::size_t i = 0; i <= 40; ++i) {
    const Real x = rope.point(id, i)[0];
    rope.set_velocity(id, i, vec3(0, 5 * x, i > 30 ? Real(1) : Real(0)));
  }
  const Momentum p0 = w.momentum();
  for (int k = 0; k < 120; ++k) w.step();
  const Momentum p = w.momentum();
  CAPTURE(p0.angular[2], p.angular[2]);
  CHECK(std::fabs(p.angular[2] / p0.angular[2] - 1) < 1e-4);
}

}  // namespace feder::test
