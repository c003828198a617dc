// Signs of volumes against integers, where floats are whole numbers; and what passes through a triangle.
#include "base/rng.h"
#include "geom/predicates.h"
#include "support/catch.h"

using namespace feder;

namespace {

__extension__ using Wide = __int128;

int sign_by_integers(const Vec3 (&p)[4]) {
  Wide u[3][3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) u[i][k] = static_cast<Wide>(p[i + 1][k]) - static_cast<Wide>(p[0][k]);
  Wide sum = 0;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    sum += u[0][k] * (u[1][l] * u[2][m] - u[1][m] * u[2][l]);
  }
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

Vec3 whole(Rng& rng, int most) {
  const auto one = [&] { return static_cast<Real>(static_cast<int>(rng.next() % (2u * unsigned(most) + 1)) - most); };
  const Real x = one(), y = one(), z = one();
  return Vec3(x, y, z);
}

}  // namespace

TEST_CASE("the sign of a volume is that of whole numbers", "[geom]") {
  Rng rng(5);
  int flat = 0;
  for (int n = 0; n < 20000; ++n) {
    const int most = n % 2 ? 2 : 1 << 23;
    Vec3 p[4] = {whole(rng, most), whole(rng, most), whole(rng, most), whole(rng, most)};
    // nearly in one plane, to the last digit: d = a + (b - a) + (c - a), and a step of one beside it
    if (n % 4 == 3) {
      for (int k = 0; k < 3; ++k) p[k] = Vec3(p[k] / 4).array().round().matrix();
      p[3] = p[1] + p[2] - p[0];
      if (n % 8 == 7) p[3][n % 3] += 1;
    }
    const int expected = sign_by_integers(p);
    flat += expected == 0;
    REQUIRE(orientation(p[0], p[1], p[2], p[3]) == expected);
    REQUIRE(orientation(p[1], p[0], p[2], p[3]) == -expected);
    // the same sign at any size
    const Real size = n % 3 == 0 ? Real(0x1p-40) : Real(0x1p30);
    REQUIRE(orientation(size * p[0], size * p[1], size * p[2], size * p[3]) == expected);
  }
  CHECK(flat > 1000);
}

TEST_CASE("a segment passes through the inside of a triangle, and not where it touches", "[geom]") {
  const Vec3 a(0, 0, 0), b(2, 0, 0), c(0, 0, 2);
  const auto through = [&](const Vec3& p, const Vec3& q) {
    const bool is = passes_through(p, q, a, b, c);
    CHECK(passes_through(q, p, b, a, c) == is);
    return is;
  };
  const Real small = sizeof(Real) == 4 ? Real(1e-30) : Real(1e-60);
  CHECK(through(Vec3(Real(0.5), -1, Real(0.5)), Vec3(Real(0.5), 1, Real(0.5))));
  CHECK(through(Vec3(Real(0.5), -small, Real(0.5)), Vec3(Real(0.5), small, Real(0.5))));
  CHECK_FALSE(through(Vec3(Real(0.5), 0, Real(0.5)), Vec3(Real(0.5), 1, Real(0.5))));  // an end in it
  CHECK_FALSE(through(Vec3(1, -1, 1), Vec3(1, 1, 1)));                                 // a side
  CHECK_FALSE(through(Vec3(0, -1, 0), Vec3(0, 1, 0)));                                 // a corner
  CHECK_FALSE(through(Vec3(-1, 0, Real(0.5)), Vec3(3, 0, Real(0.5))));                 // in its plane
  CHECK_FALSE(through(Vec3(Real(1.5), -1, Real(1.5)), Vec3(Real(1.5), 1, Real(1.5))));
  CHECK_FALSE(through(a, b));
  CHECK_FALSE(passes_through(Vec3(0, -1, 0), Vec3(0, 1, 0), a, a, a));
  CHECK_FALSE(passes_through(Vec3(0, -1, 0), Vec3(0, kInfinity - kInfinity, 0), a, b, c));
}
