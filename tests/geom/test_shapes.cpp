// Closed forms of single shapes, and what their makers refuse.
#include "base/rng.h"
#include "feder/error.h"
#include "geom/hull.h"
#include "geom/polygon.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::vector<Vec3> box_corners(Real w, Real h, Real d) {
  std::vector<Vec3> p;
  for (int i = 0; i < 8; ++i) p.push_back(vec3(i & 1 ? w / 2 : -w / 2, i & 2 ? h / 2 : -h / 2, i & 4 ? d / 2 : -d / 2));
  return p;
}

void check_equal(const MassProperties& a, const MassProperties& b) {
  CHECK(a.mass == Approx(b.mass).epsilon(1e-5));
  CHECK((a.center - b.center).norm() < 1e-5);
  CHECK((a.inertia - b.inertia).norm() < 1e-5 * b.inertia.norm());
}

}  // namespace

TEST_CASE("closed forms of mass and inertia", "[geom]") {
  const MassProperties box = make_box(1, 2, 3)->mass(10);
  CHECK(box.mass == Approx(60));
  CHECK(box.inertia(0, 0) == Approx(60.0 / 12 * (4 + 9)));
  CHECK(box.inertia(1, 1) == Approx(60.0 / 12 * (1 + 9)));
  CHECK(box.inertia(2, 2) == Approx(60.0 / 12 * (1 + 4)));
  const double pi = 3.14159265358979;
  const MassProperties cylinder = make_cylinder(Real(0.5), 2)->mass(3);
  CHECK(cylinder.mass == Approx(3 * pi * 0.25 * 2));
  CHECK(cylinder.inertia(1, 1) == Approx(cylinder.mass * 0.125));
  CHECK(cylinder.inertia(0, 0) == Approx(cylinder.mass / 12 * (3 * 0.25 + 4)));
  const MassProperties cone = make_cone(Real(0.5), 2)->mass(3);
  CHECK(cone.mass == Approx(pi * 0.25 * 2));
  CHECK(cone.center[1] == Approx(-0.5));  // a quarter of the height over the base
  CHECK(cone.inertia(1, 1) == Approx(0.3 * cone.mass * 0.25));
  CHECK(cone.inertia(0, 0) == Approx(cone.mass * (0.15 * 0.25 + 3.0 / 80 * 4)));
  const MassProperties ball = make_sphere(2)->mass(1), round = make_capsule(2, 4)->mass(1);
  check_equal(round, ball);
  // unit tetrahedron at the origin: products of inertia m/20 * 1/... = density / 120, diagonal density / 30 about 0
  const Vec3 corner[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const MassProperties tetra = make_hull(corner)->mass(1);
  CHECK(tetra.mass == Approx(1.0 / 6));
  CHECK((tetra.center - vec3(Real(0.25), Real(0.25), Real(0.25))).norm() < 1e-6);
  CHECK(tetra.inertia(0, 0) == Approx(1.0 / 30 - 2.0 / 6 / 16).epsilon(1e-4));
  CHECK(tetra.inertia(0, 1) == Approx(-(1.0 / 120 - 1.0 / 6 / 16)).epsilon(1e-4));
}

TEST_CASE("a hull of box corners is the box", "[geom][hull]") {
  const Quat turn = from_axis_angle(vec3(1, 2, 3), Real(0.7));
  std::vector<Vec3> cloud = box_corners(1, 2, 3);
  // points on faces, on edges and inside change nothing
  Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    Vec3 p = vec3(rng.uniform(Real(-0.5), Real(0.5)), rng.uniform(-1, 1), rng.uniform(Real(-1.5), Real(1.5)));
    if (i % 2) p[1] = i % 4 == 1 ? Real(1) : Real(-1);
    if (i % 8 == 1) p[0] = Real(0.5);
    cloud.push_back(p);
  }
  for (const bool turned : {false, true}) {
    std::vector<Vec3> points = cloud;
    if (turned)
      for (Vec3& p : points) p = rotate(turn, p) + vec3(5, 6, 7);
    const HullData hull = build_hull(points);
    CAPTURE(turned);
    CHECK(hull.corners.size() == 8);
    REQUIRE(hull.faces.size() == 6);
    for (const HullFace& f : hull.faces) CHECK(f.count == 4);
    const MassProperties box = make_box(1, 2, 3)->mass(4);
    const Pose at = turned ? Pose{vec3(5, 6, 7), turn} : Pose{};
    check_equal(make_hull(points)->mass(4), transformed(box, at));
  }
}

TEST_CASE("random hulls hold their points and obey Euler", "[geom][hull]") {
  Rng rng(5);
  for (int trial = 0; trial < 60; ++trial) {
    const int count = 4 + static_cast<int>(rng.next() % 150);
    const Real scale = std::pow(Real(10), rng.uniform(-4, 4)), squash = trial % 3 ? Real(1) : Real(0.01);
    std::vector<Vec3> cloud;
    for (int i = 0; i < count; ++i) {
      Vec3 p = vec3(rng.uniform(-1, 1), rng.uniform(-1, 1) * squash, rng.uniform(-1, 1));
      if (trial % 4 == 0)
        for (int k = 0; k < 3; ++k) p[k] = std::round(p[k] * 4 / (k == 1 ? squash : 1)) / 4 * (k == 1 ? squash : 1);
      cloud.push_back(p * scale);
    }
    if (trial % 4 == 0)
      for (const Vec3& c : box_corners(2, 2 * squash, 2)) cloud.push_back(c * scale);
    CAPTURE(trial, count, scale, squash);
    HullData hull;
    try {
      hull = build_hull(cloud);
    } catch (const SceneError&) {
      CHECK(count < 6);  // only a handful of points can be flat by chance
      continue;
    }
    int sides = 0;
    for (const HullFace& f : hull.faces) {
      sides += f.count;
      CHECK(length(f.normal) == Approx(1).margin(1e-4));
      Real highest = -kInfinity;
      for (const Vec3& p : cloud) highest = std::max(highest, dot(f.normal, p));
      CHECK(highest - f.offset <= 1e-4 * scale);
    }
    CHECK(static_cast<int>(hull.corners.size()) - sides / 2 + static_cast<int>(hull.faces.size()) == 2);
  }
}

TEST_CASE("degenerate hulls are refused with a reason", "[geom][hull]") {
  const auto refused = [](std::vector<Vec3> p, const char* why) {
    try {
      make_hull(p);
    } catch (const SceneError& e) {
      CAPTURE(e.what());
      return std::string(e.what()).find(why) != std::string::npos;
    }
    return false;
  };
  CHECK(refused({}, "at least 4"));
  CHECK(refused({vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)}, "at least 4"));
  CHECK(refused(std::vector<Vec3>(10, vec3(1, 2, 3)), "same"));
  std::vector<Vec3> line, plane, sphere;
  Rng rng(3);
  for (int i = 0; i < 30; ++i) {
    line.push_back(vec3(1, 2, 3) * Real(i));
    plane.push_back(vec3(1, 2, 3) * rng.uniform(-1, 1) + vec3(-2, 0, 1) * rng.uniform(-1, 1));
  }
  CHECK(refused(line, "line"));
  CHECK(refused(plane, "plane"));
  plane.push_back(vec3(0, kInfinity, 0));
  CHECK(refused(plane, "point 31"));
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    sphere.push_back(p / length(p));
  }
  CHECK(refused(sphere, "at most 256"));
}

TEST_CASE("sizes that are no sizes are refused", "[geom]") {
  const Real bad = GENERATE(Real(0), Real(-1), kInfinity, std::numeric_limits<Real>::quiet_NaN());
  CHECK_THROWS_AS(make_sphere(bad), SceneError);
  CHECK_THROWS_AS(make_box(1, bad, 1), SceneError);
  CHECK_THROWS_AS(make_capsule(bad, 1), SceneError);
  CHECK_THROWS_AS(make_capsule(1, bad), SceneError);
  CHECK_THROWS_AS(make_cylinder(1, bad), SceneError);
  CHECK_THROWS_AS(make_cone(bad, 1), SceneError);
  CHECK_THROWS_AS(make_circle(bad), SceneError);
  CHECK_THROWS_AS(make_plane(Vec3::Zero(), 1), SceneError);
  CHECK_THROWS_AS(make_capsule(1, Real(1.9)), SceneError);
  const Vec2 flat[3] = {{0, 0}, {1, 1}, {2, 2}};
  CHECK_THROWS_AS(make_polygon(flat), SceneError);
  CHECK_THROWS_AS(make_compound({}), SceneError);
  const Vec3 v[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::uint32_t line[3] = {0, 1, 2}, outside[3] = {0, 1, 3};
  CHECK_THROWS_AS(make_mesh(v, line), SceneError);
  CHECK_THROWS_AS(make_mesh(v, outside), SceneError);
  CHECK_THROWS_AS(make_mesh(v, {line, 2}), SceneError);
}

TEST_CASE("a plane is solid below, whatever its normal's length", "[geom]") {
  const ShapePtr plane = make_plane(vec3(0, 2, 0), 3);  // y <= 1.5
  RayHit hit;
  REQUIRE(plane->raycast(vec3(0, Real(2.5), 0), vec3(0, -4, 1), hit));
  CHECK(hit.fraction == Approx(0.25));
  CHECK(hit.normal == vec3(0, 1, 0));
  CHECK_FALSE(plane->raycast(vec3(0, Real(2.5), 0), vec3(0, Real(-0.5), 1), hit));
  CHECK_FALSE(plane->raycast(vec3(0, Real(2.5), 0), vec3(1, 0, 0), hit));
  REQUIRE(plane->raycast(vec3(0, 1, 0), vec3(0, 1, 0), hit));
  CHECK(hit.fraction == 0);
  CHECK(plane->bounds({vec3(0, 1, 0), {}}).hi[1] == Approx(2.5));
  CHECK(plane->bounds({}).lo[1] == -kInfinity);
}

TEST_CASE("mesh rays equal the nearest of all triangles", "[geom][mesh]") {
  Rng rng(8);
  std::vector<Vec3> v;
  std::vector<std::uint32_t> t;
  for (std::uint32_t i = 0; i < 300; ++i) {
    v.push_back(vec3(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2)));
    if (i >= 2) t.insert(t.end(), {i - 2, i - 1, i});
  }
  const ShapePtr mesh = make_mesh(v, t);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 o = vec3(rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(-4, 4)), d = -o * rng.uniform(Real(0.5), 2);
    double best = 2;
    for (std::uint32_t k = 0; k < 298; ++k) {
      // signed volumes: the line passes inside all three edges
      const Triangle tri = mesh->triangle(k);
      const Vec3 n = cross(tri.b - tri.a, tri.c - tri.a);
      const double down = dot(n, d), s = dot(n, tri.a - o) / down;
      const Vec3 p = o + Real(s) * d;
      const bool in = dot(cross(tri.b - tri.a, p - tri.a), n) > 0 && dot(cross(tri.c - tri.b, p - tri.b), n) > 0 &&
                      dot(cross(tri.a - tri.c, p - tri.c), n) > 0;
      if (in && s >= 0 && s < best) best = s;
    }
    RayHit hit;
    const bool found = mesh->raycast(o, d, hit);
    CAPTURE(i, best);
    if (std::abs(best - 1) > 1e-4) CHECK(found == (best < 1));
    if (found && best < 1) CHECK(hit.fraction == Approx(best).margin(1e-4));
    hits += found;
  }
  CHECK(hits > 100);
}

TEST_CASE("mesh edges know flat, ridge, valley and border", "[geom][mesh]") {
  const Real height = GENERATE(Real(0), Real(0.5), Real(-0.5));
  // two triangles with the edge (0,0,0)-(0,0,1); the far corner of the second at `height`
  const Vec3 v[4] = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, height, 0}};
  const std::uint32_t t[6] = {0, 1, 2, 0, 3, 1};
  const ShapePtr mesh = make_mesh(v, t);
  int shared = 0;
  for (std::uint32_t i = 0; i < 2; ++i) {
    const Triangle tri = mesh->triangle(i);
    for (int k = 0; k < 3; ++k) {
      const bool front = tri.flat_edges >> k & 1, back = tri.flat_edges >> (3 + k) & 1;
      if (tri.edge_cosine[k] < 0) {
        CHECK_FALSE(front);
        CHECK_FALSE(back);
        continue;
      }
      ++shared;
      CHECK(front == (height >= 0));
      CHECK(back == (height <= 0));
      CHECK(tri.edge_cosine[k] == Approx(1 / std::sqrt(1 + height * height)));
    }
  }
  CHECK(shared == 2);
}
