// Own trigonometry and rotations against the C library in long double and against identities.
#include <cmath>

#include "base/rng.h"
#include "feder/types.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("own sine and cosine agree with the C library to rounding", "[base]") {
  double worst = 0;
  Rng rng(7);
  for (int i = 0; i < 20000; ++i) {
    const double x = (rng.unit() - 0.5) * (i % 2 ? 20.0 : 2e4);
    worst = std::max(worst, std::fabs(sin_cos_sin(x) - std::sin(x)));
    worst = std::max(worst, std::fabs(sin_cos_cos(x) - std::cos(x)));
  }
  CHECK(worst < 3e-12);  // argument reduction loses x * 1e-16 at |x| = 1e4
}

TEST_CASE("own arc functions agree with the C library in all quadrants", "[base]") {
  const double tolerance = 4 * static_cast<double>(kEpsilon);
  for (int i = 0; i < 720; ++i) {
    const double a = (i - 359.5) * 3.14159265358979323846 / 360;
    const double r = 0.001 + i * 0.37;
    CHECK(std::fabs(arc_tan2(Real(r * std::sin(a)), Real(r * std::cos(a))) - a) < tolerance * 4);
  }
  CHECK(arc_tan2(0, -1) == Approx(kPi));
  CHECK(arc_tan2(0, 0) == 0);
  for (int i = 0; i <= 200; ++i) {
    const Real c = Real(-1) + Real(i) / 100;
    CHECK(static_cast<double>(arc_cos(c)) ==
          Approx(std::acos(static_cast<double>(c))).margin(1e-3 * std::sqrt(tolerance)));
  }
}

TEST_CASE("rotations: quaternion, matrix and rotation vector agree", "[base]") {
  Rng rng(3);
  const Real tolerance = 40 * kEpsilon;
  for (int i = 0; i < 500; ++i) {
    const Vec3 axis(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const Real angle = rng.uniform(0, Real(3.1));
    const Quat q = from_axis_angle(axis, angle);
    const Vec3 v(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2));
    CHECK(length(rotate(q, v) - to_matrix(q) * v) < 10 * tolerance);
    CHECK(length(rotate_inverse(q, rotate(q, v)) - v) < 10 * tolerance);
    const Quat back = from_matrix(to_matrix(q));
    CHECK(std::fabs(back.x * q.x + back.y * q.y + back.z * q.z + back.w * q.w) == Approx(1).margin(tolerance));
    const Vec3 turned = rotation_between(Quat::identity(), q);
    CHECK(length(turned - axis / length(axis) * angle) < 60 * tolerance);
    CHECK(length(rotation_between(integrate_rotation(Quat::identity(), turned), q)) < 60 * tolerance);
  }
}

TEST_CASE("tangent frames are orthonormal and right-handed everywhere", "[base]") {
  Rng rng(5);
  for (int i = 0; i < 500; ++i) {
    Vec3 n(rng.uniform(-1, 1), rng.uniform(-1, 1), i % 5 ? rng.uniform(-1, 1) : Real(-1));
    if (i % 7 == 0) n = Vec3(0, 0, -1);
    n = n / length(n);
    Vec3 t1, t2;
    tangent_frame(n, t1, t2);
    CHECK(length(cross(t1, t2) - n) < 20 * kEpsilon);
    CHECK(std::fabs(dot(t1, n)) < 20 * kEpsilon);
  }
}

TEST_CASE("symmetric eigenvalues rebuild the matrix", "[base]") {
  Rng rng(11);
  for (int i = 0; i < 200; ++i) {
    Mat3 a = Mat3::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vec3 v(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      a += v * v.transpose();
    }
    Vec3 values;
    Mat3 vectors;
    eigen_symmetric(a, values, vectors);
    const Mat3 rebuilt = vectors * values.asDiagonal() * vectors.transpose();
    CHECK((rebuilt - a).norm() < 60 * kEpsilon * (1 + a.norm()));
    CHECK(values[0] <= values[1]);
    CHECK(values[1] <= values[2]);
    CHECK((inverse(a + Mat3::Identity()) * (a + Mat3::Identity()) - Mat3::Identity()).norm() < 200 * kEpsilon);
  }
}
