// The surface of a liquid: it encloses the volume of its particles, a lone one is a ball, and what is out of reason is
// left out.
#include <cmath>

#include "base/rng.h"
#include "fluid/liquid_surface.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::vector<Vec3> brick(int nx, int ny, int nz, Real d) {
  std::vector<Vec3> x;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        x.push_back(d * vec3(static_cast<Real>(i) + Real(0.5), static_cast<Real>(j) + Real(0.5),
                             static_cast<Real>(k) + Real(0.5)));
  return x;
}

// By the divergence theorem, m^3: right only of a closed surface whose triangles face outwards.
double enclosed(const IsoMesh& m) {
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const Vec3 &a = m.vertices[m.triangles[t]], &b = m.vertices[m.triangles[t + 1]],
               &c = m.vertices[m.triangles[t + 2]];
    sum += static_cast<double>(dot(a, cross(b, c))) / 6;
  }
  return sum;
}

}  // namespace

TEST_CASE("the surface of a liquid encloses the volume of its particles", "[fluid][surface]") {
  const Real d = Real(0.02);
  const int n = GENERATE(12, 34, 40);  // in fine cells, in middle and in coarse ones with a deep inside
  LiquidSurface s;
  IsoMesh m;
  s.build(brick(n, n, n, d), d, false, m);
  CHECK(enclosed(m) == Approx(std::pow(n * static_cast<double>(d), 3)).epsilon(n == 12 ? 0.03 : 0.01));
  // a tank's worth: the surface lies within a third of a spacing of the faces
  for (const Vec3& x : m.vertices) {
    const Vec3 from = (x - Vec3::Constant(static_cast<Real>(n) * d / 2)).cwiseAbs();
    const Real far = from.maxCoeff() - static_cast<Real>(n) * d / 2;
    CHECK(std::fabs(far) < d / 2);
  }
}

TEST_CASE("a lone particle is a ball, and none is none", "[fluid][surface]") {
  LiquidSurface s;
  IsoMesh m;
  const Vec3 at = vec3(Real(3.217), Real(-1.1), Real(0.4));
  s.build(std::vector<Vec3>{at, vec3(NAN, 0, 0), vec3(0, kInfinity, 0)}, Real(0.1), true, m);
  REQUIRE(m.triangles.size() > 20);
  for (const Vec3& x : m.vertices) CHECK(length(Vec3(x - at)) == Approx(0.055).margin(0.005));
  s.build({}, Real(0.1), true, m);
  CHECK(m.triangles.empty());
}

TEST_CASE("spray over a wide box is left out, and nothing breaks", "[fluid][surface]") {
  Rng rng(3);
  std::vector<Vec3> x;
  for (int i = 0; i < 3000; ++i)
    x.push_back(vec3(rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(-500, 500)));
  LiquidSurface s;
  IsoMesh m;
  s.build(x, Real(0.1), true, m);
  CHECK(m.triangles.size() < 1000 * 3000);
  s.build(std::vector<Vec3>{vec3(-1e4f, -1e4f, -1e4f), vec3(1e4f, 1e4f, 1e4f)}, Real(0.01), true, m);
  CHECK(m.triangles.empty());
}

TEST_CASE("drops far away do not cost the liquid its surface", "[fluid][surface]") {
  const Real d = Real(0.02);
  std::vector<Vec3> x = brick(10, 10, 10, d);
  LiquidSurface s;
  IsoMesh m;
  s.build(x, d, false, m);
  const double whole = enclosed(m);
  x.push_back(vec3(0, 1000, 0)), x.push_back(vec3(-500, 0, 800));
  s.build(x, d, false, m);
  CHECK(enclosed(m) == Approx(whole).epsilon(0.01));
}
