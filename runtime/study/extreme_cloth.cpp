#include <cmath>

#include "base/rng.h"
#include "cloth/solver.h"
#include "contact/surface_contact.h"
#include "couple/cloth_rigid.h"
#include "couple/surface_rigid.h"
#include "feder/world.h"
#include "study/extreme.h"

namespace feder {
namespace {

const SystemDescriptor* const kCatalog[] = {&Collide::descriptor(),        &Rigid::descriptor(),
                                            &SurfaceContact::descriptor(), &SurfaceRigid::descriptor(),
                                            &Cloth::descriptor(),          &ClothRigid::descriptor()};
constexpr Real kBad = std::numeric_limits<Real>::quiet_NaN();

WorldDesc restless(double gravity) {
  WorldDesc d;
  d.gravity = Vec3(0, static_cast<Real>(-gravity), 0);
  d.sleeping = false;
  return d;
}

ClothDesc small_sheet(double stiffness) {
  ClothDesc d;
  d.nx = d.ny = 9;
  d.stretch = static_cast<Real>(stiffness);
  d.damping = Real(0.02);
  d.self_collision = false;
  return d;
}

template <class F>
ExtremeOutcome refused_cloth(const char* word, F&& spoil) {
  World w(restless(9.81), kCatalog);
  w.need<Cloth>().add_cloth(small_sheet(1000));
  ClothDesc d = small_sheet(1000);
  spoil(d);
  return expect_refusal(
      word, [&] { w.need<Cloth>().add_cloth(d); }, [&] { return w.hash(); });
}

double total(const World& w) {
  const Energy e = w.energy();
  return e.kinetic + e.potential + e.elastic;
}

// Warnings of a run; whether one of them names the cloth.
struct Warned {
  std::string last;
  bool named = false;
  void read(World& w, ObjectId cloth) {
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::warning) continue;
      last = w.events().warning_message(e);
      named = named || e.a == cloth;
    }
  }
  std::string words() const { return last.empty() ? "" : "; warned: " + last; }
};

// Weightless, thrown about by `spoil`: it must come back to its shape, and no energy may come from nowhere. A cloth
// that is held back because its numbers overflowed must say so.
template <class F>
ExtremeOutcome comes_back(const std::string& solver, double stiffness, F&& spoil) {
  World w(restless(0), kCatalog);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = small_sheet(stiffness);
  d.solver = solver;
  const ObjectId id = cloth.add_cloth(d);
  spoil(cloth, id);
  const double start = total(w);
  double most = 0;
  Warned warned;
  for (int k = 0; k < 300 && !cloth.quarantined(id); ++k) {
    w.step();
    warned.read(w, id);
    most = std::max(most, w.energy().kinetic);
  }
  if (cloth.quarantined(id)) return {warned.named, Verdict::diverged, "held where it was" + warned.words()};
  const double strain = static_cast<double>(cloth.max_strain(id));
  const bool good = w.is_finite() && most <= 1.01 * start && (stiffness < 100 || strain < 0.5);
  return {good,
          good            ? Verdict::stable
          : w.is_finite() ? Verdict::inaccurate
                          : Verdict::nan,
          labelled("largest kinetic energy by that at the start", most / start) + ", " +
              labelled("largest strain left", strain) + warned.words()};
}

ExtremeOutcome teleported(const std::string& solver, double stiffness) {
  return comes_back(solver, stiffness, [](Cloth& c, ObjectId id) { c.set_point(id, 40, Vec3(100, 30, -20)); });
}

ExtremeOutcome all_random(const std::string& solver, double stiffness) {
  return comes_back(solver, stiffness, [](Cloth& c, ObjectId id) {
    Rng rng(7);
    for (std::size_t i = 0; i < 81; ++i) {
      const double x = rng.unit(), y = rng.unit(), z = rng.unit();
      c.set_point(id, i, Vec3(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)));
    }
  });
}

// A bar of `ratio` times its mass on a hung sheet: holds, or stretches and says so.
ExtremeOutcome heavy_bar(const std::string& solver, double ratio) {
  World w(restless(9.81), kCatalog);
  Cloth& cloth = w.need<Cloth>();
  Rigid& rigid = w.need<Rigid>();
  const double mass = 0.2 * ratio;
  ClothDesc d = small_sheet(mass * 9.81 / 0.05);  // 5 % of strain
  d.solver = solver;
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
  d.pin_names = {"top"};
  const ObjectId id = cloth.add_cloth(d);
  BodyDesc bar;
  bar.shape = make_box(1, Real(0.05), Real(0.05)), bar.mass = static_cast<Real>(mass), bar.group = 0;
  bar.position = cloth.point(id, 76);
  const ObjectId body = rigid.add_body(bar);
  for (std::size_t i = 72; i < 81; ++i) cloth.attach(id, i, body, to_local(rigid.pose(body), cloth.point(id, i)));
  Warned warned;
  double longest = 0;
  for (int k = 0; k < 240 && !cloth.quarantined(id); ++k) {
    w.step();
    warned.read(w, id);
    longest = std::max(longest, static_cast<double>(length(cloth.point(id, 76) - cloth.point(id, 4))));
  }
  if (cloth.quarantined(id)) return {warned.named, Verdict::diverged, "held where it was" + warned.words()};
  const bool held = longest < 1.2, good = w.is_finite() && (held || warned.named) && longest < 5;
  return {good, good && held ? Verdict::stable : Verdict::inaccurate, labelled("longest, m", longest) + warned.words()};
}

const ExtremeCase kRefused[] = {
    {"cloth", "area density 0", "refused, area_density named", false,
     [] { return refused_cloth("area_density", [](ClothDesc& d) { d.area_density = 0; }); }},
    {"cloth", "stretch NaN", "refused, stretch named", false,
     [] { return refused_cloth("stretch", [](ClothDesc& d) { d.stretch = kBad; }); }},
    {"cloth", "pin out of range", "refused, pins named", false,
     [] { return refused_cloth("pins", [](ClothDesc& d) { d.pins = {81}; }); }},
};

struct Run {
  const char* name;
  const char* expected;
  double value;
  ExtremeOutcome (*run)(const std::string& solver, double value);
};
const Run kRuns[] = {
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
  std::vector<ExtremeCase> all(std::begin(kRefused), std::end(kRefused));
  for (const Variant<ClothSolver>& v : cloth_solvers())
    for (const Run& r : kRuns)
      all.push_back({"cloth", std::string(r.name) + ", " + v.name, r.expected, false,
                     [solver = std::string(v.name), &r] { return r.run(solver, r.value); }});
  return all;
}

}  // namespace feder
