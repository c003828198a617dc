// A column of still water, eight spacings wide: what it does that still water does not.
#pragma once
#include <algorithm>
#include <cmath>

#include "fluid/tank.h"

namespace feder {

struct StillWater {
  int dimension = 2, layers = 25, iterations = 4, substeps = 4;
  double spacing = 0.0125;             // m
  double seconds = 10, calm = 2;       // s; after `calm` nobody may be fast
  double budget = INFINITY;            // particles times solver substeps: where `seconds` would cost more, 2 s do
  double tolerance = 0;                // per cent; 0: the default
  std::string solver = "pbf", kernel;  // empty: the solver's
  std::string integrator = "leapfrog";
};

struct StillWaterResult {
  double top = 0;  // largest height of a particle, by H + 2 d (wcsph: 1.01 H + 2 d)
  // Largest speed once calm, by what is allowed: max(0.2 sqrt(g H), 2 g h of the inner substep); wcsph: 0.26.
  double speed = 0;
  double burst = -1;       // s, when either first went beyond; -1: never
  double warned = -1;      // s, of the first warning
  double noise = 0;        // m/s, largest root mean square of the speeds once calm
  double excess = 0;       // mean over particles and the last half of the time of max(0, density ratio - 1)
  double per_step = 0;     // inner substeps in a substep of the world, mean
  bool at_limit = false;   // they have been as many as max_substeps allows
  std::uint64_t hash = 0;  // of the end
  bool burst_unwarned() const { return burst >= 0 && (warned < 0 || warned > burst); }
};

// Stops where it bursts.
inline StillWaterResult run_still_water(const StillWater& s) {
  constexpr double g = 9.81;
  WorldDesc desc = fluid_world(s.dimension);
  desc.dt = 1.0 / 60, desc.substeps = s.substeps;
  World w(desc, fluid_catalog());
  const double height = s.layers * s.spacing, width = 8 * s.spacing;
  // wcsph sinks into its compression, swings up as far, and deep columns swing for 6 s
  const bool swings = s.solver == "wcsph";
  const double highest = (swings ? 1.01 : 1) * height + 2 * s.spacing,
               fastest = (swings ? 0.26 : 0.2) * std::sqrt(g * height);
  add_tank(w, vec3(static_cast<Real>(width), 0, static_cast<Real>(width)));
  FluidDesc d;
  d.solver = s.solver, d.kernel = s.kernel, d.integrator = s.integrator, d.spacing = static_cast<Real>(s.spacing),
  d.iterations = s.iterations;
  if (s.tolerance > 0) d.tolerance = static_cast<Real>(s.tolerance);
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(d);
  std::vector<Vec3> points;
  for (int y = 0; y < s.layers; ++y)
    for (int x = 0; x < 8; ++x)
      for (int z = 0; z < (s.dimension == 2 ? 1 : 8); ++z) {
        const Real e = static_cast<Real>(s.spacing);
        points.push_back(e * vec3(static_cast<Real>(x) + Real(0.5), static_cast<Real>(y) + Real(0.5),
                                  s.dimension == 2 ? Real(0) : static_cast<Real>(z) + Real(0.5)));
      }
  f.fill(id, points, Vec3::Zero());
  StillWaterResult r;
  int steps = static_cast<int>(s.seconds * 60 + 0.5);
  std::vector<Vec3> v;
  std::uint64_t own = 0;
  for (int k = 0; k < steps; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && r.warned < 0) r.warned = w.time();
    double top = 0, speed = 0;
    for (const Vec3& x : places(w, id)) top = std::max(top, std::isfinite(x[1]) ? static_cast<double>(x[1]) : 1e9);
    f.velocities(id, v);
    double squares = 0;
    for (const Vec3& u : v) {
      speed = std::max(speed, static_cast<double>(length(u)));
      squares += static_cast<double>(dot(u, u));
    }
    const std::uint64_t taken = f.solver_substeps(id) - own;
    own += taken;
    const double h = desc.dt / static_cast<double>(std::max<std::uint64_t>(taken, 1));
    r.at_limit = r.at_limit || taken >= static_cast<std::uint64_t>(s.substeps * d.max_substeps);
    if (k == 14 && steps > 120 && static_cast<double>(own * points.size()) / 15 * steps > s.budget) steps = 120;
    r.top = std::max(r.top, top / highest);
    if (k >= s.calm * 60) r.noise = std::max(r.noise, std::sqrt(squares / static_cast<double>(v.size())));
    if (k >= s.calm * 60) r.speed = std::max(r.speed, speed / std::max(fastest, 2 * g * h));
    if (2 * k >= steps) {
      double mean = 0, most = 0;
      w.query<Fluid>()->density_error(id, mean, most);
      r.excess += mean / (steps / 2);
    }
    if (r.top > 1 || r.speed > 1 || !w.is_finite() || f.particle_count(id) != points.size()) {
      r.burst = w.time();
      break;
    }
  }
  r.hash = w.hash();
  r.per_step = static_cast<double>(own) / (60 * w.time() * s.substeps);
  return r;
}

}  // namespace feder
