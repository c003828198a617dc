// Extreme inputs of bodies: descriptions that must be refused, degenerate shapes, full overlap, speeds and masses a
// thousand times the usual.
#include <cmath>

#include "feder/query.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "study/extreme.h"
#include "study/worlds.h"

namespace feder {
namespace {

const SystemDescriptor* const kCatalog[] = {&Collide::descriptor(), &Rigid::descriptor()};

struct RigidScene {
  explicit RigidScene(double gravity = 9.81, const char* solver = "soft_step") {
    WorldDesc d = awake_world(gravity);
    d.systems["rigid"].set("solver", std::string(solver));
    world = std::make_unique<World>(d, kCatalog);
  }
  Rigid& rigid() { return world->need<Rigid>(); }
  ObjectId add(ShapePtr shape, const Vec3& at, Real mass) {
    BodyDesc d;
    d.shape = std::move(shape), d.position = at, d.mass = mass;
    return rigid().add_body(d);
  }
  ObjectId add_fixed(ShapePtr shape, const Vec3& at) {
    BodyDesc d;
    d.type = BodyType::fixed, d.shape = std::move(shape), d.position = at;
    return rigid().add_body(d);
  }
  void run(double seconds) {
    for (int k = 0; k < static_cast<int>(seconds * 60 + 0.5); ++k) world->step();
  }
  Vec3 position(ObjectId b) { return rigid().bodies().position[rigid().index(b)]; }
  Vec3 velocity(ObjectId b) { return rigid().bodies().velocity[rigid().index(b)]; }
  std::unique_ptr<World> world;
};

ExtremeOutcome refused_body(const char* word, void (*spoil)(BodyDesc&)) {
  RigidScene s;
  s.add(make_box(1, 1, 1), Vec3(0, 0, 0), 1);
  BodyDesc d;
  d.name = "bad";
  d.shape = make_box(1, 1, 1);
  return expect_refusal(
      word, [&] { spoil(d), s.rigid().add_body(d); }, [&] { return s.world->hash(); });
}

// A square of two triangles, with one of no area and one whose vertices are twice the same place beside them.
ExtremeOutcome bad_triangles() {
  RigidScene s;
  const Vec3 v[] = {{-2, 0, -2}, {2, 0, -2}, {2, 0, 2}, {-2, 0, 2}, {0, 0, 0}, {0, 0, 0}, {1, 0, 1}};
  const std::uint32_t t[] = {0, 2, 1, 0, 3, 2, 0, 4, 2, 4, 5, 6};
  s.add_fixed(make_mesh(v, t), Vec3(0, 0, 0));
  const ObjectId ball = s.add(make_sphere(Real(0.25)), Vec3(0, 1, 0), 1);
  s.run(3);
  const double height = static_cast<double>(s.position(ball)[1]);
  const bool good = s.world->is_finite() && std::fabs(height - 0.25) < 0.0125;
  return outcome_of(good, Verdict::inaccurate, labelled("ball rests at, m", height));
}

ExtremeOutcome no_area() {
  const Vec3 v[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::uint32_t t[] = {0, 1, 2};
  return expect_refusal(
      "area", [&] { make_mesh(v, t); }, [] { return std::uint64_t{0}; });
}

// Two boxes in one place, weightless: they part at no more than the push speed of the solver.
ExtremeOutcome full_overlap() {
  RigidScene s(0);
  const ObjectId a = s.add(make_box(1, 1, 1), Vec3(0, 0, 0), 1), b = s.add(make_box(1, 1, 1), Vec3(0, 0, 0), 1);
  double fastest = 0;
  for (int k = 0; k < 300; ++k) {
    s.world->step();
    fastest = std::max(fastest, static_cast<double>(length(s.velocity(a) - s.velocity(b))));
  }
  const double apart = static_cast<double>(length(s.position(a) - s.position(b)));
  const bool good = s.world->is_finite() && apart > 0.95 && fastest < 4;
  return outcome_of(good, fastest < 4 ? Verdict::stuck : Verdict::growing,
                    labelled("apart, m", apart) + ", " + labelled("fastest, m/s", fastest));
}

// 167 m per step against a wall of 1 cm, 10 m away.
ExtremeOutcome bullet(bool marked) {
  RigidScene s(0);
  s.add_fixed(make_box(Real(0.01), 4, 4), Vec3(10, 0, 0));
  BodyDesc d;
  d.shape = make_sphere(Real(0.05)), d.mass = 1, d.velocity = Vec3(10000, 0, 0), d.bullet = marked;
  const ObjectId b = s.rigid().add_body(d);
  s.run(0.5);
  const double at = static_cast<double>(s.position(b)[0]);
  const bool stopped = at < 9.96;
  return {s.world->is_finite() && stopped == marked, stopped ? Verdict::stable : Verdict::inaccurate,
          labelled("ends at x, m", at)};
}

ExtremeOutcome needle() {
  RigidScene s;
  s.add_fixed(make_plane(Vec3(0, 1, 0), 0), Vec3(0, 0, 0));
  const ObjectId b = s.add(make_box(1, Real(0.001), Real(0.001)), Vec3(0, Real(0.2), 0), Real(0.001));
  s.run(5);
  const double height = static_cast<double>(s.position(b)[1]), speed = static_cast<double>(length(s.velocity(b)));
  const bool good = s.world->is_finite() && std::fabs(height) < 0.01 && speed < 0.05;
  return outcome_of(good, Verdict::inaccurate, labelled("height, m", height) + ", " + labelled("speed, m/s", speed));
}

ExtremeOutcome stack(const char* solver, int count, double seconds, Real top_mass) {
  RigidScene s(9.81, solver);
  s.add_fixed(make_plane(Vec3(0, 1, 0), 0), Vec3(0, 0, 0));
  ObjectId top;
  for (int k = 0; k < count; ++k)
    top = s.add(make_box(1, 1, 1), Vec3(0, Real(0.5) + static_cast<Real>(k), 0), k + 1 == count ? top_mass : Real(1));
  s.run(2);
  const Vec3 settled = s.position(top);
  s.run(seconds);
  const double drift = static_cast<double>(length(s.position(top) - settled)) / seconds * 60;  // m per minute
  const double height = static_cast<double>(s.position(top)[1]), sunk = count - 0.5 - height;
  const double kinetic = s.world->energy().kinetic;
  const bool good = s.world->is_finite() && drift < 1e-3 && kinetic < 1e-6 && sunk < 0.05 * count;
  return outcome_of(
      good, Verdict::inaccurate,
      labelled("drift, m/min", drift) + ", " + labelled("kinetic, J", kinetic) + ", " + labelled("sunk, m", sunk));
}

// The soft solver's contacts are springs: at 1000 : 1 the light box is pressed in, which must show as a penetration.
ExtremeOutcome heavy_on_soft() {
  ExtremeOutcome out = stack("soft_step", 2, 10, 1000);
  out.as_expected = out.verdict == Verdict::inaccurate;
  return out;
}

constexpr RefusalRow<BodyDesc> kRefused[] = {
    {"mass -1", "refused, mass named", "mass", [](BodyDesc& d) { d.mass = -1; }},
    {"mass NaN", "refused, mass named", "mass", [](BodyDesc& d) { d.mass = kNan; }},
    {"density 0", "refused, density named", "density", [](BodyDesc& d) { d.density = 0; }},
    {"position NaN", "refused, position named", "position", [](BodyDesc& d) { d.position[0] = kNan; }},
    {"velocity infinite", "refused, velocity named", "velocity", [](BodyDesc& d) { d.velocity[0] = kInfinity; }},
    {"box of no width", "refused, the size named", "box", [](BodyDesc& d) { d.shape = make_box(0, 1, 1); }},
};

const ExtremeCase kCases[] = {
    {"rigid", "mesh with zero-area triangles and double vertices", "the good triangles carry a ball", false,
     &bad_triangles},
    {"rigid", "mesh without area", "refused", false, &no_area},
    {"rigid", "boxes fully overlapping", "part, no faster than the push speed", false, &full_overlap},
    {"rigid", "bullet of 1e4 m/s, wall of 1 cm", "stops at the wall", false, [] { return bullet(true); }},
    {"rigid", "the same, not marked as bullet", "passes: inaccurate, as documented", false,
     [] { return bullet(false); }},
    {"rigid", "needle 1000 : 1", "lies still", false, &needle},
    {"rigid", "stack of 40 boxes for 60 s, impulse", "drift below 1 mm/min, kinetic energy below 1e-6 J", true,
     [] { return stack("impulse", 40, 60, 1); }},
    {"rigid", "heavy 1000 : 1 on light, impulse", "stands", false, [] { return stack("impulse", 2, 10, 1000); }},
    {"rigid", "heavy 1000 : 1 on light, soft_step", "sinks in: inaccurate, its contacts are springs", false,
     &heavy_on_soft},
};

}  // namespace

std::vector<ExtremeCase> rigid_extremes() {
  std::vector<ExtremeCase> all;
  add_refusals<BodyDesc>("rigid", kRefused, refused_body, all);
  all.insert(all.end(), std::begin(kCases), std::end(kCases));
  return all;
}

}  // namespace feder
