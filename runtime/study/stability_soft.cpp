// Stability maps of soft bodies, by solver: a bar hung by its end, a beam clamped at one, and a body whose points were
// thrown anywhere. Nobody gives solver substeps: the library chooses them, and says in a warning where its cap ends
// that (then a wrong answer comes with that warning as the entity).
#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "contact/surface_contact.h"
#include "feder/soft.h"
#include "soft/solver.h"
#include "study/stability_problem.h"

namespace feder {
namespace {

constexpr double kSoftGravity = 9.81;
constexpr double kSoftDensity = 1000, kSoftSide = 0.1, kSoftLength = 0.4;  // kg/m^3, m, m

Catalog soft_catalog() {
  static const SystemDescriptor* const catalog[] = {&SurfaceContact::descriptor(), &Soft::descriptor()};
  return catalog;
}

struct SoftCell {
  std::unique_ptr<World> world;
  ObjectId soft;
  double seconds = 2;
  double energy = 1;  // J, scale
  double length = 1;  // m
  double expected = NAN;
  // Of the end state, by the length; NaN: not known.
  double (*error)(SoftCell&) = nullptr;
};

// A bar along `axis`, held at the end where it begins.
SoftCell held_bar(const std::string& solver, int axis, double young, double nu, double rate, double g) {
  SoftCell c;
  c.world = std::make_unique<World>(awake_world(g, 1 / rate), soft_catalog());
  Soft& soft = c.world->need<Soft>();
  SoftDesc d;
  Vec3 size = Vec3::Constant(static_cast<Real>(kSoftSide));
  size[axis] = static_cast<Real>(kSoftLength);
  d.shape = make_box(size[0], size[1], size[2]);
  d.resolution = 8;
  d.solver = solver;
  d.density = static_cast<Real>(kSoftDensity), d.young = static_cast<Real>(young), d.poisson = static_cast<Real>(nu);
  d.damping = Real(0.02), d.self_collision = false;
  c.soft = soft.add_soft(d);
  const Real end = (axis == 1 ? Real(0.5) : Real(-0.5)) * size[axis];
  for (std::size_t i = 0; i < soft.point_count(c.soft); ++i)
    if (std::fabs(soft.rest_point(c.soft, i)[axis] - end) < Real(1e-4)) soft.pin(c.soft, i);
  c.length = kSoftLength;
  c.energy = kSoftDensity * kSoftSide * kSoftSide * kSoftLength * std::fmax(g, 1) * kSoftLength;
  return c;
}

// Mean place of the free end along y, by its rest place.
double end_drop(const SoftCell& c, int axis) {
  const Soft& soft = c.world->need<Soft>();
  const double end = (axis == 1 ? -0.5 : 0.5) * kSoftLength;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < soft.point_count(c.soft); ++i) {
    const Vec3 rest = soft.rest_point(c.soft, i);
    if (std::fabs(double(rest[axis]) - end) > 1e-4) continue;
    sum += double(rest[1]) - double(soft.point(c.soft, i)[1]), count += 1;
  }
  return sum / count;
}

// x = young, y = poisson: it grows by rho g L^2/(2 E) where that is small.
SoftCell hung_bar(const std::string& solver, double x, double y) {
  SoftCell c = held_bar(solver, 1, x, y, 60, kSoftGravity);
  const double longer = kSoftDensity * kSoftGravity * kSoftLength * kSoftLength / (2 * x);
  c.expected = longer < 0.1 * kSoftLength ? longer : NAN;
  c.error = [](SoftCell& e) { return std::fabs(end_drop(e, 1) - e.expected); };
  return c;
}

// x = weight by stiffness, rho A g L^3/(E I); y = steps a second. Its end drops by x L/8 where that is small.
SoftCell clamped_beam(const std::string& solver, double x, double y) {
  const double young = 12 * kSoftDensity * kSoftGravity * std::pow(kSoftLength, 3) / (x * kSoftSide * kSoftSide);
  SoftCell c = held_bar(solver, 0, young, 0.3, y, kSoftGravity);
  c.expected = x <= 0.5 ? x * kSoftLength / 8 : NAN;
  c.error = [](SoftCell& e) { return std::fabs(end_drop(e, 0) - e.expected); };
  return c;
}

// x = young, y = steps a second: every point anywhere in the box of the body, without weight; back in shape after 5 s.
SoftCell scattered(const std::string& solver, double x, double y) {
  SoftCell c;
  c.world = std::make_unique<World>(awake_world(0, 1 / y), soft_catalog());
  Soft& soft = c.world->need<Soft>();
  SoftDesc d;
  d.shape = make_box(Real(0.2), Real(0.2), Real(0.2));
  d.resolution = 3;
  d.solver = solver;
  d.young = static_cast<Real>(x), d.damping = Real(0.02), d.self_collision = false;
  c.soft = soft.add_soft(d);
  Rng rng(11);
  const auto anywhere = [&] { return rng.uniform(Real(-0.1), Real(0.1)); };
  for (std::size_t i = 0; i < soft.point_count(c.soft); ++i) {
    const Real a = anywhere(), b = anywhere();
    soft.set_point(c.soft, i, vec3(a, b, anywhere()));
  }
  c.seconds = 5;
  c.length = 0.2;
  c.energy = 0.008 * x;
  c.expected = 0;
  c.error = [](SoftCell& e) {
    const Soft& s = e.world->need<Soft>();
    return e.length * std::fmax(double(s.max_strain(e.soft)), s.inverted(e.soft) > 0 ? 1 : 0);
  };
  return c;
}

struct SoftMapRow {
  StabilityProblemInfo info;
  SoftCell (*make)(const std::string& solver, double x, double y);
};

std::vector<SoftMapRow> soft_rows() {
  const StabilityAxis young = {"young", "Young's modulus", "Pa", true, decades(3, 9), {1e3, 1e5, 1e8}},
                      rate = {"rate", "steps per second", "1/s", true, {15, 30, 60, 120, 240}, {15, 120}};
  return {{{"soft_bar",
            "a bar of 8 x 2 x 2 cells hung by its end, 60 steps/s",
            young,
            {"poisson", "Poisson's ratio", "", false, {-0.5, 0, 0.3, 0.45, 0.49}, {0, 0.45}}},
           &hung_bar},
          {{"soft_cantilever",
            "a beam of 8 x 2 x 2 cells clamped at its end",
            {"gamma", "rho A g L^3/(E I)", "", true, decades(-3, 2), {1e-2, 1, 100}},
            rate},
           &clamped_beam},
          {{"soft_scatter", "a cube of 3 x 3 x 3 cells, every point thrown anywhere in it", young, rate}, &scattered}};
}

StabilityCell run_soft(const SoftMapRow& row, const std::string& method, double x, double y,
                       const StabilityThresholds& limits) {
  return checked_cell(x, y, [&](StabilityCell& cell) {
    SoftCell c = row.make(method, x, y);
    StabilityRun run{*c.world, c.seconds, c.energy};
    run.error = [&c] { return std::isnan(c.expected) ? NAN : c.error(c) / c.length; };
    cell = run_cell(run, x, y, limits);
  });
}

}  // namespace

StabilityProblems soft_stability() {
  StabilityProblems all;
  for (const SoftMapRow& row : soft_rows())
    all.push_back(stability_table("soft", row.info, solver_methods(soft_solvers()),
                                  [row](const auto&... cell) { return run_soft(row, cell...); }));
  return all;
}

}  // namespace feder
