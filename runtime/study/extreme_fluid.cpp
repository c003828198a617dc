#include <cmath>

#include "base/rng.h"
#include "couple/fluid_rigid.h"
#include "feder/query.h"
#include "feder/world.h"
#include "fluid/solver.h"
#include "study/extreme.h"

namespace feder {
namespace {

constexpr Real kBad = std::numeric_limits<Real>::quiet_NaN();
constexpr double kSpacing = 0.05, kGravity = 9.81;

// A tank in the plane, 1 m wide, without a lid.
struct FluidScene {
  explicit FluidScene(const std::string& solver) {
    static const SystemDescriptor* const catalog[] = {&Collide::descriptor(), &Rigid::descriptor(),
                                                      &Fluid::descriptor(), &FluidRigid::descriptor()};
    WorldDesc d;
    d.dimension = 2;
    d.gravity = Vec3(0, static_cast<Real>(-kGravity), 0);
    d.sleeping = false;
    world = std::make_unique<World>(d, catalog);
    for (const Vec3& n : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(-1, 0, 0)}) {
      BodyDesc wall;
      wall.type = BodyType::fixed;
      wall.shape = make_plane(n, n[0] < 0 ? Real(-1) : Real(0));
      world->need<Rigid>().add_body(wall);
    }
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
      for (const Event& e : world->events().list()) {
        if (e.kind != EventKind::warning) continue;
        warned = world->events().warning_message(e);
        named = named || e.a == id;
      }
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
    return {good,
            good                 ? Verdict::stable
            : world->is_finite() ? Verdict::inaccurate
                                 : Verdict::nan,
            detail + ", " + labelled("fastest, m/s", fastest) +
                (beyond() > 0 ? ", " + labelled("beyond the walls, m", beyond()) : "") +
                (warned.empty() ? "" : "; warned: " + warned)};
  }

  std::unique_ptr<World> world;
  FluidDesc desc;
  ObjectId id;
  std::size_t count = 0;
  std::vector<Vec3> positions, velocities;
  double fastest = 0;
  std::string warned;
  bool named = false;
};

std::vector<Vec3> block(int wide, int high) {
  std::vector<Vec3> points;
  for (int j = 0; j < high; ++j)
    for (int i = 0; i < wide; ++i)
      points.push_back(Vec3(static_cast<Real>((i + 0.5) * kSpacing), static_cast<Real>((j + 0.5) * kSpacing), 0));
  return points;
}

template <class F>
ExtremeOutcome refused_fluid(const char* word, F&& spoil) {
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
      s.outcome(s.kept(1) && far > kSpacing && (!burst || s.named), labelled("largest distance, m", far));
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
  BodyDesc b;
  b.shape = make_box(Real(0.3), Real(0.2), 1)->section();
  b.density = static_cast<Real>(1000 * ratio);
  b.position = Vec3(Real(0.5), Real(0.6), 0);
  const ObjectId body = s.world->need<Rigid>().add_body(b);
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
  ExtremeOutcome out = s.outcome(s.kept() && (held || s.named), labelled("mean compression", mean));
  if (out.as_expected && !held) out.verdict = Verdict::inaccurate;
  return out;
}

const ExtremeCase kRefused[] = {
    {"fluid", "spacing 0", "refused, spacing named", false,
     [] { return refused_fluid("spacing", [](FluidDesc& d) { d.spacing = 0; }); }},
    {"fluid", "density NaN", "refused, density named", false,
     [] { return refused_fluid("density", [](FluidDesc& d) { d.density = kBad; }); }},
    {"fluid", "viscosity -1", "refused, viscosity named", false,
     [] { return refused_fluid("viscosity", [](FluidDesc& d) { d.viscosity = -1; }); }},
};

struct Run {
  const char* name;
  const char* expected;
  double value;
  ExtremeOutcome (*run)(const std::string& solver, double value);
};
const Run kRuns[] = {
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
  std::vector<ExtremeCase> all(std::begin(kRefused), std::end(kRefused));
  for (const Variant<FluidSolver>& v : fluid_solvers())
    for (const Run& r : kRuns)
      all.push_back({"fluid", std::string(r.name) + ", " + v.name, r.expected, false,
                     [solver = std::string(v.name), &r] { return r.run(solver, r.value); }});
  return all;
}

}  // namespace feder
