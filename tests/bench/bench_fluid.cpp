// Microseconds per particle and step of a fluid's solvers, by row of the plan, beside a plain loop: the density sum of
// the same particles over their neighbours, one pair at a time.
//   bench_fluid [spacing = 0.025] [steps = 20] [solver] [substeps = 4] [threads = 1]
// A column of 1 x 1 x 0.5 m collapses in a tank (as in ../shared/peers: 6,859 particles are spacing 0.042). A step of
// wcsph is one of its own. The least of the steps counts, because the machine may be shared. With a solver: it alone,
// at the defaults of a world, for one simulated second; processor time (of several threads: time on the clock),
// substeps, iterations, error of the density and hash.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "base/jobs.h"
#include "feder/profile.h"
#include "fluid/tank.h"
#include "neighbors/neighbor_search.h"

using namespace feder;

namespace {

double seconds() { return 1e-9 * static_cast<double>(clock_nanoseconds()); }

// Cubic spline over lists, as one writes it down; microseconds per particle.
double plain_density(const std::vector<Vec3>& x, Real spacing, double& pairs) {
  Arena arena("bench");
  JobPool one(1);
  NeighborLists lists(arena);
  const auto search = find_variant(neighbor_searches(), "grid", "neighbor search").make(arena, Params());
  std::vector<Real> points;
  for (const Vec3& p : x) points.insert(points.end(), {p[0], p[1], p[2], 0});
  const Real support = 2 * spacing;
  search->find(points, support, one, lists);
  std::vector<Real> density(x.size());
  double least = 1e9;
  pairs = 0;
  for (std::uint32_t n : lists.count) pairs += n;
  pairs /= static_cast<double>(x.size());
  for (int k = 0; k < 10; ++k) {
    const double t = seconds();
    for (std::uint32_t i = 0; i < x.size(); ++i) {
      Real sum = 0;
      for (const std::uint32_t j : lists.row(i)) {
        const Real u = length(Vec3(x[i] - x[j])) / support, a = 1 - u, b = std::max(Real(0), 1 - 2 * u);
        sum += 2 * a * a * a - b * b * b;
      }
      density[i] = sum;
    }
    least = std::min(least, seconds() - t);
  }
  std::printf("  (sum of the first: %g)\n", static_cast<double>(density[0]));
  return least / static_cast<double>(x.size()) * 1e6;
}

// The column in its tank.
struct Collapse {
  Collapse(const char* solver, Real spacing, int substeps, int threads = 1)
      : w(world_desc(substeps, threads), fluid_catalog()) {
    add_tank(w, vec3(4, 0, Real(0.5)));
    FluidDesc d;
    d.solver = solver, d.spacing = spacing, d.max_substeps = 1000;
    id = add_water(w, d, vec3(1, 1, Real(0.5)));
  }
  static WorldDesc world_desc(int substeps, int threads) {
    WorldDesc d = fluid_world(3, threads);
    d.dt = Real(1) / 60, d.substeps = substeps;
    return d;
  }
  // The rows of the plan that take more than half a per cent of all steps.
  void print_rows() {
    double total = 0;
    for (const PlanNode& row : w.plan().nodes())
      if (!row.is_loop) total += row.counter.total_nanoseconds();
    for (const PlanNode& row : w.plan().nodes()) {
      const double share = row.counter.total_nanoseconds() / total;
      if (!row.is_loop && share > 0.005) std::printf("  %5.1f %%  %s / %s\n", 100 * share, row.system, row.name);
    }
  }
  World w;
  ObjectId id;
};

void bench(const char* solver, Real spacing, int steps) {
  Collapse c(solver, spacing, solver[0] == 'p' ? 2 : 1);
  World& w = c.w;
  const ObjectId id = c.id;
  Fluid& f = w.need<Fluid>();
  for (int k = 0; k < 12; ++k) w.step();
  const double count = static_cast<double>(f.particle_count(id));
  double least = 1e9;
  for (int k = 0; k < steps; ++k) {
    const std::uint64_t before = f.solver_substeps(id);
    const double t = seconds();
    w.step();
    least = std::min(least, (seconds() - t) / static_cast<double>(f.solver_substeps(id) - before) / count * 1e6);
  }
  double pairs = 0;
  const double plain = plain_density(places(w, id), spacing, pairs);
  std::printf(
      "%s: %.0f particles, %.1f neighbours: %.3f us per particle and step = %.1f plain density sums of %.3f us\n",
      solver, count, pairs, least, least / plain, plain);
  c.print_rows();
}

void second(const char* solver, Real spacing, int substeps, int threads) {
  Collapse c(solver, spacing, substeps, threads);
  const auto now = [&] { return threads > 1 ? seconds() : static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  World& w = c.w;
  const ObjectId id = c.id;
  Fluid& f = w.need<Fluid>();
  double error = 0, taken = 0;
  for (int k = 0; k < 60; ++k) {
    const double from = now();
    w.step();
    taken += now() - from;
    double mean = 0, most = 0;
    w.query<Fluid>()->density_error(id, mean, most);
    error += mean / 60;
  }
  const double count = static_cast<double>(f.particle_count(id)), steps = static_cast<double>(f.solver_substeps(id)),
               iterations = static_cast<double>(f.solver_iterations(id));
  std::printf(
      "%s: %.0f particles, a second in %.2f s: %.0f substeps, %.1f iterations in each, mean error %.3f %%, "
      "%.3f us per particle and substep, hash %016llx\n",
      solver, count, taken, steps, iterations / steps, 100 * error, 1e6 * taken / count / steps,
      static_cast<unsigned long long>(w.hash()));
  c.print_rows();
}

}  // namespace

int main(int argc, char** argv) {
  const Real spacing = argc > 1 ? static_cast<Real>(std::atof(argv[1])) : Real(0.025);
  const auto option = [&](int at, int otherwise) { return argc > at ? std::atoi(argv[at]) : otherwise; };
  if (argc > 3) return second(argv[3], spacing, option(4, 4), option(5, 1)), 0;
  bench("pbf", spacing, option(2, 20));
  bench("wcsph", spacing, option(2, 20));
}
