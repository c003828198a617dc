// Drops that fly alone: they pass nothing, cost nothing before they meet something, and leave what rests at rest.
#include "fluid/any_solver.h"
#include "fluid/tank.h"

using namespace feder;

namespace {

constexpr Real kDropSpacing = Real(0.05);

// The middle of a lattice of `count` particles, the first ones of a cube.
std::vector<Vec3> drop(int count, const Vec3& at, Real spacing = kDropSpacing) {
  int side = 1;
  while (side * side * side < count) ++side;
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i)
    points.push_back(at + spacing * vec3(static_cast<Real>(i % side), static_cast<Real>(i / (side * side)),
                                         static_cast<Real>(i / side % side)));
  return points;
}

// A calm pool, 20 cm deep, in a tank of planes.
struct Pool {
  explicit Pool(const std::string& solver) : w(one_substep(), fluid_catalog()) {
    const Real width = 10 * kDropSpacing;
    add_tank(w, vec3(width, 0, width));
    FluidDesc d;
    d.solver = solver, d.spacing = kDropSpacing;
    id = add_water(w, d, vec3(width, 4 * kDropSpacing, width));
    run(w, 0.25);  // else it is not calm
  }
  void throw_in(const std::vector<Vec3>& points, const Vec3& velocity) {
    w.need<Fluid>().fill(id, points, velocity);
    flying = points.size();
  }
  Real lowest() {
    Real y = kInfinity;
    const std::vector<Vec3> x = places(w, id);
    for (std::size_t k = x.size() - flying; k < x.size(); ++k) y = std::min(y, x[k][1]);
    return y;
  }
  std::uint64_t taken() { return w.need<Fluid>().solver_substeps(id); }
  World w;
  ObjectId id;
  std::size_t flying = 0;
};

}  // namespace

TEST_CASE("what flies over a calm pool takes no more substeps than the pool until it meets it", "[fluid][drop]") {
  const std::string solver = any_fluid_solver();
  const int count = GENERATE(1, 7, 30);
  const Vec3 velocity = GENERATE(Vec3(0, -30, 0), Vec3(0, -100, 0), Vec3(Real(0.2), -30, Real(-0.1)));
  CAPTURE(solver, count, velocity[0], velocity[1]);
  Pool alone(solver), under(solver);
  const Real top = 4 * kDropSpacing, way = length(velocity) / 240;
  under.throw_in(drop(count, vec3(Real(0.175), top + 3, Real(0.175))), velocity);
  const std::uint64_t before_alone = alone.taken(), before_under = under.taken();
  int steps = 0;
  // its particles fall a little faster in a step, and cells of two supports may come between
  for (; under.lowest() > top + way + 6 * kDropSpacing; ++steps) alone.w.step(), under.w.step();
  CHECK(steps > 5);
  const double taken = static_cast<double>(under.taken() - before_under);
  CHECK(taken <= 1.2 * static_cast<double>(alone.taken() - before_alone));
}

TEST_CASE("a drop that comes down on a pool is met by it, not put inside", "[fluid][drop]") {
  if (!kFull) return;
  const std::string solver = any_fluid_solver();
  const int count = GENERATE(1, 7);
  CAPTURE(solver, count);
  Pool p(solver);
  const Real top = 4 * kDropSpacing, speed = 30;
  p.throw_in(drop(count, vec3(Real(0.2), top + 1, Real(0.2))), vec3(0, -speed, 0));
  const double was = p.w.energy().kinetic;
  std::uint64_t before = 0;
  while (p.lowest() > top + kDropSpacing) {
    before = p.taken();
    p.w.step();
  }
  CHECK(p.taken() - before >= 3);  // it crosses 2.5 spacings in a substep
  double most = 0;
  for (int k = 0; k < 60; ++k) {
    p.w.step();
    most = std::max(most, p.w.energy().kinetic);
  }
  CHECK(most < 1.1 * was);  // it falls by a metre: 2 %
}

// Its speed through space is no fluid's: what is at rest in its own frame needs what it needs at rest.
TEST_CASE("what flies alone takes the substeps that it takes at rest", "[fluid][drop]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  std::uint64_t taken[2];
  for (int fast = 0; fast < 2; ++fast) {
    World w(one_substep(), fluid_catalog());
    FluidDesc d;
    d.solver = solver, d.spacing = kDropSpacing;
    const ObjectId id = w.need<Fluid>().add_fluid(d);
    w.need<Fluid>().fill(id, drop(64, vec3(0, 9, 0)), vec3(fast ? 40 : 0, 0, 0));
    run(w, 0.1);
    taken[fast] = w.need<Fluid>().solver_substeps(id);
  }
  CHECK(taken[1] <= taken[0]);
}

TEST_CASE("a lone drop passes neither thin walls nor bodies that come towards it", "[fluid][drop]") {
  const std::string solver = any_fluid_solver();
  const int count = GENERATE(1, 7);
  const Real speed = GENERATE(Real(20), Real(100), Real(400)), phase = GENERATE(Real(0), Real(0.31), Real(0.77));
  const bool body = GENERATE(false, true);
  CAPTURE(solver, count, speed, phase, body);
  WorldDesc desc = one_substep();
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  BodyDesc b;
  b.type = body ? BodyType::dynamic : BodyType::fixed;
  b.shape = make_box(Real(0.01), 1, 1), b.density = 8000;
  if (body) b.velocity = vec3(-20, 0, 0), b.position = vec3(Real(1.5), 0, 0);
  const ObjectId wall = w.need<Rigid>().add_body(b);
  FluidDesc d;
  d.solver = solver, d.spacing = kDropSpacing;
  const ObjectId id = w.need<Fluid>().add_fluid(d);
  w.need<Fluid>().fill(id, drop(count, vec3(-1 - phase * speed / 240, Real(-0.05), Real(-0.05))), vec3(speed, 0, 0));
  for (int k = 0; k < 40; ++k) {
    w.step();
    const Pose at = w.need<Rigid>().pose(wall);
    for (const Vec3& x : places(w, id)) {
      const Vec3 local = to_local(at, x);
      REQUIRE((local[0] < 0 || std::max(std::abs(local[1]), std::abs(local[2])) > Real(0.5)));
    }
  }
  CHECK(w.is_finite());
}

TEST_CASE("two drops that fly against each other take more substeps where they meet alone", "[fluid][drop]") {
  const std::string solver = any_fluid_solver();
  const int count = GENERATE(1, 27);
  CAPTURE(solver, count);
  WorldDesc desc = one_substep();
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  FluidDesc d;
  d.solver = solver, d.spacing = kDropSpacing;
  const ObjectId id = w.need<Fluid>().add_fluid(d);
  w.need<Fluid>().fill(id, drop(count, vec3(-1, 0, 0)), vec3(15, 0, 0));
  w.need<Fluid>().fill(id, drop(count, vec3(1, 0, 0)), vec3(-15, 0, 0));
  run(w, 10.0 / 240);  // 0.5 m apart at least
  CHECK(w.need<Fluid>().solver_substeps(id) == 10);
  std::uint64_t most = 0;
  for (int k = 0; k < 10; ++k) {
    const std::uint64_t before = w.need<Fluid>().solver_substeps(id);
    w.step();
    most = std::max(most, w.need<Fluid>().solver_substeps(id) - before);
  }
  CHECK(most >= 2);
}

TEST_CASE("what is fast and far leaves a calm pool calm, until it is there", "[fluid][drop]") {
  const std::string solver = any_fluid_solver();
  const bool body = GENERATE(false, true);
  const Real speed = GENERATE(Real(10), Real(30), Real(100));
  CAPTURE(solver, body, speed);
  Pool p(solver);
  const double calm = p.w.energy().kinetic;
  const Real top = 4 * kDropSpacing;
  double flying = 0;
  if (body) {
    BodyDesc b;
    b.shape = make_sphere(Real(0.1));
    b.position = vec3(Real(0.25), top + 1 + speed / 10, Real(0.25));
    b.velocity = vec3(0, -speed, 0);
    p.w.need<Rigid>().add_body(b);
    flying = 0.5 * 1000 * 4.0 / 3 * 3.14159265 * 0.001;
  } else {
    p.throw_in(drop(1, vec3(Real(0.2), top + 3, Real(0.2))), vec3(0, -speed, 0));
    flying = 0.5 * 1000 * std::pow(static_cast<double>(kDropSpacing), 3);
  }
  double v = static_cast<double>(speed), most = 0;
  for (int k = 0; k < 24 && (body || p.lowest() > top + 3 * kDropSpacing); ++k) {
    p.w.step();
    v += 9.81 / 240;
    most = std::max(most, p.w.energy().kinetic - flying * v * v);
  }
  const double mass = 1000 * std::pow(static_cast<double>(kDropSpacing), 3) * 400;
  CHECK(most - calm < 0.5 * mass * 0.05 * 0.05 + 0.002 * flying * v * v);  // 5 cm/s of the pool
}
