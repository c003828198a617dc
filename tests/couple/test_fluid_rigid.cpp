// Fluid and rigid bodies: what sensors count, whom the fluid wakes, and that a step of both allocates nothing.
#include <cstdlib>
#include <limits>
#include <new>

#include "couple/fluid_parts.h"
#include "support/catch.h"

// Everything that this program takes from the heap, arenas or not.
namespace {
std::size_t heap_calls = 0;
}
#ifndef FEDER_SANITIZED
[[gnu::noinline]] void* operator new(std::size_t n) {
  ++heap_calls;
  if (void* p = std::malloc(n ? n : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

using namespace feder;

namespace {

constexpr Real kSpacing = Real(0.1);

// Water in still air without gravity, and a box that feels for it.
struct Watched {
  explicit Watched(const std::string& solver) : world(still(), mixed_catalog()) {
    FluidDesc d;
    d.solver = solver, d.spacing = kSpacing, d.name = "water";
    water = fluid().add_fluid(d);
    fluid().fill(water, block(4, 2, 2, kSpacing, Vec3::Zero()), Vec3::Zero());
  }
  static WorldDesc still() {
    WorldDesc d;
    d.gravity = Vec3::Zero();
    return d;
  }
  Fluid& fluid() { return world.need<Fluid>(); }
  Rigid& rigid() { return world.need<Rigid>(); }
  ObjectId add_sensor(ShapePtr shape, const Vec3& at) {
    BodyDesc b;
    b.type = BodyType::fixed, b.sensor = true, b.name = "eye";
    b.shape = std::move(shape), b.position = at;
    return rigid().add_body(b);
  }
  // Steps, and collects sensor events: +count and -count, by sensor and fluid.
  std::vector<int> steps(int n, ObjectId sensor, ObjectId other) {
    std::vector<int> said;
    for (int k = 0; k < n; ++k) {
      world.step();
      for (const Event& e : world.events().list()) {
        if (e.kind != EventKind::sensor_enter && e.kind != EventKind::sensor_leave) continue;
        CHECK(e.a == sensor);
        CHECK(e.b == other);
        said.push_back(e.kind == EventKind::sensor_enter ? static_cast<int>(e.index) : -1);
        if (e.kind == EventKind::sensor_leave) CHECK(e.index == 0);
      }
    }
    return said;
  }
  World world;
  ObjectId water;
};

using Said = std::vector<int>;

}  // namespace

TEST_CASE("a sensor tells once how many particles are in it, and once that none is left", "[couple][fluid][sensor]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  Watched w(solver);
  // half of the particles: those with x < 0
  const ObjectId eye = w.add_sensor(make_box(1, 1, 1), Vec3(Real(-0.5), 0, 0));
  CHECK(w.steps(3, eye, w.water) == Said{8});
  SECTION("the fluid is drained") {
    w.fluid().add_drain(w.water, "sink", 0, make_box(3, 3, 3), Pose{});
    CHECK(w.steps(3, eye, w.water) == Said{-1});
    CHECK(w.fluid().particle_count(w.water) == 0);
  }
  SECTION("the fluid flows out and comes back") {
    std::vector<Vec3> v(16, Vec3(8, 0, 0));
    w.fluid().set_velocities(w.water, v);
    CHECK(w.steps(6, eye, w.water) == Said{-1});
    for (Vec3& u : v) u = -u;
    w.fluid().set_velocities(w.water, v);
    const Said back = w.steps(9, eye, w.water);
    REQUIRE(back.size() == 1);
    CHECK(back[0] > 0);
  }
  SECTION("the sensor is destroyed") {
    w.rigid().destroy_body(eye, "here");
    CHECK(w.steps(3, eye, w.water) == Said{-1});
    CHECK(w.world.objects().name(eye) == "eye");
  }
  SECTION("the fluid is destroyed") {
    w.fluid().destroy_fluid(w.water, "here");
    CHECK(w.steps(3, eye, w.water) == Said{-1});
    CHECK(w.world.objects().name(w.water) == "water");
  }
  SECTION("both are destroyed") {
    w.rigid().destroy_body(eye, "here"), w.fluid().destroy_fluid(w.water, "here");
    CHECK(w.steps(3, eye, w.water) == Said{-1});
  }
  SECTION("the sensor no longer is one") {
    w.rigid().set_sensor(eye, false);
    CHECK(w.steps(3, eye, w.water) == Said{-1});
  }
  SECTION("the filters part them, and let them meet again") {
    w.rigid().set_filter(eye, 1, 0);
    CHECK(w.steps(3, eye, w.water) == Said{-1});
    w.rigid().set_filter(eye, 1, 1);
    CHECK(w.steps(3, eye, w.water) == Said{8});
  }
  SECTION("the sensor goes somewhere else") {
    w.rigid().set_pose(eye, Pose{Vec3(0, 5, 0), Quat{}});
    CHECK(w.steps(3, eye, w.water) == Said{-1});
  }
  SECTION("a snapshot knows who is inside") {
    const std::string image = w.world.snapshot();
    w.rigid().set_pose(eye, Pose{Vec3(0, 5, 0), Quat{}});
    CHECK(w.steps(2, eye, w.water) == Said{-1});
    w.world.restore(image);
    CHECK(w.steps(2, eye, w.water).empty());
  }
}

TEST_CASE("a sensor of several parts says one number, for each of two fluids", "[couple][fluid][sensor]") {
  Watched w("pbf");
  FluidDesc d;
  d.solver = "pbf", d.spacing = kSpacing;
  const ObjectId oil = w.fluid().add_fluid(d);
  w.fluid().fill(oil, block(4, 1, 1, kSpacing, Vec3(0, 1, 0)), Vec3::Zero());
  const Pose left{Vec3(-1, 0, 0), Quat{}}, right{Vec3(1, 0, 0), Quat{}};
  const ObjectId eye =
      w.add_sensor(make_compound({{make_box(2, 4, 4), left}, {make_box(2, 4, 4), right}}), Vec3::Zero());
  w.world.step();
  int water = 0, oils = 0, events = 0;
  for (const Event& e : w.world.events().list()) {
    if (e.kind != EventKind::sensor_enter) continue;
    ++events;
    CHECK(e.a == eye);
    (e.b == oil ? oils : water) += static_cast<int>(e.index);
  }
  CHECK(events == 2);
  CHECK(water == 16);
  CHECK(oils == 4);
}

TEST_CASE("a fluid wakes the body that it presses on, and says so", "[couple][fluid][wake]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  World w(WorldDesc{}, mixed_catalog());
  Rigid& rigid = w.need<Rigid>();
  BodyDesc floor;
  floor.type = BodyType::fixed, floor.shape = make_plane(Vec3(0, 1, 0), 0);
  rigid.add_body(floor);
  ObjectId stone[2];
  for (int k = 0; k < 2; ++k) {
    BodyDesc b;
    b.shape = make_box(Real(0.3), Real(0.3), Real(0.3)), b.sleeping = true;
    b.position = Vec3(static_cast<Real>(5 * k), Real(0.15), 0);
    stone[k] = rigid.add_body(b);
  }
  Fluid& fluid = w.need<Fluid>();
  FluidDesc d;
  d.solver = solver, d.spacing = kSpacing;
  const ObjectId elsewhere = fluid.add_fluid(d), rain = fluid.add_fluid(d);
  fluid.fill(elsewhere, block(2, 1, 2, kSpacing, Vec3(-5, Real(0.05), 0)), Vec3::Zero());
  fluid.fill(rain, block(3, 2, 3, kSpacing, Vec3(0, Real(0.6), 0)), Vec3::Zero());
  int woken = 0;
  double when = 0;
  for (int k = 0; k < 40; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::wake) continue;
      ++woken;
      when = when > 0 ? when : w.time();
      CHECK(e.a == stone[0]);
      CHECK(e.b == rain);
      CHECK(e.cause == kFluidCause);
    }
  }
  CHECK(woken == 1);
  CHECK(when > 0.15);  // the lowest falls 0.2 m
  CHECK(when < 0.25);
}

TEST_CASE("a body gone bad in water is fixed and leaves the water finite", "[couple][fluid]") {
  for (const char* solver : {"pbf", "wcsph"}) {
    Watched w(solver);
    BodyDesc d;
    d.shape = make_box(kSpacing, kSpacing, kSpacing), d.position = Vec3(0, Real(0.2), 0);
    const ObjectId box = w.rigid().add_body(d);
    w.world.step();
    // the sum of two finite forces is not finite
    for (int k = 0; k < 2; ++k) w.rigid().apply_force(box, Vec3(std::numeric_limits<Real>::max(), 0, 0), nullptr);
    for (int k = 0; k < 3; ++k) w.world.step();
    INFO(solver);
    CHECK(w.rigid().bodies().type[w.rigid().index(box)] == BodyType::fixed);
    CHECK(w.world.is_finite());
  }
}

TEST_CASE("a step of fluid and bodies takes nothing from the heap", "[couple][fluid][threads]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  CAPTURE(solver);
  WorldDesc wd;
  wd.threads = GENERATE(1, 2);
  World w(wd, mixed_catalog());
  Rigid& rigid = w.need<Rigid>();
  const Real size = Real(0.6);
  for (int axis = 0; axis < 3; ++axis)
    for (const Real side : {Real(1), Real(-1)}) {
      if (axis == 1 && side < 0) continue;
      Vec3 n = Vec3::Zero();
      n[axis] = side;
      BodyDesc b;
      b.type = BodyType::fixed, b.shape = make_plane(n, side > 0 ? Real(0) : -size);
      rigid.add_body(b);
    }
  FluidDesc d;
  d.solver = solver, d.spacing = Real(0.06), d.viscosity = 1, d.surface_tension = 1;
  Fluid& fluid = w.need<Fluid>();
  const ObjectId water = fluid.add_fluid(d);
  fluid.fill(water, block(10, 5, 10, d.spacing, Vec3(size / 2, Real(0.15), size / 2)), Vec3::Zero());
  BodyDesc eye;
  eye.type = BodyType::fixed, eye.sensor = true;
  eye.shape = make_box(Real(0.2), Real(0.2), Real(0.2)), eye.position = Vec3(Real(0.3), Real(0.3), Real(0.3));
  rigid.add_body(eye);
  for (int k = 0; k < 3; ++k) {
    BodyDesc b;
    b.shape = k == 0 ? make_sphere(Real(0.1)) : make_box(Real(0.15), Real(0.15), Real(0.15));
    b.density = static_cast<Real>(300 + 900 * k);
    b.position = Vec3(Real(0.15) + Real(0.15) * static_cast<Real>(k), Real(0.5), Real(0.3));
    rigid.add_body(b);
  }
  for (int k = 0; k < 80; ++k) w.step();
  const std::uint64_t before = w.allocations();
  const std::size_t heap_before = heap_calls;
  for (int k = 0; k < 20; ++k) w.step();
  const std::size_t heap_after = heap_calls;
  CHECK(w.allocations() == before);
  CHECK(heap_after == heap_before);
#ifndef FEDER_SANITIZED
  CHECK(heap_before > 0);  // they are counted
#endif
  CHECK(w.is_finite());
}
