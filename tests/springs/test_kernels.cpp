// The wide force pass against a loop over the springs: the same bits, whatever the width, threads and layout.
#include <cmath>

#include "nets.h"
#include "springs/net.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

struct Random {
  std::uint32_t state = 1;
  Real operator()() {  // in [0, 1)
    state = state * 1664525u + 1013904223u;
    return static_cast<Real>(state >> 8) / Real(16777216);
  }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>((*this)() * static_cast<Real>(n)) % n; }
};

// Points with many, few and no springs, a hub, two points at one spot, springs of all sorts.
NetDesc thicket(std::uint32_t points, std::uint32_t springs, bool damped, bool slack) {
  Random r;
  NetDesc d;
  for (std::uint32_t i = 0; i < points; ++i) {
    d.points.push_back(Vec3(r(), r(), r()));
    d.velocities.push_back(Vec3(r() - Real(0.5), r() - Real(0.5), r() - Real(0.5)));
    d.masses.push_back(Real(0.1) + r());
  }
  d.points[points - 1] = d.points[0];
  for (std::uint32_t k = 0; k < springs; ++k) {
    SpringDesc s;
    s.i = k < springs / 8 ? 0 : r.below(points - 1);  // the last point has the one spring below only
    s.j = (s.i + 1 + r.below(points - 2)) % (points - 1);
    if (s.i == s.j) s.j = (s.i + 1) % (points - 1);
    s.stiffness = k % 17 == 0 ? 0 : 1000 * r();
    s.rest_length = k % 13 == 0 ? 0 : r();
    s.damping = damped && k % 3 == 0 ? r() : 0;
    s.tension_only = slack && k % 2 == 0;
    d.springs.push_back(s);
  }
  d.springs[springs / 2] = {points - 1, 0, 300, 0, Real(0.25)};
  return d;
}

std::vector<Vec3> reference(const NetDesc& d, const Vec3& outside) {
  std::vector<Vec3> f(d.points.size(), outside);
  for (const SpringDesc& s : d.springs) {
    Vec3 dx = d.points[s.j] - d.points[s.i];
    const Real square = dot(dx, dx);
    Real len = std::sqrt(square), by = len;
    if (square <= kNoLength2) dx = Vec3(s.i < s.j ? Real(1) : Real(-1), 0, 0), len = 0, by = 1;
    const Real inverse = 1 / by, stretch = len - s.rest_length;
    Real tension = s.stiffness * stretch;
    tension += s.damping * (dot(Vec3(d.velocities[s.j] - d.velocities[s.i]), dx) * inverse);
    if (s.tension_only && (stretch <= 0 || tension < 0)) tension = 0;
    f[s.i] += dx * (tension * inverse);
    f[s.j] -= dx * (tension * inverse);
  }
  return f;
}

struct Pass {
  Pass(const NetDesc& d, const SpringKernels& kernels, int threads) : jobs(threads), arrays(arena), layout(arena) {
    for (const SpringDesc& s : d.springs) arrays.add(s, s.rest_length);
    layout.choose(kernels);
    layout.build(arrays, static_cast<std::uint32_t>(d.points.size()));
    f.resize(d.points.size());
  }
  unsigned run(const NetDesc& d, const Vec3& outside) {
    return layout.eval(
        d.points, d.velocities, jobs.threads() > 1 ? &jobs : nullptr, [&](std::uint32_t) { return outside; }, f);
  }
  Arena arena{"test"};
  JobPool jobs;
  SpringArrays arrays;
  SpringLayout layout;
  std::vector<Vec3> f;
};

const SpringKernels& kernels_of(bool wide) {
  return wide && __builtin_cpu_supports("avx2") ? kSpringKernelsAvx2 : kSpringKernelsPlain;
}

}  // namespace

TEST_CASE("the force pass gives the bits of a loop over the springs", "[springs][kernel][threads]") {
  const bool wide = GENERATE(false, true), damped = GENERATE(false, true), slack = GENERATE(false, true);
  const int threads = GENERATE(1, 2, 4);
  const std::uint32_t points = GENERATE(3u, 9u, 700u);
  CAPTURE(wide, damped, slack, threads, points);
  const NetDesc d = thicket(points, points * 5, damped, slack);
  const Vec3 outside(Real(0.5), -3, 2);
  const std::vector<Vec3> expected = reference(d, outside);
  Pass pass(d, kernels_of(wide), threads);
  const unsigned at_one_spot = pass.run(d, outside);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.size(); ++i)
    for (int k = 0; k < 3; ++k) wrong += !(pass.f[i][k] == expected[i][k]);
  CHECK(wrong == 0);
  CHECK(at_one_spot >= 2);  // both ends of the spring between the first and the last point
}

TEST_CASE("removed springs are as if they had never been there", "[springs][kernel]") {
  NetDesc d = thicket(200, 900, true, true);
  Pass pass(d, kernels_of(true), 1);
  for (std::uint32_t k = 0; k < 900; k += 7) {
    pass.layout.remove(k);
    d.springs[k].stiffness = d.springs[k].damping = 0;
  }
  const Vec3 outside(1, 2, 3);
  pass.run(d, outside);
  const std::vector<Vec3> expected = reference(d, outside);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) wrong += !(pass.f[i] == expected[i]);
  CHECK(wrong == 0);
}

TEST_CASE("snapped springs are found at any width", "[springs][kernel][threads]") {
  const bool wide = GENERATE(false, true);
  const int threads = GENERATE(1, 3);
  NetDesc d = thicket(500, 5003, false, false);
  for (std::size_t k = 0; k < d.springs.size(); k += 3)
    if (d.springs[k].rest_length > 0) d.springs[k].break_strain = Real(0.4);
  Pass pass(d, kernels_of(wide), threads);
  REQUIRE(pass.layout.find_snapped(d.points, pass.arrays, threads > 1 ? &pass.jobs : nullptr));
  std::size_t wrong = 0, found = 0;
  for (std::uint32_t k = 0; k < d.springs.size(); ++k) {
    const SpringDesc& s = d.springs[k];
    const Real longest = s.rest_length * (1 + s.break_strain);
    const Vec3 dx = d.points[s.j] - d.points[s.i];
    const bool expected = s.break_strain < kInfinity && dot(dx, dx) > longest * longest;
    const bool got = pass.layout.snapped()[k / 8] >> (k % 8) & 1;
    wrong += got != expected, found += got;
  }
  CHECK(wrong == 0);
  CHECK(found > 300);
  for (auto& x : d.points) x = Vec3(0, 0, 0);
  CHECK_FALSE(pass.layout.find_snapped(d.points, pass.arrays, nullptr));
}

TEST_CASE("a large net runs alike with any threads and kernels, and allocates nothing", "[springs][kernel][threads]") {
  const char* integrator = GENERATE("symplectic_euler", "velocity_verlet", "rk4");
  CAPTURE(integrator);
  NetDesc d = thicket(2000, 6000, true, true);
  for (SpringDesc& s : d.springs) s.stiffness *= Real(0.01), s.rest_length = -1;
  d.springs[3000].rest_length = Real(0.25);
  d.integrator = integrator;
  std::uint64_t first = 0;
  for (const int threads : {1, 2, 4})
    for (const char* kernels : {"auto", "plain"}) {
      CAPTURE(threads, kernels);
      WorldDesc desc;
      desc.threads = threads;
      desc.systems["springs"].set("kernels", std::string(kernels));
      World w(desc, kSpringsOnly);
      w.need<Springs>().add_net(d);
      step(w, 2);
      const std::uint64_t before = w.allocations();
      step(w, 8);
      CHECK(w.allocations() == before);
      CHECK(w.is_finite());
      if (first == 0) first = w.hash();
      CHECK(w.hash() == first);
    }
}
