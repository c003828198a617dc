// Liquids in pictures: one sees through them, tinted by the way through; spray, sheets, splats and what is said of
// them.
#include <array>
#include <chrono>
#include <ctime>
#include <map>

#include "feder/fluid.h"
#include "fluid/liquid_surface.h"
#include "view/drawing.h"
#include "view/liquid_shape.h"

using namespace feder;
using namespace feder::view;

namespace {

constexpr int kWide = 160, kHigh = 120;

// A striped floor, and over it a block of liquid between x = -1 and 1.
struct Pool {
  World world;
  ObjectId fluid;
  lua::Appearance appearance;
  explicit Pool(Real depth = Real(0.4), int dimension = 3) : world(desc(dimension), catalog()) {
    if (dimension == 3)
      for (int i = -8; i < 8; ++i) {
        const ObjectId strip = test::add_box(world, vec3(Real(0.25), Real(0.1), 6),
                                             vec3(Real(0.25) * Real(i) + Real(0.125), Real(-0.05), 0), BodyType::fixed);
        appearance.colors[strip] = i % 2 == 0 ? 0xffffff : 0x202020;
      }
    FluidDesc d;
    d.name = "pond", d.spacing = Real(0.1);
    fluid = world.need<Fluid>().add_fluid(d);
    if (depth > 0)
      world.need<Fluid>().fill(fluid, *make_box(2, depth, dimension == 3 ? 2 : 1), Pose{vec3(0, depth / 2, 0), {}},
                               Vec3::Zero());
  }
  static WorldDesc desc(int dimension) {
    WorldDesc d;
    d.dimension = dimension;
    return d;
  }
  Frame frame(const Toggles& toggles = {}) {
    Collector collector;
    Frame f;
    collector.collect(world, &appearance, toggles, f);
    return f;
  }
};

Image shot(const Frame& f, float pitch = 1.2f) {
  static Headless gl(kWide, kHigh);
  static Renderer renderer(gl.loader());
  Camera c;
  c.distance = 5, c.yaw = 0, c.pitch = pitch;
  renderer.draw(f, c, {}, gl.target());
  return gl.read();
}

int part(const Image& i, int x, int y, std::size_t k) { return i.pixel(x, y)[k]; }

// Of the brightness along the middle of the picture, where the liquid is: the largest less the smallest.
int contrast(const Image& image) {
  int low = 255, high = 0;
  for (int x = kWide / 2 - 20; x < kWide / 2 + 20; ++x) {
    const int b = part(image, x, kHigh / 2, 1);
    low = std::min(low, b), high = std::max(high, b);
  }
  return high - low;
}

// Blue over red in the middle, mean over some stripes.
double blueness(const Image& image) {
  double blue = 0, red = 0;
  for (int x = kWide / 2 - 20; x < kWide / 2 + 20; ++x)
    blue += part(image, x, kHigh / 2, 2), red += part(image, x, kHigh / 2, 0);
  return blue / red;
}

double own_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<Vec3> lattice(int n, Real spacing) {
  std::vector<Vec3> x;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) x.push_back(spacing * vec3(Real(i), Real(j), Real(k)));
  return x;
}

}  // namespace

TEST_CASE("a striped floor is seen through water, and not through an opaque liquid", "[view][gl][liquid]") {
  Pool empty(0), water, opaque;
  opaque.appearance.transparencies[opaque.fluid] = 0;
  const int open = contrast(shot(empty.frame())), through = contrast(shot(water.frame())),
            hidden = contrast(shot(opaque.frame()));
  CAPTURE(open, through, hidden);
  CHECK(open > 150);
  CHECK(through > open / 3);
  CHECK(hidden < open / 6);
  const std::uint64_t before = water.world.hash();
  shot(water.frame());
  CHECK(water.world.hash() == before);
}

TEST_CASE("deep water is bluer than shallow water, and a colour of its own tints more", "[view][gl][liquid]") {
  Pool empty(0), shallow(Real(0.2)), deep(Real(1.2)), red;
  red.appearance.colors[red.fluid] = 0xc03020;
  const double none = blueness(shot(empty.frame())), some = blueness(shot(shallow.frame())),
               much = blueness(shot(deep.frame())), less = blueness(shot(red.frame()));
  CAPTURE(none, some, much, less);
  CHECK(some > none + 0.02);
  CHECK(much > some + 0.1);
  CHECK(less < none - 0.2);
}

TEST_CASE("spray is drawn as droplets, what holds together as one body", "[view][liquid]") {
  Pool pool;
  const std::size_t count = pool.world.need<Fluid>().count();
  pool.world.need<Fluid>().fill(pool.fluid, std::vector<Vec3>{vec3(0, 2, 0), vec3(1, 3, 0)}, Vec3::Zero());
  const Frame f = pool.frame();
  REQUIRE(f.liquids.size() == 1);
  REQUIRE(f.meshes.size() == 1);
  CHECK(f.meshes[0].liquid == 0);
  CHECK(f.foam.empty());
  REQUIRE(f.point_groups.size() == 1);
  CHECK(f.point_groups[0].count == 2);
  CHECK(f.point_groups[0].liquid == kNone);
  CHECK(f.points[0].radius < 0.05f);
  for (const MeshVertex& v : f.vertices) CHECK(v.position.y < 1);
  CHECK(count > 1000);
  Toggles balls;
  set_toggles(balls, "speed");
  CHECK(pool.frame(balls).liquids.empty());
  CHECK(pool.frame(balls).points.size() == count + 2);
}

TEST_CASE("foam is where velocities differ, and nowhere at rest", "[view][liquid]") {
  std::vector<Vec3> x = lattice(12, Real(0.1)), v(x.size(), vec3(3, 0, 0));
  LiquidShape shape;
  shape.sort(x, v, Real(0.1), Real(0.5));
  CHECK_FALSE(shape.foams());
  CHECK(shape.bulk().size() == x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    if (x[i][0] > Real(0.8)) v[i] = vec3(0, i % 2 ? Real(-3) : Real(3), 0);
  shape.sort(x, v, Real(0.1), Real(0.5));
  REQUIRE(shape.foams());
  CHECK(shape.foam(vec3(Real(1.1), Real(0.5), Real(0.5))) == 1);
  CHECK(shape.foam(vec3(Real(0.1), Real(0.5), Real(0.5))) == 0);
  CHECK(shape.foam(vec3(9, 9, 9)) == 0);
}

TEST_CASE("smoothing takes ripples away and leaves the volume", "[view][liquid]") {
  // a cube of quads, each of its vertices a little off
  const int n = 12;
  std::vector<Vec3> x, scratch;
  std::vector<std::uint32_t> triangles;
  std::vector<float> weights;
  std::map<std::array<int, 3>, std::uint32_t> known;
  const auto vertex = [&](std::array<int, 3> c) {
    const auto [at, fresh] = known.try_emplace(c, static_cast<std::uint32_t>(x.size()));
    if (fresh) {
      const Vec3 p = Vec3(Real(c[0]), Real(c[1]), Real(c[2])) - Vec3::Constant(Real(n) / 2);
      const Real ripple = 1 + Real(0.03) * ((c[0] + c[1] + c[2]) % 2 == 0 ? 1 : -1);
      x.push_back(p / length(p) * ripple);
    }
    return at->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto corner = [&](int u, int w) {
            std::array<int, 3> c{};
            c[static_cast<std::size_t>(axis)] = side * n;
            c[static_cast<std::size_t>((axis + 1) % 3)] = u, c[static_cast<std::size_t>((axis + 2) % 3)] = w;
            return vertex(c);
          };
          const std::uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1), d = corner(i, j + 1);
          if (side == 1)
            triangles.insert(triangles.end(), {a, b, c, a, c, d});
          else
            triangles.insert(triangles.end(), {a, c, b, a, d, c});
        }
  const auto measure = [&](Real& volume, Real& ripple) {
    volume = ripple = 0;
    for (std::size_t t = 0; t < triangles.size(); t += 3)
      volume += dot(x[triangles[t]], cross(x[triangles[t + 1]], x[triangles[t + 2]])) / 6;
    for (const Vec3& p : x) ripple += std::abs(length(p) - 1) / static_cast<Real>(x.size());
  };
  Real volume, ripple, volume_after, ripple_after;
  measure(volume, ripple);
  std::vector<float> foam(x.size(), 0.5f);
  smooth_mesh(x, triangles, foam, 2, scratch, weights);
  measure(volume_after, ripple_after);
  CHECK(ripple_after < Real(0.4) * ripple);
  CHECK(volume_after == Approx(volume).epsilon(0.02));
  for (const float f : foam) CHECK(f == Approx(0.5));
}

TEST_CASE("beyond the limit a liquid is drawn by splats, and that is said", "[view][gl][liquid]") {
  Pool pool, empty(0);
  Toggles few;
  few.liquid_limit = 10;
  const Frame f = pool.frame(few);
  CHECK(f.meshes.empty());
  REQUIRE(f.liquids.size() == 1);
  CHECK(f.liquids[0].mesh == kNone);
  REQUIRE(f.notes.size() == 1);
  const std::string said = f.notes[0].text;
  CHECK_THAT(said, Catch::Contains("fluid \"pond\""));
  CHECK_THAT(said, Catch::Contains("up to 10 particles"));
  CHECK_THAT(said, Catch::Contains(std::to_string(pool.world.need<Fluid>().count())));
  CHECK_THAT(said, Catch::Contains("--show liquid"));
  // it looks like the surface
  const Image splats = shot(f), surface = shot(pool.frame());
  CHECK(contrast(splats) > 40);
  CHECK(blueness(splats) == Approx(blueness(surface)).epsilon(0.15));
  CHECK(blueness(splats) > blueness(shot(empty.frame())) + 0.05);
  set_toggles(few, "liquid");
  CHECK(pool.frame(few).notes.empty());
  CHECK(pool.frame(few).meshes.size() == 1);
}

TEST_CASE("a liquid in a plane is a sheet without holes", "[view][gl][liquid]") {
  Pool pool(1, 2);
  const auto covered = [](const Image& image) {
    int n = 0;
    for (int y = 50; y < 58; ++y)
      for (int x = 60; x < 100; ++x) n += part(image, x, y, 2) > part(image, x, y, 0) + 25;
    return n;
  };
  const Image sheet = shot(pool.frame(), 0);
  CHECK(covered(sheet) == 8 * 40);
  // and it ends where the liquid does: sky above
  CHECK(part(sheet, 80, 4, 2) < part(sheet, 80, 4, 0) + 25);
}

TEST_CASE("a liquid of 100,000 particles is collected at the pace of pictures", "[view][liquid][speed]") {
  World world({}, catalog());
  FluidDesc d;
  d.spacing = Real(0.02), d.max_particles = 200000;
  Fluid& fluid = world.need<Fluid>();
  const ObjectId id = fluid.add_fluid(d);
  fluid.fill(id, *make_box(1, Real(0.8), 1), Pose{vec3(0, Real(0.4), 0), {}}, Vec3::Zero());
  Collector collector;
  Frame frame;
  double best = 1e9;
  for (int i = 0; i < 9; ++i) {
    const double start = own_seconds();
    collector.collect(world, nullptr, {}, frame);
    best = std::min(best, own_seconds() - start);
  }
  std::vector<Vec3> x;
  fluid.positions(id, x);
  LiquidSurface surface;
  IsoMesh mesh;
  double alone = 1e9;
  for (int i = 0; i < 9; ++i) {
    const double start = own_seconds();
    surface.build(x, d.spacing, false, mesh);
    alone = std::min(alone, own_seconds() - start);
  }
  CHECK(frame.notes.empty());
  WARN(fluid.count() << " particles: " << 1e3 * best << " ms, of which the surface " << 1e3 * alone << " ms, "
                     << frame.indices.size() / 3 << " triangles");
  // what the passes of a liquid add to a picture, by surface and by splats
  Headless gl(1280, 720);
  Renderer renderer(gl.loader());
  const auto picture = [&](const Frame& f) {
    Camera c;
    c.fit(frame, 16.0f / 9);
    double least = 1e9;
    for (int i = 0; i < 4; ++i) {
      const auto start = std::chrono::steady_clock::now();
      renderer.draw(f, c, {}, gl.target());
      gl.read();
      least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return 1e3 * least;
  };
  Toggles few, balls;
  few.liquid_limit = 1;
  set_toggles(balls, "speed");
  Frame splats, points, nothing = frame, opaque = frame;
  opaque.meshes[0].liquid = kNone, opaque.liquids.clear();
  collector.collect(world, nullptr, few, splats), collector.collect(world, nullptr, balls, points);
  nothing.meshes.clear(), nothing.liquids.clear();
  WARN("a picture of 1280 x 720: " << picture(nothing) << " ms without, " << picture(opaque)
                                   << " ms as an opaque mesh, " << picture(frame) << " ms with the liquid, "
                                   << picture(splats) << " ms by splats, " << picture(points) << " ms by balls");
#if defined(NDEBUG) && !defined(FEDER_SANITIZED)
  CHECK(1e3 * best < 60);  // 22 ms on a machine that does nothing else
#endif
}
