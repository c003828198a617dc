// The contract of soft/elasticity.h, for every law: rest, small strains, derivatives, inversion.
#include "base/rng.h"
#include "soft/elasticity.h"
#include "soft_bodies.h"

namespace feder::test {
namespace {

const ElasticLaw& any_law() {
  return elastic_laws()[static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(elastic_laws().size()))))];
}

Mat3d random_matrix(Rng& rng, double size) {
  Mat3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = size * number(rng.uniform(-1, 1));
  return m;
}

Mat3d rotation(Rng& rng) {
  const Vec3 axis(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(Real(0.1), 1));
  return stretches_of(to_matrix(from_axis_angle(axis, rng.uniform(-3, 3))).cast<double>()).u;
}

double inner(const Mat3d& a, const Mat3d& b) { return a.cwiseProduct(b).sum(); }

// Strains of some per cent, states far from rest, inverted ones, and those pressed nearly flat.
Mat3d some_state(Rng& rng, int kind) {
  const Mat3d near = Mat3d::Identity() + random_matrix(rng, 0.05), far = Mat3d::Identity() + random_matrix(rng, 0.6);
  Mat3d turned = far;
  turned.col(2) *= -1;
  const Mat3d states[] = {near, far, turned};
  return rotation(rng) * states[kind];
}

// Pa, of the stiffness at rest
double rest_size(const SoftMaterial& m) { return 3 * std::fabs(m.lame) + 2 * m.mu; }

const double kNu[] = {-0.5, 0.0, 0.3, 0.49};

}  // namespace

TEST_CASE("stretches and rotations make up any deformation gradient", "[soft][elasticity]") {
  Rng rng(3);
  for (int n = 0; n < 300; ++n) {
    Mat3d f = random_matrix(rng, 1);
    if (n % 5 == 1) f.col(1) = 2 * f.col(0);                        // flat
    if (n % 5 == 2) f.col(1) = 2 * f.col(0), f.col(2) = -f.col(0);  // a line
    if (n % 5 == 3) f *= 1e-150;
    if (n == 4) f.setZero();
    const Stretches d = stretches_of(f);
    Mat3d s = Mat3d::Zero();
    for (int k = 0; k < 3; ++k) s(k, k) = d.s[k];
    CHECK((d.u * s * d.v.transpose() - f).norm() <= 1e-14 * f.norm());
    for (const Mat3d* r : {&d.u, &d.v}) {
      CHECK((*r * r->transpose() - Mat3d::Identity()).norm() < 1e-13);
      CHECK(determinant(*r) == Approx(1));
    }
    CHECK((d.s[0] >= d.s[1] && d.s[1] >= std::fabs(d.s[2]) - 1e-15 * d.s[0]));
  }
}

TEST_CASE("a law has no energy and no stress where a body is turned, and Lame's stress for small strains",
          "[soft][elasticity]") {
  const ElasticLaw& law = any_law();
  const double nu = kNu[GENERATE(range(0, 4))];
  CAPTURE(law.name, nu);
  const SoftMaterial m = soft_material(1e5, nu);
  Rng rng(4);
  for (int n = 0; n < 20; ++n) {
    const Mat3d r = rotation(rng);
    CHECK(std::fabs(law.energy(m, r)) < 1e-12 * rest_size(m));
    CHECK(law.stress(m, r).norm() < 1e-12 * rest_size(m));
    const Mat3d h = random_matrix(rng, 1e-7), e = 0.5 * (h + h.transpose());
    const Mat3d wanted = 2 * m.mu * e + m.lame * (e(0, 0) + e(1, 1) + e(2, 2)) * Mat3d::Identity();
    const Mat3d stress = law.stress(m, r * (Mat3d::Identity() + h));
    CHECK((stress - r * wanted).norm() < 1e-5 * 1e-7 * rest_size(m));
  }
}

TEST_CASE("the stress of a law is the gradient of its energy, its Hessian that of the stress", "[soft][elasticity]") {
  const ElasticLaw& law = any_law();
  const double nu = kNu[GENERATE(range(0, 4))];
  const int kind = GENERATE(0, 1, 2);
  CAPTURE(law.name, nu, kind);
  const SoftMaterial m = soft_material(1e5, nu);
  Rng rng(static_cast<std::uint64_t>(5 + kind));
  for (int n = 0; n < 20; ++n) {
    const Mat3d f = some_state(rng, kind);
    const Stretches d = stretches_of(f);
    if (std::fabs(d.s[1] + d.s[2]) < 0.05) continue;  // where the rotation jumps
    Vec3d g[4] = {Vec3d(0, 0, 0)};
    for (int c = 1; c < 4; ++c) g[c] = random_matrix(rng, 1).col(0), g[0] -= g[c];
    Vec3d x[4];
    Mat3d df = Mat3d::Zero();
    for (int c = 0; c < 4; ++c) x[c] = random_matrix(rng, 1).col(0), df += x[c] * g[c].transpose();
    const double step = 1e-5 / df.norm(), size = rest_size(m) * (1 + f.squaredNorm()) * df.norm();
    const Mat3d more = f + step * df, less = f - step * df;
    const double slope = (law.energy(m, more) - law.energy(m, less)) / (2 * step);
    CHECK(std::fabs(slope - inner(law.stress(m, f), df)) < 1e-8 * size);
    const Mat3d change = (law.stress(m, more) - law.stress(m, less)) / (2 * step);
    CornerStiffness k;
    corner_stiffness(law, m, f, g, false, k);
    double most = 0;
    for (int a = 0; a < 4; ++a) {
      Vec3d force = k.diagonal[a] * x[a];
      for (int p = 0; p < 6; ++p) {
        if (kCornerPairs[p][0] == a) force += k.off[p] * x[kCornerPairs[p][1]];
        if (kCornerPairs[p][1] == a) force += k.off[p].transpose() * x[kCornerPairs[p][0]];
      }
      most = std::fmax(most, (force - change * g[a]).norm());
    }
    CHECK(most < 1e-6 * size);
  }
}

TEST_CASE("the projected Hessian of a law pushes nothing away, and is the Hessian near rest", "[soft][elasticity]") {
  const ElasticLaw& law = any_law();
  const int kind = GENERATE(0, 1, 2);
  CAPTURE(law.name, kind);
  const SoftMaterial m = soft_material(1e5, 0.3);
  Rng rng(static_cast<std::uint64_t>(15 + kind));
  double lowest_plain = 0;
  for (int n = 0; n < 200; ++n) {
    const Mat3d f = n == 0 ? Mat3d(Mat3d::Zero()) : some_state(rng, kind);
    Vec3d g[4] = {Vec3d(0, 0, 0)};
    for (int c = 1; c < 4; ++c) g[c] = random_matrix(rng, 1).col(0), g[0] -= g[c];
    CornerStiffness k[2];
    for (int p = 0; p < 2; ++p) corner_stiffness(law, m, f, g, p == 1, k[p]);
    for (int q = 0; q < 20; ++q) {
      Vec3d x[4];
      for (Vec3d& v : x) v = random_matrix(rng, 1).col(0);
      double work[2] = {0, 0};
      for (int p = 0; p < 2; ++p) {
        for (int a = 0; a < 4; ++a) work[p] += x[a].dot(k[p].diagonal[a] * x[a]);
        for (int a = 0; a < 6; ++a) work[p] += 2 * x[kCornerPairs[a][0]].dot(k[p].off[a] * x[kCornerPairs[a][1]]);
      }
      const double size = rest_size(m) * (1 + f.squaredNorm());
      CHECK(std::isfinite(work[1]));
      CHECK(work[1] > -1e-11 * size);
      if (n > 0) CHECK(work[1] > work[0] - 1e-11 * size);
      lowest_plain = std::fmin(lowest_plain, work[0] / size);
    }
  }
  if (kind > 0) CHECK(lowest_plain < -1e-3);  // else there was nothing to project
}

TEST_CASE("laws that turn tetrahedra back push them out of inversion, the others say that they do not",
          "[soft][elasticity]") {
  const ElasticLaw& law = any_law();
  CAPTURE(law.name);
  const SoftMaterial m = soft_material(1e5, 0.3);
  for (double s = -2; s < 0.9; s += 0.1) {
    const double stretches[3] = {1, 1, s};
    CAPTURE(s);
    if (law.turns_back) CHECK(law.principal(m, stretches).stress[2] < -0.05 * m.mu);
  }
  Mat3d reflection = Mat3d::Identity();
  reflection(2, 2) = -1;
  CHECK((law.stress(m, reflection).norm() < 1e-9 * m.mu) == !law.turns_back);
}

TEST_CASE("a bar of St. Venant and Kirchhoff's material gives way at 1/sqrt(3) of its length", "[soft][elasticity]") {
  for (const ElasticLaw& law : elastic_laws()) {
    if (std::string(law.name) != "stvk") continue;
    const SoftMaterial m = soft_material(1e5, 0);
    double least = 0, at = 0;
    for (double s = 0.01; s < 1; s += 1e-3) {
      Mat3d f = Mat3d::Identity();
      f(0, 0) = s;
      const double pull = law.stress(m, f)(0, 0);
      CHECK(pull == Approx(1e5 / 2 * (s * s - 1) * s));
      if (pull < least) least = pull, at = s;
    }
    CHECK(at == Approx(1 / std::sqrt(3.0)).margin(1e-3));
  }
}

}  // namespace feder::test
