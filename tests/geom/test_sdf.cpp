// Signed distance fields against closed forms: error, slope, closest point and sign by the distance q to the medial
// axis or the nearest sharp edge; the three ways to acquire them; bad input.
#include <limits>

#include "base/rng.h"
#include "feder/error.h"
#include "feder/sdf.h"
#include "geom/isosurface.h"
#include "geom/sdf.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A solid with its exact distance; `q`: how far p is from where the distance has no slope.
struct Solid {
  const char* name;
  Vec3 half;  // of the box
  double (*distance)(double x, double y, double z);
  double (*q)(double x, double y, double z);
};

double hypot3(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }
double box_distance(double x, double y, double z, double a, double b, double c) {
  const double dx = std::abs(x) - a, dy = std::abs(y) - b, dz = std::abs(z) - c;
  return hypot3(std::max(dx, 0.0), std::max(dy, 0.0), std::max(dz, 0.0)) + std::min(std::max({dx, dy, dz}), 0.0);
}
// Of a box: to the planes where two faces are equally near inside, and to its edges outside.
double box_q(double x, double y, double z, double a, double b, double c) {
  double d[3] = {a - std::abs(x), b - std::abs(y), c - std::abs(z)};  // to the faces, inside
  std::sort(d, d + 3);
  if (d[0] > 0) return std::min({(d[1] - d[0]) / std::sqrt(2.0), std::abs(x) + d[0] * 0, 10.0});
  // outside: the regions' borders are no kinks of value but of curvature; the edges are sharp
  const double dx = std::abs(x) - a, dy = std::abs(y) - b, dz = std::abs(z) - c;
  const double ex[3] = {dx, dy, dz};
  double nearest = 1e9;
  for (int k = 0; k < 3; ++k) {  // edge along axis k
    const double u = ex[(k + 1) % 3], v = ex[(k + 2) % 3], w = std::max(ex[k], 0.0);
    nearest = std::min(nearest, hypot3(u, v, w));
  }
  return nearest;
}
double torus_distance(double x, double y, double z) {
  const double r = std::sqrt(x * x + z * z) - 1;
  return std::sqrt(r * r + y * y) - 0.3;
}
double cylinder_distance(double x, double y, double z) {
  const double r = std::sqrt(x * x + z * z) - 0.5, h = std::abs(y) - 0.8;
  return std::sqrt(std::max(r, 0.0) * std::max(r, 0.0) + std::max(h, 0.0) * std::max(h, 0.0)) +
         std::min(std::max(r, h), 0.0);
}
double sphere_at(double x, double y, double z, double cx) { return hypot3(x - cx, y, z) - 0.5; }

// Of two balls; inside also to the circle of radius .3 where they meet.
double union_distance(double x, double y, double z) {
  const double d = std::min(sphere_at(x, y, z, -0.4), sphere_at(x, y, z, 0.4));
  if (d > 0) return d;
  // the ball's own nearest point counts where it is not in the other
  const double c = x > 0 ? 0.4 : -0.4, r = hypot3(x - c, y, z);
  const double on = r > 0 ? c + (x - c) / r * 0.5 : c;
  const double rho = std::sqrt(y * y + z * z) - 0.3, ring = -std::sqrt(x * x + rho * rho);
  return on * c >= 0 ? std::max(d, ring) : ring;
}

const Solid kSolids[] = {
    {"sphere", vec3(1, 1, 1), [](double x, double y, double z) { return hypot3(x, y, z) - 1; },
     [](double x, double y, double z) { return hypot3(x, y, z); }},
    {"box", vec3(Real(0.8), Real(0.5), Real(0.6)),
     [](double x, double y, double z) { return box_distance(x, y, z, 0.8, 0.5, 0.6); },
     [](double x, double y, double z) { return box_q(x, y, z, 0.8, 0.5, 0.6); }},
    {"torus", vec3(Real(1.3), Real(0.3), Real(1.3)), torus_distance,
     [](double x, double y, double z) {
       const double axis = std::sqrt(x * x + z * z);
       return std::min(axis, std::sqrt((axis - 1) * (axis - 1) + y * y));
     }},
    {"cylinder", vec3(Real(0.5), Real(0.8), Real(0.5)), cylinder_distance,
     [](double x, double y, double z) {
       const double axis = std::sqrt(x * x + z * z), r = axis - 0.5, h = std::abs(y) - 0.8;
       if (r < 0 && h < 0) return std::min({axis, std::abs(r - h) / std::sqrt(2.0), std::abs(h + 0.8)});
       return std::min(axis, std::sqrt(r * r + h * h));
     }},
    {"union", vec3(Real(0.9), Real(0.5), Real(0.5)), union_distance,
     [](double x, double y, double z) {
       const double rho = std::sqrt(y * y + z * z);
       return std::min({std::abs(x), hypot3(x - 0.4, y, z), hypot3(x + 0.4, y, z),
                        std::sqrt(x * x + (rho - 0.3) * (rho - 0.3)), rho + 0.05});
     }},
};

ShapePtr field_of(const Solid& s, Real h, bool adaptive) {
  SdfDesc d;
  d.function = s.distance;
  // no face of a solid lies on corners of the grid
  d.size = 2 * s.half + Vec3::Constant(8 * h), d.spacing = h, d.adaptive = adaptive;
  return make_sdf(d);
}

}  // namespace

TEST_CASE("a field of distances is off by no more than its spacing allows", "[geom][sdf]") {
  const bool adaptive = GENERATE(false, true);
  const Real h = Real(0.04);
  for (const Solid& solid : kSolids) {
    const ShapePtr shape = field_of(solid, h, adaptive);
    Rng rng(7);
    double worst = 0, worst_slope = 0, worst_point = 0, worst_else = 0;  // of what is allowed
    int regular = 0, others = 0;
    for (int i = 0; i < 40000; ++i) {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = rng.uniform(-1, 1) * (solid.half[k] + 3 * h);
      const double x = double(p[0]), y = double(p[1]), z = double(p[2]), exact = solid.distance(x, y, z);
      if (adaptive && std::abs(exact) > double(h)) continue;  // coarser there
      const double q = solid.q(x, y, z);
      Vec3 n;
      const double d = double(shape->distance(p, kInfinity, n));
      const double error = std::abs(d - exact), hh = double(h);
      if (std::abs(exact) > 0.9 * hh) REQUIRE((d < 0) == (exact < 0));
      if (q < 3 * hh) {
        worst_else = std::max(worst_else, error / (0.9 * hh)), ++others;
        continue;
      }
      ++regular;
      worst = std::max(worst, error / (1.1 * hh * hh / (4 * q)));
      if (std::abs(exact) > 4 * hh) continue;
      const Vec3 on = p - Real(d) * n;
      worst_point = std::max(worst_point,
                             std::abs(solid.distance(double(on[0]), double(on[1]), double(on[2]))) / (3 * hh * hh / q));
      // the slope itself, not made a unit
      const double e = 1e-3 * hh;
      Vec3 unused;
      double slope = 0;
      for (int k = 0; k < 3; ++k) {
        Vec3 step = Vec3::Zero();
        step[k] = Real(e);
        const double difference =
            double(shape->distance(p + step, kInfinity, unused)) - double(shape->distance(p - step, kInfinity, unused));
        slope += difference * difference / (4 * e * e);
      }
      worst_slope = std::max(worst_slope, std::abs(std::sqrt(slope) - 1) / (0.7 * hh / q + 4e-3));
    }
    CAPTURE(solid.name, adaptive, regular, others);
    CHECK(regular > (adaptive ? 2000 : 10000));
    CHECK(worst <= 1);
    CHECK(worst_else <= 1);
    CHECK(worst_slope <= 1);
    CHECK(worst_point <= 1);
    const SdfReport r = *sdf_report(*shape);
    CHECK((r.error > 0 && r.error < Real(0.9) * h && r.adaptive == adaptive && r.warnings.empty()));
  }
}

namespace {

struct Triangles {
  std::vector<Vec3> vertices;
  std::vector<std::uint32_t> corners;
};

// The surface of a solid, by marching cubes much finer than the fields.
Triangles triangulated(const Solid& s, Real h) {
  IsoGrid grid{-s.half - Vec3::Constant(3 * h), h, {}};
  for (int k = 0; k < 3; ++k) grid.n[k] = 7 + static_cast<int>(std::ceil(2 * s.half[k] / h));
  std::vector<Real> values;
  for (int z = 0; z < grid.n[2]; ++z)
    for (int y = 0; y < grid.n[1]; ++y)
      for (int x = 0; x < grid.n[0]; ++x)
        values.push_back(Real(
            -s.distance(double(grid.coordinate(0, x)), double(grid.coordinate(1, y)), double(grid.coordinate(2, z)))));
  IsoMesh mesh;
  IsoSurface iso;
  iso.extract(grid, values, 0, false, mesh);
  return {mesh.vertices, mesh.triangles};
}

SdfDesc of_mesh(const Triangles& t, Real h, SdfAcquire how = SdfAcquire::exact) {
  SdfDesc d;
  d.vertices = t.vertices, d.triangles = t.corners, d.spacing = h, d.acquire = how;
  return d;
}

}  // namespace

TEST_CASE("the three ways to acquire a field agree within half a cell", "[geom][sdf][heavy]") {
  const Real h = Real(0.05);
  for (const Solid& solid : kSolids) {
    const Triangles mesh = triangulated(solid, Real(0.031));
    std::vector<ShapePtr> fields;
    for (const SdfAcquire how : {SdfAcquire::exact, SdfAcquire::rasterise, SdfAcquire::rays})
      fields.push_back(make_sdf(of_mesh(mesh, h, how)));
    Rng rng(3);
    double worst = 0, wrong = 0;
    for (int i = 0; i < 20000; ++i) {
      Vec3 p, n;
      for (int k = 0; k < 3; ++k) p[k] = rng.uniform(-1, 1) * (solid.half[k] + 2 * h);
      const double first = double(fields[0]->distance(p, kInfinity, n));
      for (const ShapePtr& f : fields)
        worst = std::max(worst, std::abs(double(f->distance(p, kInfinity, n)) - first) / double(h));
      const double exact = solid.distance(double(p[0]), double(p[1]), double(p[2]));
      wrong = std::max(wrong, std::abs(first - exact));
    }
    CAPTURE(solid.name);
    CHECK(worst <= 0.5);
    CHECK(wrong <= 0.9 * double(h));
  }
}

TEST_CASE("a torus from a function has its mass and inertia", "[geom][sdf]") {
  SdfDesc d;
  d.function = [](double x, double y, double z) {
    const double r = std::sqrt(x * x + z * z) - 1;
    return std::sqrt(r * r + y * y) - 0.2;
  };
  d.size = vec3(Real(2.8), Real(0.8), Real(2.8)), d.spacing = Real(0.04);
  const MassProperties m = make_sdf(d)->mass(1000);
  const double mass = 2 * 9.8696044010893586 * 0.04 * 1000;
  CHECK(double(m.mass) == Approx(mass).epsilon(0.01));
  CHECK(double(m.inertia(1, 1)) == Approx(mass * (1 + 0.75 * 0.04)).epsilon(0.01));
  CHECK(double(m.inertia(0, 0)) == Approx(mass * (0.5 + 0.625 * 0.04)).epsilon(0.01));
  CHECK(length(m.center) < Real(1e-4));
}

TEST_CASE("the least that a distance can be is no more than it", "[geom][sdf]") {
  const Real h = Real(0.04);
  for (const Solid& solid : kSolids) {
    const ShapePtr shape = field_of(solid, h, GENERATE(false, true));
    const DistanceField& field = static_cast<const Sdf&>(*shape).field();
    Rng rng(11);
    Real above = -1, loose = 0;  // in spacings; as a share of the distance
    for (int i = 0; i < 20000; ++i) {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = rng.uniform(-1, 1) * (solid.half[k] + 1);
      const Real least = field.at_least(p), d = field.at(p);
      above = std::max(above, (least - d) / h);
      if (d > 4 * h) loose = std::max(loose, (d - least) / d);
      const Real limit = rng.uniform(0, 1), within = field.within(p, limit);
      CHECK((within == d || (within > limit && within == least)));
    }
    CAPTURE(solid.name, above, loose);
    CHECK(above < Real(0.1));
    CHECK(loose < Real(0.5));
  }
}

TEST_CASE("what is no distance is measured anew from where it is zero", "[geom][sdf]") {
  SdfDesc d;
  d.function = [](double x, double y, double z) { return 5 * (x * x + 4 * y * y + z * z - 1); };  // an ellipsoid
  d.size = vec3(Real(2.4), Real(1.4), Real(2.4)), d.spacing = Real(0.03);
  const ShapePtr shape = make_sdf(d);
  Vec3 n;
  CHECK(double(shape->distance(vec3(0, Real(0.6), 0), kInfinity, n)) == Approx(0.1).margin(0.004));
  CHECK(double(shape->distance(vec3(Real(1.1), 0, 0), kInfinity, n)) == Approx(0.1).margin(0.004));
  CHECK(double(shape->distance(vec3(0, Real(0.4), 0), kInfinity, n)) == Approx(-0.1).margin(0.004));
  CHECK(double(shape->mass(1).mass) == Approx(4.0 / 3 * 3.14159265 * 0.5).epsilon(0.01));
}

TEST_CASE("fields joined, cut and grown", "[geom][sdf]") {
  SdfDesc d;
  d.shape = make_sphere(Real(0.5)), d.spacing = Real(0.03);
  const ShapePtr ball = make_sdf(d);
  const Pose aside{vec3(Real(0.6), 0, 0), {}};
  const auto volume = [](const ShapePtr& s) { return double(s->mass(1).mass); };
  const double pi = 3.14159265358979, whole = pi / 6;
  const double lens = pi * (4 * 0.5 + 0.6) * (2 * 0.5 - 0.6) * (2 * 0.5 - 0.6) / 12;
  CHECK(volume(ball) == Approx(whole).epsilon(0.003));
  CHECK(volume(sdf_union(*ball, *ball, aside)) == Approx(2 * whole - lens).epsilon(0.01));
  CHECK(volume(sdf_subtract(*ball, *ball, aside)) == Approx(whole - lens).epsilon(0.01));
  CHECK(volume(sdf_intersect(*ball, *ball, aside)) == Approx(lens).epsilon(0.02));
  CHECK(volume(sdf_offset(*ball, Real(0.1))) == Approx(pi / 6 * 1.2 * 1.2 * 1.2).epsilon(0.01));
  CHECK(volume(sdf_offset(*ball, Real(-0.1))) == Approx(pi / 6 * 0.8 * 0.8 * 0.8).epsilon(0.01));
  CHECK_THROWS_WITH(sdf_offset(*ball, -1), Catch::Contains("nothing is left"));
  CHECK_THROWS_WITH(sdf_intersect(*ball, *ball, Pose{vec3(3, 0, 0), {}}), Catch::Contains("nothing is left"));
}

TEST_CASE("an adaptive field has an eighth of the bytes", "[geom][sdf][heavy]") {
  SdfDesc d;
  d.shape = make_sphere(1), d.spacing = Real(2.0 / 250);
  d.adaptive = true;
  const SdfReport fine = *sdf_report(*make_sdf(d));
  const double dense = 4.0 * (fine.cells[0] + 1) * (fine.cells[1] + 1) * (fine.cells[2] + 1);
  CHECK(fine.cells[0] >= 250);
  CHECK(double(fine.bytes) * 8 <= 4.0 * 257 * 257 * 257);
  CHECK(dense >= 4.0 * 250 * 250 * 250);
  // the certificate is that of the dense field: h^2/(4 r) and the sixteen bits
  CHECK(double(fine.error) <= 1.3 * double(fine.spacing) * double(fine.spacing) / 4);
}

TEST_CASE("a field may be asked anywhere: no place is out of its lists", "[geom][sdf]") {
  SdfDesc d;
  d.shape = make_sphere(1), d.spacing = Real(0.1);
  d.adaptive = GENERATE(false, true);
  const ShapePtr shape = make_sdf(d);
  const DistanceField& field = static_cast<const Sdf&>(*shape).field();
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  for (const Real far : {nan, kInfinity, -kInfinity, Real(1e15), Real(-1e15)})
    for (int k = 0; k < 3; ++k) {
      Vec3 p = Vec3::Zero(), slope;
      p[k] = far;
      CAPTURE(far, k, field.at(p), field.at_least(p), field.at(p, slope), field.smooth_at(p, slope));
      if (std::abs(far) == Real(1e15)) CHECK(field.at(p) > Real(0.9e15));
    }
}

TEST_CASE("bad input to a field is a line that says what to do", "[geom][sdf]") {
  const Solid& sphere = kSolids[0];
  const Triangles ball = triangulated(sphere, Real(0.2));
  const auto says = [](const SdfDesc& d, const char* text) { CHECK_THROWS_WITH(make_sdf(d), Catch::Contains(text)); };
  SdfDesc d;
  says(d, "expected one of mesh, shape, fn and buffer, got 0");
  d = of_mesh(ball, Real(0.1));
  d.triangles = {};
  says(d, "expected triangles, got none");
  d = of_mesh(ball, 5);
  says(d, "expected less than the thinnest side");
  d = of_mesh(ball, Real(0.001));
  says(d, "expected at most 1e+08 cells, got ");
  Triangles turned = ball;
  for (std::size_t i = 0; i < turned.corners.size(); i += 3) std::swap(turned.corners[i], turned.corners[i + 1]);
  says(of_mesh(turned, Real(0.1)), "inside out");
  Triangles flat = ball;
  for (Vec3& v : flat.vertices) v[1] = 0;
  says(of_mesh(flat, Real(0.1)), "a flat mesh has no inside");
  Triangles thin = ball;
  for (Vec3& v : thin.vertices) v[1] *= Real(5e-5);
  says(of_mesh(thin, Real(0.1)), "sides within 10000 of each other");
  d = {};
  d.size = vec3(1, 1, 1), d.spacing = Real(0.1);
  d.function = [](double x, double, double) { return x > 0 ? std::nan("") : 1.0; };
  says(d, "sdf.fn: expected a finite number at (");
  d.function = [](double, double, double) { return 1.0; };
  says(d, "nothing is inside");
  d.function = [](double, double, double) { return -1.0; };
  says(d, "reaches the rim");
  d.size = vec3(0, 1, 1);
  says(d, "size: expected the sides of the box in m");
  d = {};
  const std::vector<double> few(10, 1.0);
  d.size = vec3(1, 1, 1), d.spacing = Real(0.5), d.values = few;
  says(d, "buffer: expected 3 x 3 x 3 = 27 numbers");
  d = {};
  d.shape = make_plane(vec3(0, 1, 0), 0);
  says(d, "a plane has no inside");

  // open: it says so, and is filled
  Triangles open = ball;
  open.corners.resize(open.corners.size() - 3);
  const SdfReport r = *sdf_report(*make_sdf(of_mesh(open, Real(0.1))));
  REQUIRE(r.warnings.size() == 1);
  CHECK_THAT(r.warnings[0], Catch::Contains("the mesh is open: 3 edges"));
  // a shell: thin walls are said
  d = {};
  d.function = [](double x, double y, double z) { return std::abs(hypot3(x, y, z) - 1) - 0.03; };
  d.size = vec3(Real(2.4), Real(2.4), Real(2.4)), d.spacing = Real(0.05);
  const SdfReport shell = *sdf_report(*make_sdf(d));
  REQUIRE(shell.warnings.size() == 1);
  CHECK_THAT(shell.warnings[0], Catch::Contains("walls thinner than 2 cells on 100 % of the surface"));
}
