// Extreme inputs of fluids: descriptions that must be refused, particles in one place, far away or at random, and
// beams and budgets far from the usual, by every solver.
#include <cmath>

#include "base/rng.h"
#include "study/extreme.h"
#include "study/fluid_scene.h"

namespace feder {
namespace {

constexpr double kSpacing = 0.05, kGravity = 9.81;

// A tank 1 m wide, and what its fluid does.
struct FluidScene {
  explicit FluidScene(const std::string& solver) : world(make_tank(awake_world(kGravity), 1)) {
    desc.solver = solver, desc.spacing = static_cast<Real>(kSpacing);
  }
  Fluid& fluid() { return world->need<Fluid>(); }
  void fill(const std::vector<Vec3>& points) {
    id = fluid().add_fluid(desc);
    fluid().fill(id, points, Vec3::Zero());
    count = points.size();
  }
  void run(double seconds) {
    for (int k = 0; k < static_cast<int>(seconds * 60 + 0.5); ++k) {
      world->step();
      warned.read(*world, id);
      fluid().velocities(id, velocities);
      for (const Vec3& v : velocities) fastest = std::max(fastest, static_cast<double>(length(v)));
    }
    fluid().positions(id, positions);
  }
  // How far a particle is below the floor or beyond the walls, m.
  double beyond() const {
    double most = 0;
    for (const Vec3& x : positions)
      most = std::max(most, static_cast<double>(std::max({Real(0), Real(-x[1]), Real(-x[0]), Real(x[0] - 1)})));
    return most;
  }
  // Nothing lost, nothing beyond the walls, but for rounding or what is allowed.
  bool kept(double allowed = 1e-4 * kSpacing) {
    return world->is_finite() && fluid().particle_count(id) == count && beyond() < allowed;
  }
  double middle() const {
    double sum = 0;
    for (const Vec3& x : positions) sum += static_cast<double>(x[1]);
    return sum / static_cast<double>(positions.size());
  }
  ExtremeOutcome outcome(bool good, const std::string& detail) {
    return outcome_of(good, world->is_finite() ? Verdict::inaccurate : Verdict::nan,
                      detail + ", " + labelled("fastest, m/s", fastest) +
                          (beyond() > 0 ? ", " + labelled("beyond the walls, m", beyond()) : "") + warned.words());
  }

  std::unique_ptr<World> world;
  FluidDesc desc;
  ObjectId id;
  std::size_t count = 0;
  std::vector<Vec3> positions, velocities;
  double fastest = 0;
  WarningRecord warned;
};

std::vector<Vec3> block(int wide, int high) {
  std::vector<Vec3> points;
  for (int j = 0; j < high; ++j)
    for (int i = 0; i < wide; ++i)
      points.push_back(Vec3(static_cast<Real>((i + 0.5) * kSpacing), static_cast<Real>((j + 0.5) * kSpacing), 0));
  return points;
}

ExtremeOutcome refused_fluid(const char* word, void (*spoil)(FluidDesc&)) {
  FluidScene s("pbf");
  s.fill(block(4, 4));
  FluidDesc d = s.desc;
  spoil(d);
  return expect_refusal(
      word, [&] { s.fluid().add_fluid(d); }, [&] { return s.world->hash(); });
}

// They have no direction to part in but the one of a fixed rule.
ExtremeOutcome on_one_spot(const std::string& solver, double count) {
  FluidScene s(solver);
  s.desc.max_substeps = 8;
  const Vec3 spot(Real(0.5), Real(0.5), 0);
  s.fill(std::vector<Vec3>(static_cast<std::size_t>(count), spot));
  s.run(0.05);
  double far = 0;
  for (const Vec3& x : s.positions) far = std::max(far, static_cast<double>(length(Vec3(x - spot))));
  // walls are not asked to hold what passes hundreds of tanks in a substep. More than a thousand times the speed of a
  // fall through the tank has no measure: it must be said
  const bool burst = s.fastest > 1e3 * std::sqrt(kGravity);
  ExtremeOutcome out =
      s.outcome(s.kept(1) && far > kSpacing && (!burst || s.warned.named), labelled("largest distance, m", far));
  if (out.as_expected && burst) out.verdict = Verdict::diverged;
  return out;
}

// One particle 100 tanks up: it falls, and the others stand.
ExtremeOutcome stray(const std::string& solver, double height) {
  FluidScene s(solver);
  std::vector<Vec3> points = block(20, 10);
  points[77] = Vec3(Real(0.5), static_cast<Real>(height), 0);
  s.fill(points);
  s.run(1);
  const double fallen = height - static_cast<double>(s.positions[77][1]), wanted = 0.5 * kGravity;
  const double middle = (s.middle() * 200 - (height - fallen)) / 199;
  return s.outcome(s.kept() && std::fabs(fallen / wanted - 1) < 0.05 && std::fabs(middle - 0.25) < kSpacing,
                   labelled("it fell, m", fallen) + ", " + labelled("middle of the others, m", middle));
}

ExtremeOutcome all_random(const std::string& solver, double count) {
  FluidScene s(solver);
  Rng rng(7);
  std::vector<Vec3> points;
  for (int i = 0; i < static_cast<int>(count); ++i) {
    const double x = rng.unit(), y = 0.5 * rng.unit();
    points.push_back(Vec3(static_cast<Real>(x), static_cast<Real>(y), 0));
  }
  s.fill(points);
  s.run(3);
  // half a metre of fluid that was thrown in, not blown up: 5 m/s are a fall of more than a metre
  return s.outcome(s.kept() && s.fastest < 5 && std::fabs(s.middle() - 0.25) < 1.5 * kSpacing,
                   labelled("middle, m", s.middle()));
}

// A beam of `ratio` times the density.
ExtremeOutcome beam(const std::string& solver, double ratio) {
  FluidScene s(solver);
  s.desc.viscosity = 2;
  s.fill(block(20, 8));
  const ObjectId body = add_beam(*s.world, 0.3, 0.2, 1000 * ratio, Vec3d(0.5, 0.6, 0));
  s.run(3);
  const double bottom = static_cast<double>(s.world->need<Rigid>().pose(body).position[1]) - 0.1;
  const bool right = ratio < 1 ? std::fabs(bottom - 0.4) < 1.5 * kSpacing : bottom < kSpacing;
  // what a heavy one traps has no room: it is in the beam or in the floor
  return s.outcome(s.kept(0.2 * kSpacing) && right, labelled("its bottom, m", bottom));
}

// Half a metre of fluid softer than its own weight: a heap on the floor, as its bulk modulus says.
ExtremeOutcome soft(const std::string& solver, double stiffness) {
  FluidScene s(solver);
  s.desc.stiffness = static_cast<Real>(stiffness), s.desc.compression = Real(0.2);
  s.fill(block(20, 10));
  s.run(2);
  return s.outcome(s.kept() && s.middle() < 0.27, labelled("middle, m", s.middle()));
}

// A compression that the budget does not carry: held all the same, or said.
ExtremeOutcome poor(const std::string& solver, double budget) {
  FluidScene s(solver);
  s.desc.compression = Real(1e-4), s.desc.max_substeps = static_cast<int>(budget);
  s.fill(block(20, 10));
  s.run(2);
  double mean = 0, most = 0;
  s.world->query<Fluid>()->density_error(s.id, mean, most);
  const bool held = mean < 0.01;
  ExtremeOutcome out = s.outcome(s.kept() && (held || s.warned.named), labelled("mean compression", mean));
  if (out.as_expected && !held) out.verdict = Verdict::inaccurate;
  return out;
}

constexpr RefusalRow<FluidDesc> kRefused[] = {
    {"spacing 0", "refused, spacing named", "spacing", [](FluidDesc& d) { d.spacing = 0; }},
    {"density NaN", "refused, density named", "density", [](FluidDesc& d) { d.density = kNan; }},
    {"viscosity -1", "refused, viscosity named", "viscosity", [](FluidDesc& d) { d.viscosity = -1; }},
};

constexpr ExtremeRunRow kRuns[] = {
    {"10,000 particles on one spot", "burst with a warning, none is lost", 10000, &on_one_spot},
    {"one particle 100 tanks away", "falls freely, the others stand", 100, &stray},
    {"all particles at random", "settle, no energy from nowhere", 200, &all_random},
    {"a beam of 1e-2 of its density", "floats", 1e-2, &beam},
    {"a beam of 1e2 times its density", "lies on the floor; what it traps is at most a fifth of a spacing in it", 1e2,
     &beam},
    {"bulk modulus of 1 Pa", "falls together, or stays as stiff as it can", 1, &soft},
    {"compression of 1e-4 in one step of its own", "held, or a warning says what to expect", 1, &poor},
};

}  // namespace

std::vector<ExtremeCase> fluid_extremes() {
  std::vector<ExtremeCase> all;
  add_refusals<FluidDesc>("fluid", kRefused, refused_fluid, all);
  add_runs("fluid", fluid_solvers(), kRuns, all);
  return all;
}

}  // namespace feder
