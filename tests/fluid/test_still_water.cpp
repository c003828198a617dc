// Still water of every solver stays still: columns eight spacings wide over layers, spacing, iterations (of those that
// have them) and substeps. No particle above H + 2 d; after 2 s nobody faster than 0.2 sqrt(g H), or than what gravity
// gives in two inner substeps; no warning where nobody chose extremes; more iterations never leave more compression.
// The whole map runs with scripts/test --all.
#include "feder/error.h"
#include "fluid/any_solver.h"
#include "fluid/still_water.h"

using namespace feder;

namespace {

struct Cell {
  const char* name;
  int dimension, layers, iterations, substeps;
  double spacing;
};

constexpr double kSeconds = 2.5;  // of a cell: the last half a second counts for its speed

const Cell kCells[] = {
    {"8 layers of 1 mm", 2, 8, 4, 4, 0.001},
    {"8 layers of 6 mm", 2, 8, 4, 4, 0.006},
    {"8 layers of 12.5 mm", 2, 8, 4, 4, 0.0125},
    {"8 layers of 5 cm", 2, 8, 4, 4, 0.05},
    {"8 layers of 10 cm", 2, 8, 4, 4, 0.1},
    {"25 layers of 1 mm", 2, 25, 4, 4, 0.001},
    {"25 layers of 6 mm", 2, 25, 4, 4, 0.006},
    {"25 layers of 12.5 mm", 2, 25, 4, 4, 0.0125},
    {"25 layers of 5 cm", 2, 25, 4, 4, 0.05},
    {"25 layers of 10 cm", 2, 25, 4, 4, 0.1},
    {"40 layers of 12.5 mm", 2, 40, 4, 4, 0.0125},
    {"50 layers of 6 mm", 2, 50, 4, 4, 0.006},
    {"61 layers of 2.5 cm, 8 iterations", 2, 61, 8, 4, 0.025},
    {"60 layers of 5 cm", 2, 60, 4, 4, 0.05},
    {"25 layers of 6 mm, 1 iteration", 2, 25, 1, 4, 0.006},
    {"25 layers of 6 mm, 8 iterations", 2, 25, 8, 4, 0.006},
    {"25 layers of 6 mm, 32 iterations", 2, 25, 32, 4, 0.006},
    {"43 layers of 12.5 mm, 8 iterations", 2, 43, 8, 4, 0.0125},
    {"25 layers of 5 cm, 1 iteration, 1 substep", 2, 25, 1, 1, 0.05},
    {"25 layers of 5 cm, 1 substep", 2, 25, 4, 1, 0.05},
    {"25 layers of 6 mm, 1 substep", 2, 25, 4, 1, 0.006},
    {"8 layers of 1 mm, 16 substeps", 2, 8, 4, 16, 0.001},
    {"in space, 8 layers of 5 cm", 3, 8, 4, 4, 0.05},
    {"in space, a glass: 20 layers of 6 mm", 3, 20, 4, 4, 0.006},
};

StillWater water(const std::string& solver, int dimension, int layers, double spacing, int iterations, int substeps,
                 double seconds) {
  StillWater s;
  s.solver = solver, s.dimension = dimension, s.layers = layers, s.iterations = iterations, s.substeps = substeps;
  s.spacing = spacing, s.seconds = seconds;
  return s;
}

// Do the iterations of the description change anything?
bool counts_iterations(const std::string& solver) {
  StillWater s = water(solver, 2, 8, 0.05, 1, 4, 0.1);
  const StillWaterResult one = run_still_water(s);
  s.iterations = 8;
  return run_still_water(s).hash != one.hash;
}

// The same column with another count of iterations is in the table, and stands for those that count none.
bool repeats(const Cell& cell) {
  return cell.iterations != 4 && std::any_of(std::begin(kCells), std::end(kCells), [&cell](const Cell& c) {
           return c.iterations == 4 && c.dimension == cell.dimension && c.layers == cell.layers &&
                  c.substeps == cell.substeps && c.spacing == cell.spacing;
         });
}

}  // namespace

TEST_CASE("still water stays still", "[fluid][still][heavy]") {
  const std::string solver = any_fluid_solver();
  const bool iterates = counts_iterations(solver);
  for (const Cell& c : kCells) {
    if (!iterates && repeats(c)) continue;
    const bool dear = c.dimension == 3 || c.layers > 25 || c.iterations > 8;
    if ((!kLarge || kAsserts) && dear) continue;  // without asserts in release
    const StillWaterResult r =
        run_still_water(water(solver, c.dimension, c.layers, c.spacing, c.iterations, c.substeps, kSeconds * kShare));
    CAPTURE(solver, c.name, r.top, r.speed, r.noise, r.burst, r.warned, r.excess, r.per_step);
    CHECK(r.burst < 0);
    CHECK((r.warned < 0 || r.at_limit));  // solvers of small steps have few in a large one
  }
}

TEST_CASE("still water of dfsph stays still, and as dense as its tolerance says", "[fluid][still]") {
  struct Column {
    int dimension, layers;
    double spacing;
  };
  for (const Column& c : {Column{2, 8, 0.001}, Column{2, 25, 0.05}, Column{2, 61, 0.025}, Column{2, 83, 0.006},
                          Column{3, 20, 0.006}, Column{3, 40, 0.0125}}) {
    if (!kLarge && (c.dimension == 3 || c.layers > 25)) continue;
    if (kAsserts && (c.layers == 40 || c.layers == 83)) continue;  // of `--all`
    StillWater s;
    s.solver = "dfsph", s.dimension = c.dimension, s.layers = c.layers, s.spacing = c.spacing;
    s.seconds = 2.5 * kShare;
    const StillWaterResult r = run_still_water(s);
    CAPTURE(c.dimension, c.layers, c.spacing, r.top, r.speed, r.noise, r.burst, r.warned, r.excess, r.per_step);
    CHECK(r.burst < 0);
    CHECK(r.warned < 0);
    if (kFull) CHECK(r.excess < 0.0003);                             // measured: 2.3e-4 to 2.6e-4
    if (kFull) CHECK(r.noise < 0.06 * std::sqrt(9.81 * c.spacing));  // measured: 0.004 to 0.039
  }
}

TEST_CASE("still water of dfsph stays still whatever its kernel and tolerance", "[fluid][still]") {
  StillWater s;
  s.solver = "dfsph", s.layers = 16, s.spacing = 0.025;
  s.dimension = kLarge && !kAsserts ? GENERATE(2, 3) : 2;
  s.kernel = GENERATE("wendland", "cubic", "poly6_spiky");
  s.tolerance = GENERATE(1e-4, 1.0, 100.0);
  s.seconds = 2.5 * kShare;
  const StillWaterResult r = run_still_water(s);
  CAPTURE(s.dimension, s.kernel, s.tolerance, r.top, r.speed, r.noise, r.burst, r.warned, r.excess);
  CHECK(r.burst < 0);
  if (kFull) CHECK(r.excess < 0.01);
}

TEST_CASE("water around a solid comes to rest", "[fluid][still]") {
  if (!kLarge || kAsserts) return;  // four seconds each
  const bool round = GENERATE(false, true);
  CAPTURE(round);
  const Real d = Real(0.05), wide = 16 * d;
  World w(fluid_world(3), fluid_catalog());
  add_tank(w, vec3(wide, 1, wide));
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = round ? make_sphere(Real(0.15)) : make_box(Real(0.3), Real(0.3), Real(0.3));
  b.position = vec3(wide / 2, Real(0.25), wide / 2);
  w.need<Rigid>().add_body(b);
  FluidDesc f;
  f.spacing = d;
  const ObjectId id = add_water(w, f, vec3(wide, 10 * d, wide));
  run(w, 2.5);
  const double mass = 1000 * std::pow(0.05, 3) * static_cast<double>(w.need<Fluid>().particle_count(id));
  CHECK(std::sqrt(2 * w.energy().kinetic / mass) < 0.06 * std::sqrt(9.81 * 0.05));  // measured: 0.02
}

TEST_CASE("more iterations never leave more compression", "[fluid][still]") {
  double last = 1;
  for (int n = 1; n <= (kLarge ? 32 : 8); n *= 2) {
    const StillWaterResult r = run_still_water(water("pbf", 2, 25, 0.05, n, 4, 1.5 * kShare));
    CAPTURE(n, r.excess, last, r.per_step);
    CHECK(r.burst < 0);
    if (kFull) CHECK(r.excess <= 1.1 * last);
    last = r.excess;
  }
  if (kFull) CHECK(last < 0.002);
}

TEST_CASE("pbf says before it bursts that its steps do not carry the column", "[fluid][still]") {
  const StillWaterResult r = run_still_water(water("pbf", 2, 100, 0.001, 1, 1, 0.05));
  CHECK(r.warned > 0);
  CHECK_FALSE(r.burst_unwarned());
}

namespace {

// s. Some columns take longer than 2 s, and are found here so that no more become like them:
//  - pbf, shallow coarse ones in fine steps: the lattice settles by 1.6 cm on average and, inviscid, swings it
//    out: with 4, 8 and 32 iterations 1.29, 1.12 and 1.002 times the bound after 2 s, 1.06, 0.98, 0.80 after 3 s;
//  - pbf, 10 and 20 m with a single iteration: up to 1.5 times the bound between 2 and 3 s, 1.03 at 4.5 s;
//  - wcsph in space, shallow coarse ones: single particles leave the lattice at up to 0.6 m/s.
double calm_after(const StillWater& s) {
  if (s.solver == "wcsph" && s.dimension == 3 && s.layers == 8 && s.spacing >= 0.05) return 5;
  if (s.solver != "pbf" || s.dimension == 3) return 2;
  if (s.layers == 8 && s.spacing == 0.1 && s.substeps == 16) return 4;
  if (s.layers * s.spacing > 9.9 && s.iterations == 1) return 5;
  return 2;
}

// Ten seconds each, or two where they would cost more than 1e9 particles times solver substeps; a third of that with
// solvers that iterate, whose substeps cost three times as much.
StillWaterResult in_map(StillWater s) {
  s.budget = s.solver == "wcsph" ? 1e9 : 3e8;
  s.calm = calm_after(s);
  return run_still_water(s);
}

void map_of_still_water(int layers, const std::vector<double>& spacings = {0.001, 0.006, 0.0125, 0.05, 0.1}) {
  const std::string solver = any_fluid_solver();
  const bool iterates = counts_iterations(solver);
  for (const double spacing : spacings)
    for (const int substeps : {1, 4, 16})
      for (const int iterations : {1, 4, 8, 32}) {
        if (!iterates && iterations != 4) continue;
        const StillWaterResult r = in_map(water(solver, 2, layers, spacing, iterations, substeps, 10));
        CAPTURE(solver, layers, spacing, substeps, iterations);
        CAPTURE(r.top, r.speed, r.noise, r.burst, r.warned, r.excess, r.per_step);
        CHECK_FALSE(r.burst_unwarned());
        if (iterations == 4 && substeps == 4 && layers <= 60 && spacing >= 0.005) CHECK((r.warned < 0 || r.at_limit));
        if (!iterates || iterations == 1 || r.burst >= 0) continue;
        const StillWaterResult half = run_still_water(water(solver, 2, layers, spacing, iterations / 2, substeps, 2));
        CAPTURE(half.excess);
        if (half.burst < 0) CHECK(r.excess <= 1.1 * half.excess + 1e-5);  // rounding, which is what 32 leave
      }
}

}  // namespace

TEST_CASE("the map of still water, 8 layers", "[fluid][.][map8]") { map_of_still_water(8); }
TEST_CASE("the map of still water, 25 layers", "[fluid][.][map25]") { map_of_still_water(25); }
TEST_CASE("the map of still water, 50 layers", "[fluid][.][map50]") { map_of_still_water(50); }
TEST_CASE("the map of still water, 100 layers", "[fluid][.][map100]") { map_of_still_water(100); }
TEST_CASE("the map of still water, 200 layers", "[fluid][.][map200]") { map_of_still_water(200, {0.001, 0.006}); }
TEST_CASE("the map of still water, 200 coarse layers", "[fluid][.][map200coarse]") {
  map_of_still_water(200, {0.0125, 0.05, 0.1});
}

TEST_CASE("the map of still water in space", "[fluid][.][map3d]") {
  const std::string solver = any_fluid_solver();
  for (const int layers : {8, 25, 50})
    for (const double spacing : {0.006, 0.0125, 0.05, 0.1}) {
      const StillWaterResult r = in_map(water(solver, 3, layers, spacing, 4, 4, 10));
      CAPTURE(solver, layers, spacing, r.top, r.speed, r.noise, r.burst, r.warned, r.excess, r.per_step);
      CHECK(r.burst < 0);
      CHECK((r.warned < 0 || r.at_limit));
    }
}
