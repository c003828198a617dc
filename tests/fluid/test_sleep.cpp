// Calm water sleeps and costs nothing, holds what floats in it, and wakes when something happens to it.
#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

constexpr Real kSpacing = Real(0.05);

// A tank of eight by eight spacings whose far wall is a body of its own: a gate.
struct Pond {
  World w;
  ObjectId gate, fluid;
  explicit Pond(const std::string& solver, int threads = 1, bool sleeping = true, Real spacing = kSpacing)
      : w(desc(threads, sleeping), fluid_catalog()) {
    const Real wide = 8 * spacing;
    add_plane(w, vec3(0, 1, 0), 0), add_plane(w, vec3(1, 0, 0), 0);
    add_plane(w, vec3(0, 0, 1), 0), add_plane(w, vec3(0, 0, -1), -wide);
    BodyDesc b;
    b.type = BodyType::fixed;
    b.shape = make_plane(vec3(-1, 0, 0), -wide);
    gate = w.need<Rigid>().add_body(b);
    FluidDesc f;
    f.solver = solver, f.spacing = spacing;
    fluid = add_water(w, f, vec3(wide, wide, wide));
  }
  static WorldDesc desc(int threads, bool sleeping) {
    WorldDesc d = fluid_world(3, threads);
    d.sleeping = sleeping;
    return d;
  }
  bool asleep() { return w.need<Fluid>().asleep(fluid); }
  // Until it sleeps; s, or -1 where it does not within 12 s.
  double settle() {
    for (int k = 0; k < 720; ++k) {
      w.step();
      if (asleep()) return w.time();
    }
    return -1;
  }
  ObjectId drop(const Vec3& at, Real radius, Real density) {
    BodyDesc b;
    b.shape = make_sphere(radius), b.density = density, b.position = at;
    return w.need<Rigid>().add_body(b);
  }
};

Real height(World& w, ObjectId body) { return w.need<Rigid>().pose(body).position[1]; }

int count_events(World& w, EventKind kind, ObjectId of) {
  int n = 0;
  for (const Event& e : w.events().list()) n += e.kind == kind && e.a == of;
  return n;
}

}  // namespace

TEST_CASE("calm water sleeps and takes no substeps", "[fluid][sleep]") {
  if (!kFull) return;  // seconds of water
  const std::string solver = any_fluid_solver();
  const Real spacing = solver == "dfsph" ? GENERATE(Real(0.006), kSpacing, Real(0.1)) : kSpacing;
  CAPTURE(solver, spacing);
  Pond p(solver, 1, true, spacing);
  const double when = p.settle();
  CHECK(when > 1);
  REQUIRE(p.asleep());
  CHECK(count_events(p.w, EventKind::sleep, p.fluid) == 1);
  const std::uint64_t steps = p.w.need<Fluid>().solver_substeps(p.fluid);
  for (int k = 0; k < 60; ++k) p.w.step();
  CHECK(p.w.need<Fluid>().solver_substeps(p.fluid) == steps);
  CHECK(p.w.energy().kinetic == 0);
  CHECK(p.asleep());
}

TEST_CASE("sleeping water wakes when something happens to it", "[fluid][sleep]") {
  if (!kFull) return;
  Pond p("dfsph");
  REQUIRE(p.settle() > 0);
  World& w = p.w;
  Fluid& f = w.need<Fluid>();
  const std::string again = w.snapshot();
  const auto woken_by = [&](auto&& change) {
    w.restore(again);
    w.step();
    REQUIRE(p.asleep());  // as saved
    change();
    for (int k = 0; k < 3 && p.asleep(); ++k) w.step();
    return !p.asleep();
  };
  CHECK(woken_by([&] { f.wake(p.fluid); }));
  CHECK(woken_by([&] { w.need<Rigid>().destroy_body(p.gate, {}); }));
  CHECK(woken_by([&] { p.drop(vec3(Real(0.2), Real(0.45), Real(0.2)), Real(0.05), 500); }));
  CHECK(woken_by([&] {
    f.fill(p.fluid, *make_sphere(Real(0.06)), Pose{vec3(Real(0.2), Real(0.5), Real(0.2)), Quat::identity()},
           Vec3::Zero());
  }));
  CHECK(woken_by([&] { w.set_gravity(vec3(1, -9, 0)); }));
  CHECK(woken_by([&] {
    f.add_drain(p.fluid, "", 0, make_sphere(Real(0.1)), Pose{vec3(Real(0.2), 0, Real(0.2)), Quat::identity()});
  }));
  // a body that flies by does not
  CHECK_FALSE(woken_by([&] { p.drop(vec3(Real(0.2), 3, Real(0.2)), Real(0.05), 500); }));
}

TEST_CASE("what floats in calm water falls asleep before it, and wakes it", "[fluid][sleep]") {
  if (!kFull) return;
  Pond p("dfsph");
  const ObjectId ball = p.drop(vec3(Real(0.2), Real(0.4), Real(0.2)), Real(0.1), 400);
  REQUIRE(p.settle() > 0);
  Rigid& r = p.w.need<Rigid>();
  CHECK(r.asleep(ball));
  const Real level = height(p.w, ball);
  for (int k = 0; k < 60; ++k) p.w.step();
  CHECK(p.asleep());
  CHECK(height(p.w, ball) == level);
  r.set_velocity(ball, vec3(0, -2, 0));
  p.w.step();
  CHECK_FALSE(p.asleep());
  CHECK_FALSE(r.asleep(ball));
}

TEST_CASE("sleep of water is in snapshots and does not depend on threads", "[fluid][sleep]") {
  if (!kFull) return;
  Pond one("dfsph"), two("dfsph", 2), awake("dfsph", 1, false);
  const double when = one.settle();
  CHECK(two.settle() == when);
  CHECK(one.w.hash() == two.w.hash());
  for (int k = 0; k < (kAsserts ? 60 : 480); ++k) awake.w.step();
  CHECK_FALSE(awake.asleep());
  const std::string saved = one.w.snapshot();
  one.drop(vec3(Real(0.2), Real(0.6), Real(0.2)), Real(0.05), 3000);
  for (int k = 0; k < 30; ++k) one.w.step();
  CHECK_FALSE(one.asleep());
  const std::uint64_t hash = one.w.hash();
  one.w.restore(saved);
  CHECK(one.asleep());
  one.drop(vec3(Real(0.2), Real(0.6), Real(0.2)), Real(0.05), 3000);
  for (int k = 0; k < 30; ++k) one.w.step();
  CHECK(one.w.hash() == hash);
}
