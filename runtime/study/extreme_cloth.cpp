// Extreme inputs of cloth: descriptions that must be refused, vertices thrown about, and weights up to 1e4 times its
// own, by every solver.
#include <cmath>

#include "base/rng.h"
#include "study/cloth_scene.h"
#include "study/extreme.h"

namespace feder {
namespace {

constexpr int kPoints = 9;

ClothDesc small_sheet(double stiffness) {
  ClothDesc d = square_sheet(kPoints, stiffness);
  d.self_collision = false;
  return d;
}

ExtremeOutcome refused_cloth(const char* word, void (*spoil)(ClothDesc&)) {
  World w(awake_world(9.81), cloth_catalog());
  w.need<Cloth>().add_cloth(small_sheet(1000));
  ClothDesc d = small_sheet(1000);
  spoil(d);
  return expect_refusal(
      word, [&] { w.need<Cloth>().add_cloth(d); }, [&] { return w.hash(); });
}

// Of a cloth that is held back because its numbers overflowed.
ExtremeOutcome held_back(const WarningRecord& warned) {
  return {warned.named, Verdict::diverged, "held where it was" + warned.words()};
}

// Weightless, thrown about by `spoil`: it must come back to its shape, and no energy may come from nowhere. A cloth
// that is held back because its numbers overflowed must say so.
template <class F>
ExtremeOutcome comes_back(const std::string& solver, double stiffness, F&& spoil) {
  World w(awake_world(0), cloth_catalog());
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = small_sheet(stiffness);
  d.solver = solver;
  const ObjectId id = cloth.add_cloth(d);
  spoil(cloth, id);
  const double start = total_energy(w);
  double most = 0;
  WarningRecord warned;
  for (int k = 0; k < 300 && !cloth.quarantined(id); ++k) {
    w.step();
    warned.read(w, id);
    most = std::max(most, w.energy().kinetic);
  }
  if (cloth.quarantined(id)) return held_back(warned);
  const double strain = static_cast<double>(cloth.max_strain(id));
  const bool good = w.is_finite() && most <= 1.01 * start && (stiffness < 100 || strain < 0.5);
  return outcome_of(good, w.is_finite() ? Verdict::inaccurate : Verdict::nan,
                    labelled("largest kinetic energy by that at the start", most / start) + ", " +
                        labelled("largest strain left", strain) + warned.words());
}

ExtremeOutcome teleported(const std::string& solver, double stiffness) {
  return comes_back(solver, stiffness, [](Cloth& c, ObjectId id) { c.set_point(id, 40, Vec3(100, 30, -20)); });
}

ExtremeOutcome all_random(const std::string& solver, double stiffness) {
  return comes_back(solver, stiffness, [](Cloth& c, ObjectId id) {
    Rng rng(7);
    for (std::size_t i = 0; i < kPoints * kPoints; ++i) {
      const double x = rng.unit(), y = rng.unit(), z = rng.unit();
      c.set_point(id, i, Vec3(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)));
    }
  });
}

// A bar of `ratio` times its mass on a hung sheet: holds, or stretches and says so.
ExtremeOutcome heavy_bar(const std::string& solver, double ratio) {
  World w(awake_world(9.81), cloth_catalog());
  const double mass = 0.2 * ratio;
  ClothDesc d = upright_sheet(kPoints, mass * 9.81 / 0.05, "top");  // 5 % of strain
  d.solver = solver;
  const HungSheet s = hang_sheet(w, d, mass);
  const Cloth& cloth = w.need<Cloth>();
  WarningRecord warned;
  double longest = 0;
  for (int k = 0; k < 240 && !cloth.quarantined(s.cloth); ++k) {
    w.step();
    warned.read(w, s.cloth);
    longest = std::max(longest, hung_length(cloth, s));
  }
  if (cloth.quarantined(s.cloth)) return held_back(warned);
  const bool held = longest < 1.2, good = w.is_finite() && (held || warned.named) && longest < 5;
  return {good, good && held ? Verdict::stable : Verdict::inaccurate, labelled("longest, m", longest) + warned.words()};
}

constexpr RefusalRow<ClothDesc> kRefused[] = {
    {"area density 0", "refused, area_density named", "area_density", [](ClothDesc& d) { d.area_density = 0; }},
    {"stretch NaN", "refused, stretch named", "stretch", [](ClothDesc& d) { d.stretch = kNan; }},
    {"pin out of range", "refused, pins named", "pins", [](ClothDesc& d) { d.pins = {kPoints * kPoints}; }},
};

constexpr ExtremeRunRow kRuns[] = {
    {"one vertex 100 lengths away, 1 N/m", "swings back, no energy from nowhere", 1, &teleported},
    {"one vertex 100 lengths away, 1e3 N/m", "comes back to its shape", 1e3, &teleported},
    {"one vertex 100 lengths away, 1e6 N/m", "comes back to its shape, or is held with a warning", 1e6, &teleported},
    {"all vertices random, 1 N/m", "spreads, no energy from nowhere", 1, &all_random},
    {"all vertices random, 1e3 N/m", "spreads to its size", 1e3, &all_random},
    {"all vertices random, 1e6 N/m", "spreads to its size, or is held with a warning", 1e6, &all_random},
    {"bar of 100 times its mass hung from it", "holds, or stretches with a warning", 100, &heavy_bar},
    {"bar of 1e4 times its mass hung from it", "holds, stretches or is held with a warning", 1e4, &heavy_bar},
};

}  // namespace

std::vector<ExtremeCase> cloth_extremes() {
  std::vector<ExtremeCase> all;
  add_refusals<ClothDesc>("cloth", kRefused, refused_cloth, all);
  add_runs("cloth", cloth_solvers(), kRuns, all);
  return all;
}

}  // namespace feder
