// Nanoseconds per spring of a lattice's force pass and of a whole substep, beside a plain loop over the same springs.
//   bench_springs [springs = 100000] [repeats = 300]
// All rows take turns within a repeat and the least of many repeats counts, because the machine may be shared.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "base/jobs.h"
#include "feder/profile.h"
#include "feder/world.h"
#include "springs/net.h"

using namespace feder;

namespace {

const SystemDescriptor* const kSprings[] = {&Springs::descriptor()};

// Cubes with face and body diagonals, the last layer cut to the number of springs wanted.
NetDesc lattice(std::size_t springs, Real damping) {
  NetDesc d;
  int n = 2;
  while (13u * static_cast<std::size_t>(n * n * n) < springs * 23 / 20) ++n;
  const auto at = [&](int x, int y, int z) { return static_cast<std::uint32_t>((z * n + y) * n + x); };
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const Real wave = Real(0.01) * static_cast<Real>((x * 7 + y * 5 + z * 3) % 11);
        d.points.push_back(Vec3(static_cast<Real>(x) + wave, static_cast<Real>(y) - wave, static_cast<Real>(z)));
        d.masses.push_back(Real(0.1));
      }
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (dz < 0 || (dz == 0 && (dy < 0 || (dy == 0 && dx <= 0)))) continue;  // one of either direction
        for (int z = 0; z + dz < n; ++z)
          for (int y = std::max(0, -dy); y + std::max(0, dy) < n; ++y)
            for (int x = std::max(0, -dx); x + std::max(0, dx) < n; ++x)
              if (d.springs.size() < springs)
                d.springs.push_back({at(x, y, z), at(x + dx, y + dy, z + dz), 1000, damping,
                                     std::sqrt(static_cast<Real>(dx * dx + dy * dy + dz * dz)), kInfinity});
      }
  return d;
}

// What it costs without layout, lanes or threads: the loop of a textbook over arrays of structures.
struct PlainLoop {
  explicit PlainLoop(const NetDesc& d)
      : x(d.points), v(d.points.size(), Vec3(0, 0, 0)), f(x.size()), springs(d.springs) {}
  void run() {
    for (Vec3& force : f) force = Vec3(0, Real(-0.981), 0);
    for (const SpringDesc& s : springs) {
      const Vec3 d = x[s.j] - x[s.i];
      const Real len = length(d);
      Real tension = s.stiffness * (len - s.rest_length);
      if (s.damping > 0) tension += s.damping * dot(v[s.j] - v[s.i], d) / len;
      const Vec3 pull = d * (tension / len);
      f[s.i] += pull, f[s.j] -= pull;
    }
  }
  std::vector<Vec3> x, v, f;
  std::vector<SpringDesc> springs;
};

// The layout alone, as a net evaluates it.
struct Kernel {
  Kernel(const NetDesc& d, const SpringKernels& kernels, int threads)
      : jobs(threads), arrays(arena), layout(arena), x(d.points), v(x.size(), Vec3(0, 0, 0)), f(x.size()) {
    for (const SpringDesc& s : d.springs) arrays.add(s, s.rest_length);
    layout.choose(kernels);
    layout.build(arrays, static_cast<std::uint32_t>(x.size()));
  }
  void run() {
    layout.eval(
        x, v, jobs.threads() > 1 ? &jobs : nullptr, [](std::uint32_t) { return Vec3(0, Real(-0.981), 0); }, f);
  }
  Arena arena{"bench"};
  JobPool jobs;
  SpringArrays arrays;
  SpringLayout layout;
  std::vector<Vec3> x, v, f;
};

constexpr int kSubsteps = 8;  // passes in a row: what a pass finds in the caches is what the pass before left

struct Whole {
  Whole(const NetDesc& d, int threads, const char* kernels) : world(desc(threads, kernels), kSprings) {
    world.need<Springs>().add_net(d);
    world.step();
  }
  static WorldDesc desc(int threads, const char* kernels) {
    WorldDesc w;
    w.threads = threads, w.substeps = kSubsteps, w.dt = Real(1) / 240;
    w.systems["springs"].set("kernels", std::string(kernels));
    return w;
  }
  World world;
};

struct Entry {
  std::string name;
  std::function<void()> run;
  int calls = kSubsteps;
  double least = 1e30;
};

void report(const char* title, std::size_t springs, double damping, int repeats) {
  NetDesc d = lattice(springs, static_cast<Real>(damping));
  PlainLoop plain(d);
  const bool wide = __builtin_cpu_supports("avx2");
  Kernel lanes(d, kSpringKernelsPlain, 1), one(d, wide ? kSpringKernelsAvx2 : kSpringKernelsPlain, 1);
  Kernel two(d, wide ? kSpringKernelsAvx2 : kSpringKernelsPlain, 2);
  Whole step1(d, 1, "auto"), step2(d, 2, "auto"), step_plain(d, 1, "plain");
  std::vector<Entry> rows = {{"plain loop over springs", [&] { plain.run(); }},
                             {"force pass, no AVX2", [&] { lanes.run(); }},
                             {wide ? "force pass, AVX2" : "force pass (no AVX2 here)", [&] { one.run(); }},
                             {"force pass, AVX2, 2 threads", [&] { two.run(); }},
                             {"whole substep, 1 thread", [&] { step1.world.step(); }, 1},
                             {"whole substep, 2 threads", [&] { step2.world.step(); }, 1},
                             {"whole substep, no AVX2", [&] { step_plain.world.step(); }, 1}};
  for (int k = 0; k < repeats; ++k)
    for (Entry& e : rows) {
      const std::uint64_t start = clock_nanoseconds();
      for (int i = 0; i < e.calls; ++i) e.run();
      e.least = std::min(e.least, static_cast<double>(clock_nanoseconds() - start) / kSubsteps);
    }
  std::printf("%s: %zu points, %zu springs, symplectic_euler, %s, least of %d\n", title, d.points.size(),
              d.springs.size(), kRealName, repeats);
  for (const Entry& e : rows)
    std::printf("  %-32s %8.3f ns per spring   %5.2f times the plain loop\n", e.name.c_str(),
                e.least / static_cast<double>(d.springs.size()), rows[0].least / e.least);
  std::printf("  2 threads against 1: %.2f times (force pass), %.2f times (whole substep)\n",
              rows[2].least / rows[3].least, rows[4].least / rows[5].least);
  const std::uint64_t hash = step1.world.hash();
  std::printf("  hash after %d steps %016llx, %s\n\n", repeats + 1, static_cast<unsigned long long>(hash),
              hash == step2.world.hash() && hash == step_plain.world.hash()
                  ? "the same for 1 and 2 threads and without AVX2"
                  : "BUT OTHERS DIFFER");
}

}  // namespace

int main(int argc, char** argv) {
  const auto springs = static_cast<std::size_t>(argc > 1 ? std::atol(argv[1]) : 100000);
  const int repeats = argc > 2 ? std::atoi(argv[2]) : 300;
  if (springs < 1 || springs > 50000000 || repeats < 1)
    return std::fputs("bench_springs [springs] [repeats]\n", stderr), 2;
  report("lattice", springs, 0, repeats);
  report("lattice with damping", springs, 0.5, repeats);
  return 0;
}
