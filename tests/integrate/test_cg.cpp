// Conjugate gradient of runtime/linear on chains with a known solution.
#include "feder/memory.h"
#include "linear/cg.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Mass plus stiffness of a chain of n points; the couplings are turned differently from link to link.
BlockSparse chain(std::size_t n, Real stiffness) {
  BlockSparse a;
  std::vector<BlockIndex> pattern;
  for (std::uint32_t i = 0; i + 1 < n; ++i) pattern.push_back({i, i + 1});
  a.set_pattern(n, pattern);
  for (Mat3d& m : a.diagonal) m = Mat3d::Identity();
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    const Vec3d d = Vec3d(1, i % 3, i % 5).normalized();
    const Mat3d k = static_cast<double>(stiffness) * d * d.transpose();
    a.off[i] = -k;
    a.diagonal[i] += k;
    a.diagonal[i + 1] += k;
  }
  return a;
}

}  // namespace

TEST_CASE("conjugate gradient solves to its tolerance and keeps fixed points", "[linear]") {
  constexpr std::size_t n = 40;
  const Real stiffness = GENERATE(Real(1), Real(1e3));
  const BlockSparse a = chain(n, stiffness);
  std::vector<Real> free(n, 1);
  free[0] = free[17] = 0;
  std::vector<Vec3> wanted(n), b(n), x(n, Vec3(9, 9, 9));
  for (std::size_t i = 0; i < n; ++i)
    wanted[i] = free[i] != 0 ? vec3(static_cast<Real>(i % 7) - 3, static_cast<Real>(i % 4), 1) : vec3(0, 0, 0);
  std::vector<Vec3d> product(n);
  a.multiply<Vec3>(wanted, product);
  for (std::size_t i = 0; i < n; ++i) b[i] = product[i].cast<Real>();
  b[17] = vec3(100, 100, 100);  // pushes on a fixed point must not matter

  Arena arena("test");
  ConjugateGradient cg(arena);
  const double tolerance = sizeof(Real) == 4 ? 1e-6 : 1e-12;
  const CgResult r = cg.solve(a, free, b, {tolerance, 400}, x);
  CAPTURE(r.iterations, r.residual);
  CHECK(r.converged);
  CHECK(r.iterations > 3);
  // b is rounded: 6e-8 in float, times a condition number of 4e3, times 5 for the size of x, and the solve's own 1e-6
  for (std::size_t i = 0; i < n; ++i) CHECK(length(x[i] - wanted[i]) < Real(sizeof(Real) == 4 ? 4e-3 : 1e-8));

  // the cap is reported
  const CgResult capped = cg.solve(a, free, b, {tolerance, 2}, x);
  CHECK_FALSE(capped.converged);
  CHECK(capped.iterations == 2);
  CHECK(capped.residual > tolerance);
}

TEST_CASE("conjugate gradient refuses an indefinite matrix", "[linear]") {
  BlockSparse a = chain(3, 1);
  a.diagonal[1] -= 50 * Mat3d::Identity();
  std::vector<Real> free(3, 1);
  std::vector<Vec3> b(3, Vec3(1, 2, 3)), x(3);
  Arena arena("test");
  ConjugateGradient cg(arena);
  CHECK_FALSE(cg.solve(a, free, b, {1e-6, 100}, x).converged);
}
