// Stability maps of fluids, by solver: a column that stands, softer and stiffer, and a beam, lighter and heavier than
// the fluid, each at several rates of steps. What a solver cannot hold at its budget it says in a warning, which is the
// entity of the cell.
#include <algorithm>
#include <cmath>

#include "collide/collide.h"
#include "couple/fluid_rigid.h"
#include "fluid/solver.h"
#include "study/stability_problem.h"
#include "world/world.h"

namespace feder {
namespace {

constexpr double kGravity = 9.81, kSpacing = 1.0 / 16, kTank = 1, kLevel = 0.5;  // m
constexpr double kSeconds = 2;
constexpr double kBeam = 0.25;  // m, side of the beam

struct FluidCell {
  std::unique_ptr<World> world;
  ObjectId water, body;
  double ratio = NAN;  // of the beam's density to the fluid's
};

std::vector<double> decades(int lo, int hi) {
  std::vector<double> out;
  for (int k = lo; k <= hi; ++k) out.push_back(std::pow(10.0, k));
  return out;
}

FluidCell tank(const std::string& solver, double rate, double stiffness) {
  static const SystemDescriptor* const catalog[] = {&Collide::descriptor(), &Rigid::descriptor(), &Fluid::descriptor(),
                                                    &FluidRigid::descriptor()};
  WorldDesc d;
  d.dimension = 2;
  d.gravity = Vec3(0, static_cast<Real>(-kGravity), 0);
  d.dt = 1 / rate;
  d.sleeping = false;
  FluidCell c;
  c.world = std::make_unique<World>(d, catalog);
  for (const Vec3& n : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(-1, 0, 0)}) {
    BodyDesc wall;
    wall.type = BodyType::fixed;
    wall.shape = make_plane(n, n[0] < 0 ? static_cast<Real>(-kTank) : Real(0));
    c.world->need<Rigid>().add_body(wall);
  }
  FluidDesc f;
  f.solver = solver;
  f.spacing = static_cast<Real>(kSpacing);
  f.stiffness = static_cast<Real>(stiffness);
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

// x = bulk modulus of pbf (wcsph derives its own), y = steps a second.
FluidCell column(const std::string& solver, double x, double y) {
  FluidCell c = tank(solver, y, x);
  fill(c, kLevel);
  return c;
}

// x = density ratio, y = steps a second.
FluidCell floating(const std::string& solver, double x, double y) {
  FluidCell c = tank(solver, y, 0);
  const double under = kLevel - std::min(x, 1.0) * kBeam;
  fill(c, under);
  BodyDesc b;
  b.shape = make_box(static_cast<Real>(kBeam), static_cast<Real>(kBeam), 1)->section();
  b.density = static_cast<Real>(1000 * x);
  b.position = Vec3(static_cast<Real>(kTank / 2), static_cast<Real>(under + kBeam / 2), 0);
  c.body = c.world->need<Rigid>().add_body(b);
  c.ratio = x;
  return c;
}

struct FluidMapRow {
  StabilityProblemInfo info;
  FluidCell (*make)(const std::string& solver, double x, double y);
};

const std::vector<FluidMapRow>& rows() {
  static const std::vector<double> rates = {15, 30, 60, 120, 240};
  static const std::vector<FluidMapRow> table = {
      {{"water_column", "half a metre of fluid stands in a tank for 2 s",
        {"stiffness", "bulk modulus (pbf)", "Pa", true, decades(0, 6)},
        {"rate", "steps per second", "1/s", true, rates}, false},
       &column},
      {{"floating", "a beam floats in a tank, or sinks",
        {"ratio", "density ratio", "", true, decades(-2, 2)},
        {"rate", "steps per second", "1/s", true, rates}, false},
       &floating}};
  return table;
}

const FluidMapRow* find_row(std::string_view name) {
  for (const FluidMapRow& r : rows())
    if (r.info.name == name) return &r;
  return nullptr;
}

// Of the end state: how far the fluid's middle, or the beam, is from where it belongs, by the level.
double error_of(FluidCell& c) {
  std::vector<Vec3> x;
  c.world->need<Fluid>().positions(c.water, x);
  if (c.body) {
    const double bottom = static_cast<double>(c.world->need<Rigid>().pose(c.body).position[1]) - kBeam / 2;
    const double want = c.ratio < 1 ? kLevel - c.ratio * kBeam : 0;
    // known to a spacing
    return std::max(0.0, std::fabs(bottom - want) - (c.ratio < 1 ? kSpacing : 0.2 * kSpacing)) / kLevel;
  }
  double mean = 0;
  for (const Vec3& p : x) mean += static_cast<double>(p[1]) / static_cast<double>(x.size());
  return std::fabs(mean - kLevel / 2) / kLevel;
}

double total(World& w) {
  const Energy e = w.energy();
  return e.kinetic + e.potential + e.elastic;
}

StabilityCell run_cell(const FluidMapRow& row, const std::string& solver, double x, double y, const StabilityThresholds& limits) {
  StabilityCell cell;
  cell.x = x, cell.y = y;
  FluidCell c = row.make(solver, x, y);
  World& w = *c.world;
  const double start = total(w), scale = 1000 * kTank * kLevel * kGravity * kLevel;
  const int steps = static_cast<int>(std::lround(kSeconds / w.desc().dt));
  double most = 0, late = 0, second = 0;
  for (int k = 0; k < steps; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning) cell.entity = w.events().warning_message(e);
    const double gained = total(w) - start;
    most = std::max(most, gained);
    if (4 * k >= 3 * steps) late = std::max(late, gained);
    else if (4 * k >= steps && 2 * k < steps) second = std::max(second, gained);
    const bool finite = w.is_finite();
    if (finite && std::isfinite(gained) && gained < limits.energy * scale) continue;
    cell.verdict = finite ? Verdict::diverged : Verdict::nan;
    cell.t_fail = w.time();
    break;
  }
  cell.energy_ratio = most / scale;
  if (cell.verdict != Verdict::stable) return cell;
  cell.error = error_of(c);
  if (late > limits.growth * second && late > (limits.growth_start - 1) * scale) cell.verdict = Verdict::growing;
  else if (cell.error > limits.inaccurate) cell.verdict = Verdict::inaccurate;
  return cell;
}

}  // namespace

bool is_fluid_stability(std::string_view problem) { return find_row(problem) != nullptr; }

std::vector<StabilityProblemInfo> fluid_stability_infos() {
  std::vector<StabilityProblemInfo> out;
  for (const FluidMapRow& r : rows()) out.push_back(r.info);
  return out;
}

StabilityResult run_fluid_stability(const StabilityPlan& plan) {
  const FluidMapRow& row = *find_row(plan.problem);
  std::vector<std::string> methods = plan.methods;
  if (methods.empty())
    for (const Variant<FluidSolver>& v : fluid_solvers()) methods.push_back(v.name);
  StabilityResult result;
  result.thresholds = plan.thresholds;
  result.real = kRealName;
  for (const std::string& m : methods) {
    find_variant(fluid_solvers(), m, "fluid solver");
    StabilityMap map;
    map.problem = row.info.name, map.method = m;
    map.x = row.info.x, map.y = row.info.y;
    if (!plan.x_values.empty()) map.x.values = plan.x_values;
    if (!plan.y_values.empty()) map.y.values = plan.y_values;
    std::size_t stable = 0;
    for (const double y : map.y.values)
      for (const double x : map.x.values) {
        map.cells.push_back(run_cell(row, m, x, y, plan.thresholds));
        stable += map.cells.back().verdict == Verdict::stable;
      }
    map.stable_share = static_cast<double>(stable) / static_cast<double>(map.cells.size());
    result.maps.push_back(std::move(map));
  }
  return result;
}

}  // namespace feder
