// What nets do beside swinging: pins, breaking, removal, forces, quarantine, warnings, snapshots, threads.
#include <cmath>

#include "integrate/integrator.h"
#include "nets.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

Vec3 momentum_vector(World& w) {
  const Momentum m = w.momentum();
  return vec3(static_cast<Real>(m.linear[0]), static_cast<Real>(m.linear[1]), static_cast<Real>(m.linear[2]));
}

// A net with all sorts of springs; `seed` moves it about.
NetDesc tangle(int seed, const char* integrator) {
  NetDesc d = row_net(12, Real(0.5), Real(0.3), 400);
  for (std::uint32_t i = 0; i + 2 < 12; ++i) d.springs.push_back({i, i + 2, 100, Real(0.5), -1});
  for (std::size_t i = 0; i < 12; ++i)
    d.points[i] += Vec3(0, static_cast<Real>(seed), Real(0.03) * static_cast<Real>(i % 3));
  d.springs[3].break_strain = Real(0.05);
  d.damping = Real(0.1);
  d.integrator = integrator;
  return d;
}

}  // namespace

TEST_CASE("pinned points stay until unpinned", "[springs]") {
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  const ObjectId net = s.add_net(row_net(3, 1, 1, 1000));
  s.pin(net, 0);
  CHECK(s.pinned(net, 0));
  step(w, 30);
  CHECK(s.point(net, 0) == Vec3(0, 0, 0));
  CHECK(s.point(net, 2)[1] < Real(-0.3));
  s.unpin(net, 0);
  step(w, 30);
  CHECK(s.point(net, 0)[1] < Real(-0.3));
  CHECK(s.point_mass(net, 0) == 1);
}

TEST_CASE("a spring breaks at its strain, with one event, and keeps its index", "[springs]") {
  World w(weightless(), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(4, 1, 1, 100);
  d.springs[1].break_strain = Real(0.2);
  const ObjectId net = s.add_net(d);
  s.pin(net, 0);
  s.set_velocity(net, 3, Vec3(8, 0, 0));
  int breaks = 0;
  for (int k = 0; k < 120; ++k) {
    const Real before = s.strain(net, 1);
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != kSpringBreak) continue;
      ++breaks;
      CHECK(e.a == net);
      CHECK(e.index == 1);
      CHECK(e.force >= 20);
      CHECK(e.force < 30);
      CHECK(before <= Real(0.2));
    }
  }
  CHECK(breaks == 1);
  CHECK(s.strain(net, 1) == 0);
  CHECK(s.spring_count(net) == 3);
  CHECK(s.spring(net, 2).stiffness == 100);
  // the two halves are on their own now
  CHECK(s.point(net, 2)[0] > 5);
  s.remove_spring(net, 0);
  CHECK(s.add_spring(net, {0, 3, 50, 0, 1, kInfinity}) == 3);
  CHECK(s.spring(net, 3).stiffness == 50);
}

TEST_CASE("added springs pull, also under an implicit method", "[springs]") {
  const char* integrator = GENERATE("symplectic_euler", "implicit_euler");
  World w(weightless(), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(3, 1, 1, 100);
  d.integrator = integrator;
  const ObjectId net = s.add_net(d);
  step(w, 5);
  CHECK(std::fabs(s.point(net, 2)[0] - 2) < Real(1e-5));
  s.add_spring(net, {2, 0, 100, 1, 1, kInfinity});
  step(w, 5);
  CHECK(s.point(net, 2)[0] < Real(1.95));
}

TEST_CASE("nets are separate, and destroying one leaves the others as they were", "[springs]") {
  World a(WorldDesc{}, kSpringsOnly), b(WorldDesc{}, kSpringsOnly);
  Springs &sa = a.need<Springs>(), &sb = b.need<Springs>();
  const ObjectId gone = sa.add_net(tangle(3, "rk4"));
  const ObjectId kept = sa.add_net(tangle(1, "symplectic_euler"));
  const ObjectId alone = sb.add_net(tangle(1, "symplectic_euler"));
  step(a, 10), step(b, 10);
  sa.destroy_net(gone, "test");
  CHECK_FALSE(a.objects().alive(gone));
  step(a, 10), step(b, 10);
  CHECK(sa.count() == 12);
  for (std::size_t i = 0; i < 12; ++i) CHECK(sa.point(kept, i) == sb.point(alone, i));
  sa.destroy_net(kept, "test");
  CHECK(sa.count() == 0);
  CHECK(a.plan().nodes().size() == 2);  // begin and finish: no nets, no passes
  a.step();
}

TEST_CASE("force generators act on the nets they are meant for", "[springs]") {
  World w(weightless(), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(1, 0, 0)};
  d.masses = {2};
  const ObjectId first = s.add_net(d), second = s.add_net(d);
  Params p;
  p.set("acceleration", std::vector<double>{0, 0, 5});
  ForceEntry on;
  on.target = second;
  const ObjectId force = w.add_force("gravity", p, std::move(on), "", 0);
  step(w, 60);
  CHECK(s.velocity(first, 0) == Vec3(0, 0, 0));
  CHECK(static_cast<double>(s.velocity(second, 0)[2]) == Approx(5).epsilon(1e-4));
  CHECK(w.energy().kinetic + w.energy().potential == Approx(0).margin(1.0));  // order 1: half a substep
  w.remove_force(force, "");
  s.set_script_force(first, 0, Vec3(0, 6, 0));
  step(w, 60);
  CHECK(static_cast<double>(s.velocity(first, 0)[1]) == Approx(3).epsilon(1e-4));
  CHECK(static_cast<double>(s.velocity(second, 0)[2]) == Approx(5).epsilon(1e-4));
  s.clear_script_forces();
  step(w, 1);
  CHECK(static_cast<double>(s.velocity(first, 0)[1]) == Approx(3).epsilon(1e-4));
}

TEST_CASE("an orbit around an attractor closes, with every integrator that keeps energy", "[springs]") {
  World w(weightless(2 * 3.14159265358979 / 600, 10), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(1, 0, 0)};
  d.velocities = {Vec3(0, 1, 0)};
  d.masses = {3};
  const char* integrator = GENERATE("velocity_verlet", "rk4", "symplectic_euler");
  CAPTURE(integrator);
  d.integrator = integrator;
  const ObjectId net = s.add_net(d);
  ForceEntry all;
  all.all = true;
  w.add_force("attractor", Params(), std::move(all), "", 0);
  step(w, 600);
  CHECK(length(s.point(net, 0) - Vec3(1, 0, 0)) < Real(5e-3));
  const Energy e = w.energy();
  CHECK(e.kinetic == Approx(1.5).epsilon(2e-3));
  CHECK(e.potential == Approx(-3).epsilon(2e-3));
}

TEST_CASE("implicit Euler feels stiff force generators", "[springs]") {
  // an anchor spring of h w = 100 that every explicit method would blow up on
  World w(weightless(1.0 / 60, 1), kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(Real(0.6), 0, 0)};
  d.masses = {1};
  d.integrator = "implicit_euler";
  const ObjectId net = s.add_net(d);
  Params p;
  p.set("stiffness", 3.6e7);
  p.set("rest_length", 0.5);
  ForceEntry all;
  all.all = true;
  w.add_force("spring", p, std::move(all), "", 0);
  step(w, 10);
  CHECK(static_cast<double>(s.point(net, 0)[0]) == Approx(0.5).epsilon(1e-3));
}

TEST_CASE("a net that goes non-finite is held, named, and reported", "[springs]") {
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc bad = row_net(3, 1, 1, Real(1e9));
  bad.name = "wild";
  bad.integrator = "explicit_euler";
  const ObjectId wild = s.add_net(bad), calm = s.add_net(row_net(3, 1, 1, 10));
  s.set_velocity(wild, 0, Vec3(3, 1, 0));
  int warnings = 0;
  for (int k = 0; k < 200; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "non_finite") {
        ++warnings;
        CHECK(e.a == wild);
        CHECK_THAT(w.events().warning_message(e), Catch::Contains("wild"));
      }
    for (std::size_t i = 0; i < 3; ++i) CHECK(is_finite(s.point(wild, i)));
  }
  CHECK(warnings == 1);
  CHECK(s.quarantined(wild));
  CHECK_FALSE(w.is_finite());
  CHECK_FALSE(s.quarantined(calm));
  CHECK(s.point(calm, 0)[1] < -10);
}

TEST_CASE("a step beyond the stability limit is warned about once, with what would do", "[springs]") {
  // the fastest mode of a long chain is 2 sqrt(k/m) = 2000/s: h w = 8.3 with 4 substeps of 1/60
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d = row_net(30, 1, 1, Real(1e6));
  d.name = "rope";
  const ObjectId net = s.add_net(d);
  CHECK(static_cast<double>(s.max_frequency(net)) == Approx(2000).epsilon(1e-5));
  w.step();
  REQUIRE(warning_of(w) == "stiff");
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning) {
      CHECK_THAT(w.events().warning_message(e), Catch::Contains("rope") && Catch::Contains("17 substeps"));
    }
  w.step();
  CHECK(warning_of(w) == "");

  WorldDesc enough;
  enough.substeps = 17;
  World calm(enough, kSpringsOnly);
  calm.need<Springs>().add_net(d);
  calm.step();
  CHECK(warning_of(calm) == "");
  World implicit(WorldDesc{}, kSpringsOnly);
  d.integrator = "implicit_euler";
  implicit.need<Springs>().add_net(d);
  implicit.step();
  CHECK(warning_of(implicit) == "");
}

TEST_CASE("free nets keep momentum", "[springs]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const char* integrator = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(integrator);
  World w(weightless(1e-3), kSpringsOnly);  // short enough for the method that is never stable
  NetDesc d = tangle(0, integrator);
  d.damping = 0;
  Springs& s = w.need<Springs>();
  const ObjectId net = s.add_net(d);
  s.set_velocity(net, 4, Vec3(1, 2, 3));
  const Vec3 before = momentum_vector(w);
  step(w, 120);
  CHECK(length(momentum_vector(w) - before) < Real(2e-5) * length(before));
}

TEST_CASE("restore then run equals run, bit for bit", "[springs]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const char* integrator = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(integrator);
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  const ObjectId first = s.add_net(tangle(0, integrator)), second = s.add_net(tangle(1, "rk4"));
  s.pin(first, 0);
  step(w, 20);
  const std::string image = w.snapshot();
  const std::uint64_t then = w.hash();
  step(w, 20);
  const std::uint64_t after = w.hash();
  CHECK(after != then);

  s.destroy_net(second, "test");
  s.unpin(first, 0);
  s.add_spring(first, {0, 5, 10, 0, 1, kInfinity});
  step(w, 3);
  w.restore(image);
  CHECK(w.hash() == then);
  CHECK(w.objects().alive(second));
  step(w, 20);
  CHECK(w.hash() == after);
}

TEST_CASE("the number of threads changes nothing, and stepping allocates nothing", "[springs][threads]") {
  std::uint64_t hashes[2];
  for (int run = 0; run < 2; ++run) {
    WorldDesc d;
    d.threads = run == 0 ? 1 : 3;
    World w(d, kSpringsOnly);
    Springs& s = w.need<Springs>();
    for (int k = 0; k < 7; ++k) {
      NetDesc net = tangle(k, integrators()[static_cast<std::size_t>(k) % integrators().size()].name);
      net.springs[3].break_strain = 10;  // looked at, but an event would be the first of its buffer
      s.add_net(net);
    }
    ForceEntry all;
    all.all = true;
    Params p;
    p.set("velocity", std::vector<double>{2, 0, 1});
    w.add_force("wind", p, std::move(all), "", 0);
    step(w, 5);
    const std::uint64_t before = w.allocations();
    step(w, 50);
    CHECK(w.allocations() == before);
    hashes[run] = w.hash();
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("impossible nets are refused and leave the world as it was", "[springs]") {
  World w(WorldDesc{}, kSpringsOnly);
  Springs& s = w.need<Springs>();
  const std::uint64_t before = w.hash();
  const auto refused = [&](auto&& edit, const char* part) {
    NetDesc d = row_net(3, 1, 1, 100);
    edit(d);
    CHECK_THROWS_WITH(s.add_net(d), Catch::Contains(part));
  };
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  refused([&](NetDesc& d) { d.masses[1] = 0; }, "masses[2]");
  refused([&](NetDesc& d) { d.masses[1] = nan; }, "masses[2]");
  refused([&](NetDesc& d) { d.masses.pop_back(); }, "one mass per point");
  refused([&](NetDesc& d) { d.points[2][1] = nan; }, "points[3]");
  refused([&](NetDesc& d) { d.springs[1].j = 7; }, "springs[2]");
  refused([&](NetDesc& d) { d.springs[1].j = 1; }, "two different points");
  refused([&](NetDesc& d) { d.springs[0].stiffness = -1; }, "springs[1].stiffness");
  refused([&](NetDesc& d) { d.integrator = "rk5"; }, "rk4");
  refused([&](NetDesc& d) { d.integrator_options.set("dampign", 1.0); }, "dampign");
  refused([&](NetDesc& d) { d.points.clear(), d.masses.clear(); }, "at least one point");
  CHECK(s.count() == 0);
  CHECK(w.hash() == before);
  const ObjectId net = s.add_net(row_net(3, 1, 1, 100));
  CHECK_THROWS_WITH(s.point(net, 3), Catch::Contains("from 1 to 3, got 4"));
  CHECK_THROWS_AS(s.set_velocity(net, 0, Vec3(nan, 0, 0)), SceneError);
}

TEST_CASE("a net with faces sinks through still air as a sheet does; one without falls as in vacuum",
          "[springs][air]") {
  const bool faces = GENERATE(true, false);
  const double density = GENERATE(0.0, 1.2);
  WorldDesc wd;
  wd.options.set("air_density", density);
  World w(wd, kSpringsOnly);
  Springs& s = w.need<Springs>();
  NetDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 0, 1), Vec3(0, 0, 1)};
  d.masses = {Real(0.2 / 3), Real(0.1 / 3), Real(0.2 / 3), Real(0.1 / 3)};  // by their share of the faces
  for (std::uint32_t i = 0; i < 4; ++i)
    for (std::uint32_t j = i + 1; j < 4; ++j) d.springs.push_back({i, j, 100, Real(0.1)});
  if (faces) d.faces = {0, 2, 1, 0, 3, 2};
  const ObjectId net = s.add_net(d);
  for (int k = 0; k < 180; ++k) w.step();
  const double speed = -static_cast<double>(s.velocity(net, 0)[1] + s.velocity(net, 2)[1]) / 2;
  CAPTURE(faces, density);
  if (faces && density > 0)
    CHECK(speed == Approx(std::sqrt(2 * 0.2 * 9.81 / (1.02 * density))).epsilon(0.05));
  else
    CHECK(speed == Approx(9.81 * 3).epsilon(1e-3));
}
