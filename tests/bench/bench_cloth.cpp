// Nanoseconds per constraint and solver substep of a hung sheet, beside a plain loop of distance projections.
//   bench_cloth [vertices along a side = 100] [repeats = 60]
// All rows take turns within a repeat and the least of many repeats counts, because the machine may be shared.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "contact/surface_contact.h"
#include "feder/cloth.h"
#include "feder/profile.h"
#include "feder/world.h"

using namespace feder;

namespace {

constexpr int kSubsteps = 4, kSolverSubsteps = 20;
const SystemDescriptor* const kCloth[] = {&SurfaceContact::descriptor(), &Cloth::descriptor()};

ClothDesc sheet(int n, bool bends, bool self) {
  ClothDesc d;
  d.nx = d.ny = static_cast<std::uint32_t>(n);
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
  d.stretch = 10000;
  d.bend = bends ? Real(1e-6) : Real(0);
  d.damping = 0;
  d.substeps = kSolverSubsteps / kSubsteps;
  d.self_collision = self;
  d.thickness = Real(0.3) / static_cast<Real>(n);
  d.pin_names = {"top"};
  return d;
}

// The textbook: predict, project each distance in turn, velocities from what moved.
struct PlainLoop {
  struct Link {
    std::uint32_t a, b;
    Real rest, compliance, multiplier;
  };
  explicit PlainLoop(int n) {
    const auto at = [&](int x, int z) { return static_cast<std::uint32_t>(z * n + x); };
    const Real cell = Real(1) / static_cast<Real>(n - 1);
    for (int z = 0; z < n; ++z)
      for (int x = 0; x < n; ++x) {
        place.push_back(Vec3(static_cast<Real>(x) * cell, static_cast<Real>(-z) * cell, 0));
        inv_mass.push_back(z == 0 ? Real(0) : 1 / (Real(0.2) * cell * cell));
        const auto link = [&](int i, int k) {
          if (i < 0 || i >= n || k >= n) return;
          const Vec3 d(static_cast<Real>(i - x) * cell, static_cast<Real>(k - z) * cell, 0);
          links.push_back({at(x, z), at(i, k), length(d), Real(1e-4), 0});
        };
        link(x + 1, z), link(x, z + 1), link(x + 1, z + 1), link(x - 1, z + 1);
      }
    speed.assign(place.size(), Vec3(0, 0, 0));
    before = place;
  }
  void step(Real h) {
    for (std::size_t i = 0; i < place.size(); ++i) {
      before[i] = place[i];
      if (inv_mass[i] == 0) continue;
      speed[i] += Vec3(0, Real(-9.81) * h, 0);
      place[i] += h * speed[i];
    }
    for (Link& l : links) {
      l.multiplier = 0;
      const Vec3 d = place[l.b] - place[l.a];
      const Real size = length(d), w = inv_mass[l.a] + inv_mass[l.b], alpha = l.compliance / (h * h);
      if (w == 0) continue;
      const Real change = (l.rest - size - alpha * l.multiplier) / (w + alpha);
      l.multiplier += change;
      const Vec3 push = d * (change / size);
      place[l.a] -= inv_mass[l.a] * push, place[l.b] += inv_mass[l.b] * push;
    }
    for (std::size_t i = 0; i < place.size(); ++i) speed[i] = (place[i] - before[i]) / h;
  }
  std::vector<Vec3> place, before, speed;
  std::vector<Real> inv_mass;
  std::vector<Link> links;
};

struct Whole {
  Whole(int n, int threads, bool bends, bool self, const char* kernels) : world(desc(threads), kCloth) {
    ClothDesc d = sheet(n, bends, self);
    d.solver_options.set("kernels", std::string(kernels));
    id = world.need<Cloth>().add_cloth(d);
    for (int k = 0; k < 3; ++k) world.step();
    allocations = world.allocations();
  }
  static WorldDesc desc(int threads) {
    WorldDesc w;
    w.threads = threads, w.substeps = kSubsteps, w.dt = 1.0 / 60, w.sleeping = false;
    return w;
  }
  World world;
  ObjectId id;
  std::uint64_t allocations = 0;
};

struct Entry {
  const char* name;
  double constraints;
  Whole* whole;
  double least = 1e30;
};

}  // namespace

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 100, repeats = argc > 2 ? std::atoi(argv[2]) : 60;
  if (n < 3 || n > 2000 || repeats < 1) return std::fputs("bench_cloth [vertices along a side] [repeats]\n", stderr), 2;
  PlainLoop plain(n);
  const double links = 2.0 * n * (n - 1) + 2.0 * (n - 1) * (n - 1), hinges = 2.0 * n * (n - 2) + (n - 1.0) * (n - 1.0);
  Whole stretch(n, 1, false, false, "auto"), lanes(n, 1, false, false, "plain"), two(n, 2, false, false, "auto");
  Whole bends(n, 1, true, false, "auto"), self(n, 1, true, true, "auto");
  Entry rows[] = {{"plain loop over links", links, nullptr},
                  {"links, 1 thread", links, &stretch},
                  {"links, no AVX2", links, &lanes},
                  {"links, 2 threads", links, &two},
                  {"links and hinges, 1 thread", links + hinges, &bends},
                  {"the same with self-contact", links + hinges, &self}};
  for (int k = 0; k < repeats; ++k)
    for (Entry& e : rows) {
      const std::uint64_t start = clock_nanoseconds();
      if (e.whole)
        e.whole->world.step();
      else
        for (int i = 0; i < kSolverSubsteps; ++i) plain.step(Real(1) / 60 / kSolverSubsteps);
      e.least = std::min(e.least, static_cast<double>(clock_nanoseconds() - start));
    }
  std::printf(
      "sheet of %d x %d vertices, %.0f links, %.0f hinges, xpbd, %d solver substeps of 1/60 s, %s, least of %d\n", n, n,
      links, hinges, kSolverSubsteps, kRealName, repeats);
  for (const Entry& e : rows)
    std::printf("  %-30s %7.3f ms/step  %7.3f ns per constraint and solver substep  %5.2f times the plain loop%s\n",
                e.name, e.least / 1e6, e.least / kSolverSubsteps / e.constraints,
                rows[0].least / rows[0].constraints / (e.least / e.constraints),
                e.whole && e.whole->world.allocations() != e.whole->allocations ? ", ALLOCATES" : "");
  std::printf("  largest strain %.4f; hash %s\n",
              static_cast<double>(stretch.world.need<Cloth>().max_strain(stretch.id)),
              stretch.world.hash() == two.world.hash() && stretch.world.hash() == lanes.world.hash()
                  ? "the same for 1 and 2 threads and without AVX2"
                  : "DIFFERS between threads or kernels");
  return 0;
}
