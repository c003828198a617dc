// Stability maps of fluids, by solver: a column that stands, softer and stiffer, and a beam, lighter and heavier than
// the fluid, each at several rates of steps; the column with few and many substeps, and little and much to spend in
// each; and narrow columns, fine and coarse, shallow and deep, with few and many iterations: what throws particles
// above its level has diverged. What a solver cannot hold at its budget it says in a warning, which is the entity of
// the cell.
#include <algorithm>
#include <cmath>

#include "study/fluid_scene.h"
#include "study/stability_problem.h"

namespace feder {
namespace {

constexpr double kGravity = 9.81, kSpacing = 1.0 / 16, kTank = 1, kLevel = 0.5;  // m
constexpr double kDensity = 1000, kSeconds = 2;
constexpr int kSubsteps = 4;
constexpr double kBeam = 0.25;  // m, side of the beam

struct FluidCell {
  std::unique_ptr<World> world;
  ObjectId water, body;
  double low = NAN, high = NAN;          // where it belongs, m: the fluid's middle, or the beam's lower side
  double level = kLevel, width = kTank;  // m
  double highest = INFINITY;             // m, no particle may be higher
};

bool takes_stiffness(const std::string& solver) {
  Arena unused("stability");
  return find_variant(fluid_solvers(), solver, "fluid solver").make(unused, Params())->takes_stiffness();
}

FluidDesc fluid_of(const std::string& solver) {
  FluidDesc f;
  f.solver = solver;
  return f;
}

FluidCell tank(FluidDesc f, double rate, int substeps, double width = kTank, double spacing = kSpacing) {
  FluidCell c;
  c.world = make_tank(awake_world(kGravity, 1 / rate, substeps), width);
  f.spacing = static_cast<Real>(spacing);
  c.water = c.world->need<Fluid>().add_fluid(f);
  return c;
}

// Lattice points of the tank up to `level`, without those in a beam at the middle from `under` on.
void fill(FluidCell& c, double under) {
  std::vector<Vec3> points;
  for (double y = kSpacing / 2; y < kLevel; y += kSpacing)
    for (double x = kSpacing / 2; x < kTank; x += kSpacing) {
      if (y > under && std::fabs(x - kTank / 2) < kBeam / 2) continue;
      points.push_back(Vec3(static_cast<Real>(x), static_cast<Real>(y), 0));
    }
  c.world->need<Fluid>().fill(c.water, points, Vec3::Zero());
}

// x = bulk modulus, y = steps a second. Under its own weight rho g (Y - y) = K ln(1 + p/K) of p = K (rho'/rho - 1): the
// middle is at 1/a - Y/(a H), Y = ln(1 + a H)/a, a = rho g/K. A solver that has its stiffness from a wanted
// compression, or none, is asked for the one at the ground, and may be stiffer.
FluidCell column(const std::string& solver, double x, double y) {
  const double a = kDensity * kGravity / x, squeezed = std::clamp(a * kLevel, 1e-4, 0.2);
  FluidDesc f = fluid_of(solver);
  f.stiffness = static_cast<Real>(x), f.compression = static_cast<Real>(squeezed);
  FluidCell c = tank(f, y, kSubsteps);
  fill(c, kLevel);
  c.low = c.high = a * kLevel > 1e-3 ? 1 / a - std::log1p(a * kLevel) / (a * a * kLevel) : kLevel / 2;
  if (!takes_stiffness(solver)) c.low = (1 - squeezed) * kLevel / 2, c.high = kLevel / 2;
  return c;
}

// x = density ratio, y = steps a second.
FluidCell floating(const std::string& solver, double x, double y) {
  FluidCell c = tank(fluid_of(solver), y, kSubsteps);
  const double under = kLevel - std::min(x, 1.0) * kBeam;
  fill(c, under);
  c.body = add_beam(*c.world, kBeam, kBeam, kDensity * x, Vec3d(kTank / 2, under + kBeam / 2, 0));
  // the surface is known to a spacing; one as dense as the fluid may be anywhere in it
  c.low = x < 1 ? under - kSpacing : 0, c.high = x > 1 ? 0.2 * kSpacing : under + kSpacing;
  return c;
}

// x = substeps, y = iterations, or steps of its own at most, in each.
FluidCell spent(const std::string& solver, double x, double y) {
  FluidDesc f = fluid_of(solver);
  f.iterations = f.max_substeps = static_cast<int>(y);
  FluidCell c = tank(f, 60, static_cast<int>(x));
  fill(c, kLevel);
  c.low = c.high = kLevel / 2;
  return c;
}

// A column eight spacings wide, 60 steps a second, four substeps.
FluidCell narrow(FluidDesc f, double spacing, double layers) {
  constexpr int kWide = 8;
  FluidCell c = tank(f, 60, kSubsteps, kWide * spacing, spacing);
  std::vector<Vec3> points;
  for (int y = 0; y < static_cast<int>(layers); ++y)
    for (int x = 0; x < kWide; ++x)
      points.push_back(static_cast<Real>(spacing) *
                       Vec3(static_cast<Real>(x) + Real(0.5), static_cast<Real>(y) + Real(0.5), 0));
  c.world->need<Fluid>().fill(c.water, points, Vec3::Zero());
  c.level = layers * spacing, c.width = kWide * spacing;
  c.highest = c.level + 2 * spacing;
  c.low = c.high = c.level / 2;
  return c;
}

// x = spacing, y = layers.
FluidCell depth(const std::string& solver, double x, double y) { return narrow(fluid_of(solver), x, y); }

// x = iterations, y = layers, of 6 mm: a solver that does not iterate takes its own count of steps.
FluidCell iterations(const std::string& solver, double x, double y) {
  FluidDesc f = fluid_of(solver);
  f.iterations = static_cast<int>(x);
  return narrow(f, 0.006, y);
}

struct FluidMapRow {
  StabilityProblemInfo info;
  FluidCell (*make)(const std::string& solver, double x, double y);
};

std::vector<FluidMapRow> rows() {
  const StabilityAxis rate = {"rate", "steps per second", "1/s", true, {15, 30, 60, 120, 240}, {15, 60, 240}};
  const StabilityAxis layers = {"layers", "layers", "", true, {8, 25, 50, 100, 200}, {8, 25}};
  return {{{"water_column",
            "half a metre of fluid stands in a tank for 2 s, four substeps",
            {"stiffness", "bulk modulus", "Pa", true, decades(0, 8), {1, 1e4, 1e8}},
            rate},
           &column},
          {{"floating",
            "a beam floats in a tank, or sinks, four substeps",
            {"ratio", "density ratio", "", true, decades(-2, 2), decades(-2, 2)},
            rate},
           &floating},
          {{"water_substeps",
            "half a metre of fluid stands in a tank for 2 s, 60 steps/s",
            {"substeps", "substeps", "", true, {1, 2, 4, 8, 16}, {1, 4, 16}},
            {"spent", "iterations, or solver substeps at most, in a substep", "", true, {1, 2, 4, 8, 16}, {1, 4, 16}}},
           &spent},
          {{"water_depth",
            "a column eight spacings wide stands for 2 s, 60 steps/s, four substeps",
            {"spacing", "spacing", "m", true, {0.001, 0.003, 0.006, 0.0125, 0.025, 0.05, 0.1}, {0.001, 0.006, 0.05}},
            layers},
           &depth},
          {{"water_iterations",
            "a column of 6 mm, eight spacings wide, stands for 2 s, 60 steps/s, four substeps",
            {"iterations", "iterations", "", true, {1, 2, 4, 8, 16, 32}, {1, 4, 32}},
            layers},
           &iterations}};
}

// Of the end state: how far the fluid's middle, or the beam, is from where it belongs, by the level.
double error_of(FluidCell& c) {
  double at = 0;
  if (c.body) {
    at = static_cast<double>(c.world->need<Rigid>().pose(c.body).position[1]) - kBeam / 2;
  } else {
    std::vector<Vec3> x;
    c.world->need<Fluid>().positions(c.water, x);
    for (const Vec3& p : x) at += static_cast<double>(p[1]) / static_cast<double>(x.size());
  }
  return std::max({0.0, c.low - at, at - c.high}) / c.level;
}

// Did a particle leave upwards?
bool thrown(FluidCell& c) {
  if (!(c.highest < INFINITY)) return false;
  std::vector<Vec3> x;
  c.world->need<Fluid>().positions(c.water, x);
  return std::any_of(x.begin(), x.end(), [&c](const Vec3& p) { return static_cast<double>(p[1]) > c.highest; });
}

StabilityCell run_fluid(const FluidMapRow& row, const std::string& method, double x, double y,
                        const StabilityThresholds& limits) {
  FluidCell c = row.make(method, x, y);
  StabilityRun run{*c.world, kSeconds, kDensity * c.width * c.level * kGravity * c.level};
  run.left = [&c] { return thrown(c); };
  run.error = [&c] { return error_of(c); };
  return run_cell(run, x, y, limits);
}

}  // namespace

StabilityProblems fluid_stability() {
  StabilityProblems all;
  for (const FluidMapRow& row : rows())
    all.push_back(stability_table("fluid", row.info, solver_methods(fluid_solvers()),
                                  [row](const auto&... cell) { return run_fluid(row, cell...); }));
  return all;
}

}  // namespace feder
