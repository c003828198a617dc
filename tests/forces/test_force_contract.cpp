// The contract of feder/force.h for every registered kind, with default options and with some set.
#include <cmath>
#include <cstring>
#include <vector>

#include "base/rng.h"
#include "feder/force.h"
#include "feder/memory.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Options that give a kind something to do; kinds without an entry are taken with their defaults.
Params sample_options(const char* kind) {
  Params p;
  if (!std::strcmp(kind, "drag")) p.set("linear", 0.4), p.set("quadratic", 0.2);
  if (!std::strcmp(kind, "wind")) {
    p.set("velocity", std::vector<double>{3, 0, -1});
    p.set("gust", 0.5);
  }
  if (!std::strcmp(kind, "attractor")) {
    p.set("position", std::vector<double>{0.5, 0.25, -1});
    p.set("strength", 4.0);
    p.set("power", -1.3);
    p.set("softening", 0.1);
  }
  if (!std::strcmp(kind, "spring")) {
    p.set("position", std::vector<double>{0, 3, 0});
    p.set("rest_length", 1.0);
  }
  if (!std::strcmp(kind, "buoyancy")) p.set("height", 0.5);
  if (!std::strcmp(kind, "expression")) {
    p.set("x", std::string("-k*x + m*sin(t)*y"));
    p.set("y", std::string("-0.3*vy*abs(vx)"));
    p.set("k", 4.0);
  }
  return p;
}

std::vector<MassPoint> some_points(std::size_t n) {
  Rng rng(7);
  std::vector<MassPoint> points(n);
  for (MassPoint& p : points) {
    p.position = vec3(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2));
    p.velocity = vec3(rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-3, 3));
    p.mass = rng.uniform(Real(0.1), 2);
    p.area = Real(0.05);
    p.volume = Real(0.01);
  }
  return points;
}

Vec3 force_on(const Force& f, MassPoint p, double t = 0) {
  Vec3 out = Vec3::Zero();
  f.add(&p, 1, t, &out);
  return out;
}

std::unique_ptr<Force> make(const char* kind, const Params& p) {
  Arena arena("test");
  auto f = find_variant(force_kinds(), kind, "force kind").make(arena, p);
  p.check_all_read(kind);
  return f;
}

}  // namespace

TEST_CASE("forces are finite, additive and independent of company", "[forces][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(force_kinds().size())));
  const auto& kind = force_kinds()[static_cast<std::size_t>(row)];
  const bool defaults = GENERATE(false, true);
  CAPTURE(kind.name, defaults);
  const auto force = make(kind.name, defaults ? Params() : sample_options(kind.name));
  const std::vector<MassPoint> points = some_points(50);
  std::vector<Vec3> out(points.size(), Vec3(1, 2, 3));
  force->add(points.data(), points.size(), 1.5, out.data());
  Real largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 alone = force_on(*force, points[i], 1.5);
    CHECK(is_finite(out[i]));
    CHECK(length(out[i] - Vec3(1, 2, 3) - alone) <= Real(1e-5) * (4 + length(alone)));
    largest = std::max(largest, length(alone));
  }
  if (!defaults) CHECK(largest > 0);
  // extreme but finite places: at the origin at rest, far away, without mass
  for (const Real far : {Real(0), Real(1e4)}) {
    MassPoint p;
    p.position = vec3(far, -far, far);
    CHECK(is_finite(force_on(*force, p)));
    p.mass = 1;
    CHECK(is_finite(force_on(*force, p)));
    CHECK(std::isfinite(force->potential(&p, 1)));
  }
}

// With velocities +v and -v all but drag drops out of the difference.
TEST_CASE("drag takes most_drag times the velocity at most", "[forces][contract]") {
  const std::string kind = GENERATE("drag", "wind", "buoyancy");
  const Real most = GENERATE(Real(0), Real(0.5), Real(1e3));
  CAPTURE(kind, most);
  Params p;
  p.set(kind == "buoyancy" ? "drag" : "linear", 1e5);
  if (kind == "buoyancy") p.set("height", 100.0);
  const auto force = make(kind.c_str(), p);
  for (MassPoint point : some_points(20)) {
    point.most_drag = most;
    const Vec3 ahead = force_on(*force, point);
    point.velocity = -point.velocity;
    const Vec3 half = (force_on(*force, point) - ahead) / 2;
    CHECK(length(Vec3(half + most * point.velocity)) <= Real(1e-3) * (1 + most) * length(point.velocity));
  }
}

TEST_CASE("a force with a potential is its gradient at rest", "[forces][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(force_kinds().size())));
  const auto& kind = force_kinds()[static_cast<std::size_t>(row)];
  CAPTURE(kind.name);
  const auto force = make(kind.name, sample_options(kind.name));
  std::vector<MassPoint> points = some_points(50);
  if (force->potential(points.data(), points.size()) == 0) return;  // none
  for (MassPoint p : points) {
    p.velocity = Vec3::Zero();
    const Vec3 f = force_on(*force, p);
    for (int k = 0; k < 3; ++k) {
      MassPoint a = p, b = p;
      const Real e = Real(1) / 256;
      a.position[k] -= e, b.position[k] += e;
      const double width = static_cast<double>(b.position[k]) - static_cast<double>(a.position[k]);
      const double slope = -(force->potential(&b, 1) - force->potential(&a, 1)) / width;
      CHECK(static_cast<double>(f[k]) ==
            Approx(slope).epsilon(5e-3).margin(5e-3 * (1 + static_cast<double>(length(f)))));
    }
  }
}

TEST_CASE("gravity, spring and attractor follow their laws", "[forces]") {
  MassPoint p;
  p.mass = 2;
  p.position = vec3(3, 4, 0);

  Params gravity;
  gravity.set("acceleration", std::vector<double>{1, 0, -2});
  CHECK(length(force_on(*make("gravity", gravity), p) - Vec3(2, 0, -4)) < Real(1e-6));
  p.mass = 0;
  CHECK(force_on(*make("gravity", gravity), p) == Vec3(0, 0, 0));
  CHECK(force_on(*make("attractor", Params()), p) == Vec3(0, 0, 0));
  p.mass = 2;

  // distance 5: acceleration strength 5^power towards the origin
  const double power = GENERATE(-3.0, -2.0, -1.0, -0.5, 0.0, 1.0, 2.0, 0.37, -1.7);
  Params attractor;
  attractor.set("strength", 10.0);
  attractor.set("power", power);
  const double size = 2 * 10 * std::pow(5.0, power);
  const Vec3 f = force_on(*make("attractor", attractor), p);
  CHECK(static_cast<double>(f[0]) == Approx(-0.6 * size).epsilon(1e-6));
  CHECK(static_cast<double>(f[1]) == Approx(-0.8 * size).epsilon(1e-6));
  MassPoint centre;
  centre.mass = 1;
  CHECK(force_on(*make("attractor", attractor), centre) == Vec3(0, 0, 0));

  Params spring;
  spring.set("stiffness", 10.0);
  spring.set("rest_length", 2.0);
  spring.set("damping", 3.0);
  p.velocity = vec3(6, 8, 5);  // 10 outwards
  CHECK(length(force_on(*make("spring", spring), p) - Vec3(Real(-0.6), Real(-0.8), 0) * 60) < Real(1e-4));
}

TEST_CASE("wind vanishes for what moves with it and pushes what does not", "[forces]") {
  Params p;
  p.set("velocity", std::vector<double>{4, 0, 0});
  p.set("coefficient", 0.5);
  p.set("area", 2.0);
  const auto wind = make("wind", p);
  MassPoint m;
  m.mass = 1;
  CHECK(static_cast<double>(force_on(*wind, m)[0]) == Approx(0.5 * 1.2 * 0.5 * 2 * 16).epsilon(1e-6));
  m.velocity = vec3(4, 0, 0);
  CHECK(force_on(*wind, m) == Vec3(0, 0, 0));
  // gusts: by time alone, bounded by 1 + gust
  p.set("gust", 0.5);
  const auto gusty = make("wind", p);
  m.velocity = vec3(0, 0, 0);
  Real lo = kInfinity, hi = 0;
  for (int k = 0; k < 200; ++k) {
    const Real f = force_on(*gusty, m, 0.1 * k)[0];
    CHECK(f == force_on(*gusty, m, 0.1 * k)[0]);
    lo = std::min(lo, f), hi = std::max(hi, f);
  }
  CHECK(hi <= Real(9.6 * 2.25 * 1.0001));
  CHECK(hi > Real(9.6 * 1.8));
  CHECK(lo < Real(9.6 * 0.5));
}

TEST_CASE("buoyancy: nothing above, Archimedes below, half a ball at the surface", "[forces]") {
  Params p;
  p.set("height", 1.0);
  p.set("volume", 0.001);
  p.set("drag", 2.0);
  const auto water = make("buoyancy", p);
  MassPoint m;
  m.mass = 1;
  m.velocity = vec3(1, 0, 0);
  m.position = vec3(0, 2, 0);
  CHECK(force_on(*water, m) == Vec3(0, 0, 0));
  m.position = vec3(0, -5, 0);
  CHECK(length(force_on(*water, m) - Vec3(-2, Real(9.81), 0)) < Real(1e-4));
  m.position = vec3(0, 1, 0);
  CHECK(length(force_on(*water, m) - Vec3(-1, Real(4.905), 0)) < Real(1e-4));
}

TEST_CASE("force options are checked", "[forces]") {
  Params p;
  p.set("position", std::vector<double>{1, 2});
  CHECK_THROWS_AS(make("attractor", p), SceneError);
  Params q;
  q.set("strenght", 2.0);
  CHECK_THROWS_WITH(make("attractor", q), Catch::Contains("strength"));
  CHECK_THROWS_WITH(make("atractor", Params()), Catch::Contains("attractor"));
}

TEST_CASE("derivatives that a force tells agree with differences", "[forces][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(force_kinds().size())));
  const auto& kind = force_kinds()[static_cast<std::size_t>(row)];
  const bool by_velocity = GENERATE(false, true);
  CAPTURE(kind.name, by_velocity);
  const auto force = make(kind.name, sample_options(kind.name));
  const double h = sizeof(Real) == 4 ? 1e-2 : 1e-5;
  for (const MassPoint& p : some_points(5)) {
    Mat3 told = Mat3::Zero();
    if (!force->derivative(&p, 1, 0.7, by_velocity, &told)) return;
    for (int axis = 0; axis < 3; ++axis) {
      MassPoint above = p, below = p;
      (by_velocity ? above.velocity : above.position)[axis] += static_cast<Real>(h);
      (by_velocity ? below.velocity : below.position)[axis] -= static_cast<Real>(h);
      const Vec3 slope = (force_on(*force, above, 0.7) - force_on(*force, below, 0.7)) / static_cast<Real>(2 * h);
      CHECK(length(slope - told.col(axis)) <= Real(2e-2) * (1 + length(slope)));
    }
  }
}
