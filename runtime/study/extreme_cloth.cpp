#include <cmath>

#include "base/rng.h"
#include "couple/cloth_rigid.h"
#include "study/extreme.h"
#include "world/world.h"

namespace feder {
namespace {

const SystemDescriptor* const kCatalog[] = {&Collide::descriptor(), &Rigid::descriptor(), &Cloth::descriptor(),
                                            &ClothRigid::descriptor()};
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
  return expect_refusal(word, [&] { w.need<Cloth>().add_cloth(d); }, [&] { return w.hash(); });
}

double total(const World& w) {
  const Energy e = w.energy();
  return e.kinetic + e.potential + e.elastic;
}

// Weightless, thrown about by `spoil`: it must come back to its shape, and no energy may come from nowhere.
template <class F>
ExtremeOutcome comes_back(double stiffness, F&& spoil) {
  World w(restless(0), kCatalog);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(small_sheet(stiffness));
  spoil(cloth, id);
  const double start = total(w);
  double most = 0;
  for (int k = 0; k < 300; ++k) {
    w.step();
    most = std::max(most, w.energy().kinetic);
  }
  const double strain = static_cast<double>(cloth.max_strain(id));
  const bool good = w.is_finite() && most <= 1.01 * start && (stiffness < 100 || strain < 0.5);
  return {good,
          good            ? Verdict::stable
          : w.is_finite() ? Verdict::inaccurate
                          : Verdict::nan,
          labelled("largest kinetic energy by that at the start", most / start) + ", " +
              labelled("largest strain left", strain)};
}

ExtremeOutcome teleported(double stiffness) {
  return comes_back(stiffness, [](Cloth& c, ObjectId id) { c.set_point(id, 40, Vec3(100, 30, -20)); });
}

ExtremeOutcome all_random(double stiffness) {
  return comes_back(stiffness, [](Cloth& c, ObjectId id) {
    Rng rng(7);
    for (std::size_t i = 0; i < 81; ++i) {
      const double x = rng.unit(), y = rng.unit(), z = rng.unit();
      c.set_point(id, i, Vec3(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)));
    }
  });
}

// A bar of `ratio` times its mass on a hung sheet: holds, or stretches and says so.
ExtremeOutcome heavy_bar(double ratio) {
  World w(restless(9.81), kCatalog);
  Cloth& cloth = w.need<Cloth>();
  Rigid& rigid = w.need<Rigid>();
  const double mass = 0.2 * ratio;
  ClothDesc d = small_sheet(mass * 9.81 / 0.05);  // 5 % of strain
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
  d.pin_names = {"top"};
  const ObjectId id = cloth.add_cloth(d);
  BodyDesc bar;
  bar.shape = make_box(1, Real(0.05), Real(0.05)), bar.mass = static_cast<Real>(mass), bar.group = 0;
  bar.position = cloth.point(id, 76);
  const ObjectId body = rigid.add_body(bar);
  for (std::size_t i = 72; i < 81; ++i) cloth.attach(id, i, body, to_local(rigid.pose(body), cloth.point(id, i)));
  bool warned = false;
  double longest = 0;
  for (int k = 0; k < 240; ++k) {
    w.step();
    for (const Event& e : w.events().list()) warned = warned || e.kind == EventKind::warning;
    longest = std::max(longest, static_cast<double>(length(cloth.point(id, 76) - cloth.point(id, 4))));
  }
  const bool held = longest < 1.2, good = w.is_finite() && (held || warned) && longest < 3;
  return {good, good && held ? Verdict::stable : Verdict::inaccurate,
          labelled("longest, m", longest) + (warned ? ", with a warning" : "")};
}

const ExtremeCase kCases[] = {
    {"cloth", "area density 0", "refused, area_density named", false,
     [] { return refused_cloth("area_density", [](ClothDesc& d) { d.area_density = 0; }); }},
    {"cloth", "stretch NaN", "refused, stretch named", false,
     [] { return refused_cloth("stretch", [](ClothDesc& d) { d.stretch = kBad; }); }},
    {"cloth", "pin out of range", "refused, pins named", false,
     [] { return refused_cloth("pins", [](ClothDesc& d) { d.pins = {81}; }); }},
    {"cloth", "one vertex 100 lengths away, 1 N/m", "swings back, no energy from nowhere", false,
     [] { return teleported(1); }},
    {"cloth", "one vertex 100 lengths away, 1e3 N/m", "comes back to its shape", false, [] { return teleported(1e3); }},
    {"cloth", "one vertex 100 lengths away, 1e6 N/m", "comes back to its shape", false, [] { return teleported(1e6); }},
    {"cloth", "all vertices random, 1 N/m", "spreads, no energy from nowhere", false, [] { return all_random(1); }},
    {"cloth", "all vertices random, 1e3 N/m", "spreads to its size", false, [] { return all_random(1e3); }},
    {"cloth", "all vertices random, 1e6 N/m", "spreads to its size", false, [] { return all_random(1e6); }},
    {"cloth", "bar of 100 times its mass hung from it", "holds", false, [] { return heavy_bar(100); }},
    {"cloth", "bar of 1e4 times its mass hung from it", "holds, or stretches with a warning", false,
     [] { return heavy_bar(1e4); }},
};

}  // namespace

std::span<const ExtremeCase> extreme_cloth_cases() { return kCases; }

}  // namespace feder
