// Springs far too stiff for the step: no implicit method may go non-finite or gain energy, and none may stop in
// silence.
#include "feder/error.h"
#include "feder/memory.h"
#include "integrate/limits.h"
#include "linear/block_ldl.h"
#include "spring_field.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

// A chain hung at one end, horizontal, with a heavy last mass.
SpringField hung_chain(int links, Real stiffness, Real ratio) {
  SpringField f;
  f.gravity = Vec3(0, Real(-9.81), 0);
  f.add_point(Real(0.1), true);
  for (int i = 1; i <= links; ++i) {
    f.add_point(i == links ? Real(0.1) * ratio : Real(0.1));
    f.springs.push_back({static_cast<std::uint32_t>(i - 1), static_cast<std::uint32_t>(i), stiffness, 0, Real(0.1)});
  }
  return f;
}

State straight(int links) {
  State s;
  for (int i = 0; i <= links; ++i)
    s.x.push_back(Vec3(Real(0.1) * static_cast<Real>(i), 0, 0)), s.v.push_back(Vec3(0, 0, 0));
  return s;
}

}  // namespace

TEST_CASE("implicit methods stay finite on springs of any stiffness", "[integrate][once][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const auto& method = integrators()[static_cast<std::size_t>(row)];
  Arena arena("test");
  if (!method.make(arena, Params())->info().implicit) return;
  const Real stiffness = GENERATE(Real(1e4), Real(1e8), Real(1e12));
  const Real ratio = GENERATE(Real(1), Real(1e6));
  CAPTURE(method.name, stiffness, ratio);
  const auto m = method.make(arena, Params());
  SpringField f = hung_chain(10, stiffness, ratio);
  State s = straight(10);
  bool finite = true;
  for (int k = 0; k < (kAsserts ? 40 : 120) && finite; ++k) {
    m->step(f, 0, Real(1) / 60, s.x, s.v);
    for (std::size_t i = 0; i < s.x.size(); ++i) finite = finite && is_finite(s.x[i]) && is_finite(s.v[i]);
  }
  CHECK(finite);
}

TEST_CASE("methods without a limit gain no energy when the step grows a thousandfold", "[integrate][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const auto& method = integrators()[static_cast<std::size_t>(row)];
  CAPTURE(method.name);
  Arena arena("test");
  const auto m = method.make(arena, Params());
  if (!std::isinf(m->info().stability_limit)) return;
  Oscillator field(100, 0);
  Vec3 x(1, 0, 0), v(0, 0, 0);
  const auto energy = [&] { return 1e4 * static_cast<double>(dot(x, x)) + static_cast<double>(dot(v, v)); };
  for (int k = 0; k < 100; ++k) m->step(field, 0, Real(1e-4), {&x, 1}, {&v, 1});
  const double before = energy();
  double most = 0;
  for (int k = 0; k < 200; ++k) {
    m->step(field, 0, Real(1e-1), {&x, 1}, {&v, 1});
    most = std::max(most, energy());
  }
  CHECK(most <= 1.01 * before);
}

TEST_CASE("a stiff chain hangs at rest with its weight in the springs", "[integrate][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const auto& method = integrators()[static_cast<std::size_t>(row)];
  Arena arena("test");
  const auto m = method.make(arena, Params());
  if (!m->info().implicit || !m->info().l_stable) return;
  CAPTURE(method.name);
  // hanging chain: nine masses of 1 and a last of 1e6, springs of 1e8 N/m
  SpringField f;
  f.gravity = Vec3(0, Real(-9.81), 0);
  State s;
  f.add_point(1, true);
  s.x.push_back(Vec3(0, 0, 0)), s.v.push_back(Vec3(0, 0, 0));
  for (std::uint32_t i = 1; i <= 10; ++i) {
    f.add_point(i == 10 ? Real(1e6) : Real(1));
    f.springs.push_back({i - 1, i, Real(1e8), Real(0), Real(0.1)});
    s.x.push_back(Vec3(0, Real(-0.1) * static_cast<Real>(i), 0)), s.v.push_back(Vec3(0, 0, 0));
  }
  // the slowest mode, w = 3.16, is critically damped by drag on the heavy end through a dashpot of the last spring
  for (TestSpring& spring : f.springs) spring.damping = Real(2e7);
  for (int k = 0; k < 6000; ++k) m->step(f, 0, Real(1) / 60, s.x, s.v);
  const double stretch = -static_cast<double>(s.x[10][1]) - 1;
  CHECK(stretch == Approx(0.9810044145).epsilon(kFloat ? 1e-4 : 1e-7));
}

TEST_CASE("direct and iterative solves agree", "[integrate]") {
  const char* name = GENERATE("implicit_euler", "bdf2", "tr_bdf2", "ros2", "implicit_midpoint");
  CAPTURE(name);
  Arena arena("test");
  State a = straight(10), b = a;
  SpringField f = hung_chain(10, 1e4, 3);
  Params direct, iterative;
  direct.set("solver", std::string("direct"));
  iterative.set("solver", std::string("cg"));
  const auto& method = find_variant(integrators(), name, "integrator");
  const auto m = method.make(arena, direct), n = method.make(arena, iterative);
  for (int k = 0; k < 60; ++k) {
    m->step(f, 0, Real(1) / 240, a.x, a.v);
    n->step(f, 0, Real(1) / 240, b.x, b.v);
  }
  CHECK(length(a.x[10] - b.x[10]) < Real(kFloat ? 2e-3 : 1e-7));
  CHECK(m->stats.cg_iterations == 0);
  CHECK(n->stats.cg_iterations > 0);
}

TEST_CASE("a missed tolerance is counted", "[integrate]") {
  Arena arena("test");
  Params p;
  p.set("iterations", 2.0);
  p.set("solver", std::string("cg"));
  p.set("cg_iterations", 1.0);
  const auto m = find_variant(integrators(), "tr_bdf2", "integrator").make(arena, p);
  SpringField f = hung_chain(10, 1e6, 100);
  State s = straight(10);
  for (int k = 0; k < 10; ++k) m->step(f, 0, Real(1) / 60, s.x, s.v);
  CHECK(m->stats.unconverged > 0);
  CHECK(m->stats.residual > 0);
}

TEST_CASE("LDL factors chains without fill, trees with loops too, and refuses what is not definite", "[linear]") {
  constexpr std::uint32_t n = 30;
  BlockSparse a;
  std::vector<BlockIndex> pattern;
  for (std::uint32_t i = 0; i + 1 < n; ++i) pattern.push_back({i, i + 1});
  Arena arena("test");
  BlockLdl chain(arena);
  REQUIRE(chain.analyze(n, pattern, 1000));
  CHECK(chain.operations() <= 3 * n);
  pattern.push_back({2, 20}), pattern.push_back({0, 29}), pattern.push_back({2, 20});  // loops, and a block twice
  a.set_pattern(n, pattern);
  for (Mat3d& m : a.diagonal) m = Mat3d::Identity() * 0.01;
  for (std::size_t k = 0; k < pattern.size(); ++k) {
    const Vec3d d = Vec3d(1, static_cast<double>(k % 3), static_cast<double>(k % 5)).normalized();
    Mat3d block = 1000 * d * d.transpose();
    a.diagonal[pattern[k].i] += block, a.diagonal[pattern[k].j] += block;
    block(0, 1) += 0.001;  // off-diagonal blocks need not be symmetric
    a.off[k] = -block;
  }
  std::vector<Real> free(n, 1);
  free[7] = 0;
  std::vector<Vec3> wanted(n), b(n), x(n);
  std::vector<Vec3d> product(n);
  for (std::uint32_t i = 0; i < n; ++i) wanted[i] = i == 7 ? Vec3(0, 0, 0) : vec3(Real(i % 7) - 3, Real(i % 4), 1);
  a.multiply<Vec3>(wanted, product);
  for (std::size_t i = 0; i < n; ++i) b[i] = product[i].cast<Real>();
  BlockLdl ldl(arena);
  REQUIRE(ldl.analyze(n, pattern, 100000));
  CHECK_FALSE(BlockLdl(arena).analyze(n, pattern, 10));
  REQUIRE(ldl.factor(a, free));
  const std::uint64_t before = arena.allocations();
  REQUIRE(ldl.factor(a, free));
  ldl.solve(b, free, x);
  CHECK(arena.allocations() == before);
  // against the product, not the wanted solution: float b is rounded
  std::vector<Vec3d> again(n);
  a.multiply<Vec3>(x, again);
  for (std::size_t i = 0; i < n; ++i) {
    if (i == 7)
      CHECK(x[i] == Vec3(0, 0, 0));
    else
      CHECK((again[i] - product[i]).norm() < (kFloat ? 1e-2 : 1e-9));
  }
  a.diagonal[12] -= 2000 * Mat3d::Identity();
  CHECK_FALSE(ldl.factor(a, free));
}
