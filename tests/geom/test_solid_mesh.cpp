// Tetrahedra that fill shapes: they meet face to face, fill the volume, and have no small angles.
#include <map>

#include "geom/solid_mesh.h"
#include "geom/tetrahedron.h"
#include "support/catch.h"

namespace feder::test {
namespace {

Corners corners_of(const SolidMesh& m, std::size_t k) {
  Corners x;
  for (std::size_t c = 0; c < 4; ++c) x[c] = wide(m.points[m.tetrahedra[k][c]]);
  return x;
}

struct Measured {
  double volume = 0, angle = 4;
  std::size_t open = 0, shared = 0;  // faces of one tetrahedron, and of more than two
  double area = 0;                   // closed: the sum of the area vectors of the skin
};

Measured measure(const SolidMesh& m) {
  Measured all;
  std::map<std::array<std::uint32_t, 3>, int> faces;
  Double3 area{0, 0, 0};
  for (std::size_t k = 0; k < m.tetrahedra.size(); ++k) {
    const Corners x = corners_of(m, k);
    const double volume = tetrahedron_volume(x);
    REQUIRE(volume > 0);
    all.volume += volume;
    all.angle = std::min(all.angle, smallest_dihedral(x));
    for (const auto& f : kTetrahedronFaces) {
      std::array<std::uint32_t, 3> key;
      for (std::size_t c = 0; c < 3; ++c) key[c] = m.tetrahedra[k][static_cast<std::size_t>(f[c])];
      std::sort(key.begin(), key.end());
      ++faces[key];
    }
  }
  for (const auto& [key, count] : faces) all.open += count == 1, all.shared += count > 2;
  // a face of one tetrahedron alone must lie on the skin: seen from outside they close
  for (std::size_t k = 0; k < m.tetrahedra.size(); ++k)
    for (const auto& f : kTetrahedronFaces) {
      std::array<std::uint32_t, 3> v, key;
      for (std::size_t c = 0; c < 3; ++c) v[c] = m.tetrahedra[k][static_cast<std::size_t>(f[c])];
      key = v;
      std::sort(key.begin(), key.end());
      if (faces[key] != 1) continue;
      const Double3 a = wide(m.points[v[0]]), b = wide(m.points[v[1]]), c = wide(m.points[v[2]]);
      area = area + 0.5 * cross(b - a, c - a);
    }
  all.area = length(area);
  return all;
}

}  // namespace

TEST_CASE("a box is filled by its own lattice, exactly", "[geom]") {
  const ShapePtr box = make_box(2, 1, Real(0.5));
  const SolidMesh m = fill_shape(*box, 8);
  CHECK(m.tetrahedra.size() == 8 * 4 * 2 * 5);
  CHECK(m.points.size() == 9 * 5 * 3);
  const Measured all = measure(m);
  CHECK(all.volume == Approx(1.0));
  CHECK(all.shared == 0);
  CHECK(all.open == 4 * (8 * 4 + 8 * 2 + 4 * 2));
  CHECK(all.angle > 0.9);
}

TEST_CASE("shapes are stuffed with tetrahedra that fill them", "[geom]") {
  struct Row {
    ShapePtr shape;
    double volume;
  };
  const double pi = 3.14159265358979;
  const std::vector<Vec3> v = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  const std::vector<std::uint32_t> t = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  std::vector<std::uint32_t> inward = t;
  for (std::size_t k = 0; k < inward.size(); k += 3) std::swap(inward[k], inward[k + 1]);
  const Row rows[] = {{make_sphere(Real(0.5)), pi / 6},
                      {make_capsule(Real(0.2), 1), pi * 0.04 * 0.6 + pi * 4 / 3 * 0.008},
                      {make_cylinder(Real(0.3), Real(0.7)), pi * 0.09 * 0.7},
                      {make_cone(Real(0.5), 1), pi * 0.25 / 3},
                      {make_hull(v), 1.0 / 6},
                      {make_mesh(v, t), 1.0 / 6},
                      {make_mesh(v, inward), 1.0 / 6}};
  for (const Row& row : rows) {
    CAPTURE(row.shape->kind());
    for (const std::uint32_t resolution : {3u, 8u, 20u}) {
      CAPTURE(resolution);
      const SolidMesh m = fill_shape(*row.shape, resolution);
      const Measured all = measure(m);
      CHECK(all.shared == 0);
      CHECK(all.area < 1e-5);
      // corners are rounded by part of a cell: the error falls with it
      CHECK(std::fabs(all.volume / row.volume - 1) < 2.5 / resolution);
      CHECK(all.angle > 0.08);
    }
  }
  const SolidMesh fine = fill_shape(*make_sphere(Real(0.5)), 20);
  CHECK(std::fabs(measure(fine).volume / (pi / 6) - 1) < 0.02);
  // its points lie on it or within
  double most = 0;
  for (const Vec3& p : fine.points) most = std::max(most, double(length(p)));
  CHECK(most < 0.5001);
  CHECK(most > 0.4999);
}

TEST_CASE("what is no solid, and too many cells, are refused", "[geom]") {
  CHECK_THROWS_WITH(fill_shape(*make_plane(Vec3(0, 1, 0), 0), 8), Catch::Contains("expected a solid"));
  CHECK_THROWS_WITH(fill_shape(*make_circle(1), 8), Catch::Contains("expected a solid"));
  CHECK_THROWS_WITH(fill_shape(*make_sphere(1), 300), Catch::Contains("expected at most 1e7 cells"));
}

TEST_CASE("barycentric weights are 1 at a corner and add up", "[geom]") {
  const Corners x = {Double3{0.1, 0.2, 0.3}, Double3{1.3, 0.1, 0.2}, Double3{0.2, 1.1, 0.1}, Double3{0.4, 0.3, 1.7}};
  CHECK(tetrahedron_volume(x) > 0);
  for (std::size_t c = 0; c < 4; ++c) {
    const auto w = barycentric(x, x[c]);
    for (std::size_t k = 0; k < 4; ++k) CHECK(w[k] == Approx(k == c ? 1.0 : 0.0).margin(1e-12));
  }
  const Double3 p = 0.1 * x[0] + 0.2 * x[1] + 0.3 * x[2] + 0.4 * x[3];
  const auto w = barycentric(x, p);
  for (std::size_t k = 0; k < 4; ++k) CHECK(w[k] == Approx(0.1 * double(k + 1)));
}

}  // namespace feder::test
