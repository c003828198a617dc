// The contract of feder/shape.h for every kind of shape. A new kind is enrolled by its line alone.
#include "direction.h"
#include "feder/error.h"
#include "feder/shape.h"
#include "support/catch.h"

using namespace feder;

namespace {

Pose pose(Rng& rng, bool planar) {
  const Quat q = from_axis_angle(planar ? vec3(0, 0, 1) : random_direction(rng, false), rng.uniform(-3, 3));
  return {random_direction(rng, planar) * 3, q};
}

// Height of the rounded surface along the unit vector u.
Real reach(const Shape& s, const Vec3& u) { return dot(u, s.support(u)) + s.radius(); }

// A ray without length hits exactly where it starts inside.
bool inside(const Shape& s, const Vec3& p) {
  RayHit hit;
  return s.raycast(p, Vec3::Zero(), hit);
}

bool solid(const Shape& s) { return s.mass(1).mass > 0; }

template <class Check>
void for_samples(const Check& check) {
  const int kind = GENERATE(range(0, static_cast<int>(shape_kinds().size())));
  for (const ShapePtr& s : shape_kinds()[static_cast<std::size_t>(kind)].samples()) {
    const Real size = solid(*s) ? s->extent(Vec3::Zero()) : Real(1);
    CAPTURE(s->kind(), size);
    Rng rng(static_cast<std::uint64_t>(kind) + 17);
    check(*s, size, rng);
  }
}

}  // namespace

TEST_CASE("kinds know their row", "[geom][contract]") {
  for_samples([](const Shape& s, Real, Rng&) {
    CHECK(s.kind_id() == shape_kind_id(s.kind()));
    const ShapeKind& kind = shape_kinds()[static_cast<std::size_t>(s.kind_id())];
    CHECK(kind.name == std::string(s.kind()));
    CHECK(kind.traits.convex == s.convex());
    CHECK(kind.traits.planar == s.planar());
    CHECK(kind.traits.whole == s.parts().empty());
  });
}

namespace {

// Bit for bit: the same answers to the same questions.
void check_same(const Shape& a, const Shape& b, Rng& rng) {
  REQUIRE(a.kind_id() == b.kind_id());
  CHECK((a.radius() == b.radius() && a.planar() == b.planar() && a.parts().size() == b.parts().size()));
  CHECK(a.mass(700).mass == b.mass(700).mass);
  CHECK(a.mass(700).inertia == b.mass(700).inertia);
  for (int k = 0; k < 40; ++k) {
    const Vec3 d = random_direction(rng, a.planar()), p = 4 * random_direction(rng, a.planar());
    Vec3 m, n, at[kMaxFacePoints], bt[kMaxFacePoints];
    CHECK(a.distance(p, 100, m) == b.distance(p, 100, n));
    CHECK(m == n);
    RayHit g, h;
    CHECK(a.raycast(p, Vec3(-8 * d), g) == b.raycast(p, Vec3(-8 * d), h));
    CHECK((g.fraction == h.fraction && g.normal == h.normal));
    const Pose q = pose(rng, a.planar());
    CHECK((a.bounds(q).lo == b.bounds(q).lo && a.bounds(q).hi == b.bounds(q).hi));
    if (!a.convex()) continue;
    CHECK(a.support(d) == b.support(d));
    const int count = a.face(d, at);
    REQUIRE(count == b.face(d, bt));
    for (int i = 0; i < count; ++i) CHECK(at[i] == bt[i]);
  }
  std::vector<std::uint32_t> found[2];
  const auto list = [](void* to, std::uint32_t i) { static_cast<std::vector<std::uint32_t>*>(to)->push_back(i); };
  const Aabb some{vec3(-2, -2, -2), vec3(Real(0.5), 2, 2)};
  a.triangles_in(some, list, &found[0]), b.triangles_in(some, list, &found[1]);
  CHECK(found[0] == found[1]);
  for (const std::uint32_t i : found[0]) {
    const Triangle s = a.triangle(i), t = b.triangle(i);
    CHECK((s.a == t.a && s.b == t.b && s.c == t.c && s.flat_edges == t.flat_edges));
  }
}

}  // namespace

TEST_CASE("a shape is made again from its arguments, to the last bit", "[geom][contract]") {
  for_samples([](const Shape& s, Real, Rng& rng) {
    const ShapeArguments arguments = s.arguments();
    check_same(s, *make_shape(s.kind(), arguments.input()), rng);
  });
  Rng rng(5);
  const auto again = [&](const ShapePtr& s) {
    const ShapeArguments arguments = s->arguments();
    check_same(*s, *make_shape(s->kind(), arguments.input()), rng);
  };
  for (int k = 0; k < 60; ++k) {
    std::vector<Vec3> points, flat;
    std::vector<Vec2> plane;
    for (int i = 0; i < 24; ++i) points.push_back(random_direction(rng, false) * rng.uniform(Real(0.2), 1));
    for (int i = 0; i < 12; ++i) plane.emplace_back(rng.uniform(-1, 1), rng.uniform(-1, 1));
    std::vector<std::uint32_t> triangles;
    for (int i = 0; i < 90; ++i) triangles.push_back(static_cast<std::uint32_t>(rng.uniform(0, Real(23.9))));
    again(make_hull(points)), again(make_polygon(plane, k % 2 ? Real(0.1) : Real(0))),
        again(make_mesh(points, triangles));
    again(make_plane(3 * points[0], points[1][0]));
    const Real r = rng.uniform(Real(0.01), 3);
    again(make_capsule(r, r * rng.uniform(2, 5)));
    again(make_compound({{make_hull(points), {points[2], {points[3][0], points[3][1], points[3][2], Real(0.3)}}}}));
  }
}

TEST_CASE("bounds hold the supports and touch them", "[geom][contract]") {
  for_samples([](const Shape& s, Real size, Rng& rng) {
    if (!s.convex()) return;
    for (int i = 0; i < 50; ++i) {
      const Pose p = pose(rng, s.planar());
      Aabb box = s.bounds(p);
      const Real slack = Real(1e-5) * (size + 3);
      for (int k = 0; k < (s.planar() ? 2 : 3); ++k) {
        for (const Real sign : {Real(-1), Real(1)}) {
          Vec3 axis = Vec3::Zero();
          axis[k] = sign;
          const Vec3 far = to_world(p, s.support(rotate_inverse(p.rotation, axis))) + axis * s.radius();
          CHECK((sign > 0 ? box.hi : box.lo)[k] == Approx(far[k]).margin(slack));
        }
      }
    }
  });
}

TEST_CASE("the extent is the farthest support", "[geom][contract]") {
  for_samples([](const Shape& s, Real size, Rng& rng) {
    if (!s.convex()) return;
    for (int i = 0; i < 5; ++i) {
      const Vec3 center = random_direction(rng, s.planar()) * (size * rng.uniform(0, 1));
      Real far = 0;
      for (int k = 0; k < 3000; ++k) {
        const Vec3 u = random_direction(rng, s.planar());
        const Vec3 core = s.support(u) - center;
        far = std::max(far, length(core) + s.radius());
      }
      CHECK(far <= s.extent(center) * Real(1.00001));
      CHECK(far >= s.extent(center) * Real(0.97));
    }
  });
}

TEST_CASE("mass, centre and inertia equal a sum over small cells", "[geom][contract]") {
  for_samples([](const Shape& s, Real size, Rng&) {
    if (!solid(s)) return;
    const MassProperties m = s.mass(Real(2.5));
    const Aabb box = s.bounds({});
    // unequal counts: cell centres that lie exactly on a slanted face would all fall on one side of it
    const int nx = s.planar() ? 400 : 72, ny = s.planar() ? 391 : 71, nz = s.planar() ? 1 : 67;
    const double dx = (box.hi[0] - box.lo[0]) / Real(nx), dy = (box.hi[1] - box.lo[1]) / Real(ny);
    const double dz = s.planar() ? 1 : (box.hi[2] - box.lo[2]) / Real(nz);
    double volume = 0, first[3] = {}, second[3][3] = {};
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j)
        for (int k = 0; k < nz; ++k) {
          const double p[3] = {box.lo[0] + (i + 0.5) * dx, box.lo[1] + (j + 0.5) * dy,
                               s.planar() ? 0 : box.lo[2] + (k + 0.5) * dz};
          if (!inside(s, vec3(Real(p[0]), Real(p[1]), Real(p[2])))) continue;
          volume += 1;
          for (int a = 0; a < 3; ++a) {
            first[a] += p[a];
            for (int b = 0; b < 3; ++b) second[a][b] += p[a] * p[b];
          }
        }
    const double cell = 2.5 * dx * dy * dz, mass = volume * cell;
    CHECK(m.mass == Approx(mass).epsilon(0.01));
    Mat3 c = Mat3::Zero();  // I = tr(C) 1 - C
    for (int a = 0; a < 3; ++a) {
      CHECK(m.center[a] == Approx(first[a] / volume).margin(0.005 * size));
      for (int b = 0; b < 3; ++b) c(a, b) = Real(cell * (second[a][b] - first[a] * first[b] / volume));
    }
    const Mat3 expected = c.trace() * Mat3::Identity() - c;
    const Real tolerance = Real(0.015) * expected.trace();
    for (int a = s.planar() ? 2 : 0; a < 3; ++a)
      for (int b = s.planar() ? 2 : 0; b < 3; ++b) CHECK(m.inertia(a, b) == Approx(expected(a, b)).margin(tolerance));
  });
}

TEST_CASE("principal moments can belong to a body", "[geom][contract]") {
  for_samples([](const Shape& s, Real, Rng&) {
    if (!solid(s)) return;
    const MassProperties m = s.mass(7);
    CHECK((m.inertia - m.inertia.transpose()).norm() <= 1e-5 * m.inertia.norm());
    Vec3 values;
    Mat3 axes;
    eigen_symmetric(m.inertia, values, axes);
    CHECK(values[0] > 0);
    CHECK(values[2] <= (values[0] + values[1]) * Real(1.0001));
    CHECK(s.mass(14).mass == Approx(2 * m.mass));
  });
}

TEST_CASE("faces lie on the surface and turn counter-clockwise", "[geom][contract]") {
  for_samples([](const Shape& s, Real size, Rng& rng) {
    if (!s.convex()) return;
    const Real slack = Real(2e-5) * size;
    for (int i = 0; i < 200; ++i) {
      const Vec3 d = random_direction(rng, s.planar());
      Vec3 p[kMaxFacePoints];
      const int count = s.face(d, p);
      REQUIRE(count >= 1);
      REQUIRE(count <= kMaxFacePoints);
      for (int k = 0; k < count; ++k) {
        const Vec3 u = random_direction(rng, s.planar());
        CHECK(dot(u, p[k]) <= dot(u, s.support(u)) + slack);
      }
      if (count == 1) CHECK(dot(d, p[0]) == Approx(dot(d, s.support(d))).margin(slack));
      if (count < 3) continue;
      Vec3 n = Vec3::Zero();
      for (int k = 2; k < count; ++k) n += cross(p[k - 1] - p[0], p[k] - p[0]);
      n /= length(n);
      CHECK(dot(n, d) > 0);
      const Real height = dot(n, s.support(n));
      for (int k = 0; k < count; ++k) CHECK(dot(n, p[k]) == Approx(height).margin(slack));
    }
  });
}

TEST_CASE("rays end on the surface", "[geom][contract]") {
  for_samples([](const Shape& s, Real size, Rng& rng) {
    if (!solid(s)) return;
    const Vec3 middle = s.mass(1).center;
    const Real slack = Real(2e-4) * size;
    int hits = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec3 origin = middle + random_direction(rng, s.planar()) * (size * rng.uniform(Real(1.5), 4));
      const Vec3 target = middle + random_direction(rng, s.planar()) * (size * rng.uniform(0, Real(1.2)));
      const Vec3 ray = (target - origin) * rng.uniform(Real(0.5), 3);
      if (inside(s, origin)) continue;
      RayHit hit;
      const bool found = s.raycast(origin, ray, hit);
      const Real last = found ? hit.fraction : Real(1);
      for (int k = 0; k < 40; ++k) {
        const Real t = last * (Real(k) + Real(0.5)) / 40;
        if (t * length(ray) < last * length(ray) - slack) CHECK_FALSE(inside(s, origin + t * ray));
      }
      if (!found) continue;
      ++hits;
      const Vec3 p = origin + hit.fraction * ray;
      CHECK(hit.fraction >= 0);
      CHECK(hit.fraction <= 1);
      CHECK(length(hit.normal) == Approx(1).margin(1e-4));
      CHECK(dot(hit.normal, ray) <= Real(1e-4) * length(ray));
      CHECK_FALSE(inside(s, p + hit.normal * slack));
      if (s.convex()) CHECK(dot(hit.normal, p) == Approx(reach(s, hit.normal)).margin(slack));
    }
    CHECK(hits > 20);
    RayHit hit;
    if (s.convex()) {
      REQUIRE(s.raycast(middle, vec3(size, 0, 0), hit));
      CHECK(hit.fraction == 0);
      CHECK(hit.normal == Vec3(Vec3::Zero()));
    }
  });
}

TEST_CASE("2D sections stay in their plane", "[geom][contract]") {
  for_samples([](const Shape& s, Real size, Rng& rng) {
    ShapePtr flat;
    try {
      flat = s.section();
    } catch (const SceneError&) {
      CHECK_FALSE(s.convex());
      return;
    }
    if (!flat->convex()) return;
    CHECK(flat->planar());
    for (int i = 0; i < 50; ++i) {
      const Vec3 u = random_direction(rng, true);
      CHECK(flat->support(u)[2] == 0);
      CHECK(reach(*flat, u) == Approx(reach(s, u)).margin(1e-5 * size));
    }
  });
}
