// Soft bodies as a system: bad input, snapshots, threads, kernels, sleep, contact, what is said of a stiffness that is
// not resolved, what an empty world has of them.
#include "soft_bodies.h"
#include "state/bodies.h"

namespace feder::test {
namespace {

// A block that falls onto a box on the ground.
ObjectId add_scene(World& w, const std::string& solver, const char* kernels = nullptr) {
  BodyDesc ground;
  ground.type = BodyType::fixed;
  ground.shape = make_plane(Vec3(0, 1, 0), 0);
  BodyDesc box;
  box.shape = make_box(Real(0.4), Real(0.4), Real(0.4));
  box.position = Vec3(0, Real(0.2), 0);
  w.need<Rigid>().add_body(ground);
  w.need<Rigid>().add_body(box);
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.2), Real(0.3)), 4);
  d.pose.position = vec3(Real(0.02), Real(0.56), Real(0.01));
  d.solver = solver;
  if (kernels && solver != "implicit" && solver != "mass_spring") d.solver_options.set("kernels", std::string(kernels));
  return w.need<Soft>().add_soft(d);
}

SoftDesc one_tetrahedron() {
  SoftDesc d;
  d.points = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  d.tetrahedra = {0, 1, 2, 3};
  return d;
}

}  // namespace

TEST_CASE("soft bodies that cannot be are errors that say what was expected", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  const auto refused = [&](auto&& spoil, const std::string& text) {
    SoftDesc d = one_tetrahedron();
    spoil(d);
    CHECK_THROWS_WITH(soft.add_soft(d), Catch::Contains(text));
  };
  refused([](SoftDesc& d) { d.points.resize(3); }, "points: expected at least 4, got 3");
  refused([](SoftDesc& d) { d.points[3] = Vec3(1, 1, 0); }, "tetrahedra[1]: expected four corners with a volume");
  refused([](SoftDesc& d) { d.points[2][0] = kInfinity; }, "points[3]: expected finite numbers");
  refused([](SoftDesc& d) { d.tetrahedra[3] = 4; }, "tetrahedra[1]: expected point numbers from 1 to 4, got 5");
  refused([](SoftDesc& d) { d.tetrahedra.pop_back(); }, "tetrahedra: expected four point numbers");
  refused([](SoftDesc& d) { d.points.push_back(Vec3(5, 5, 5)); }, "points[5]: expected a point of some tetrahedron");
  refused(
      [](SoftDesc& d) {
        d.points.insert(d.points.end(), {Vec3(-1, -1, -1), vec3(-2, -1, -1)});
        d.tetrahedra.insert(d.tetrahedra.end(), {4, 1, 2, 3, 5, 1, 2, 3});
      },
      "expected at most two on each face");
  refused([](SoftDesc& d) { d.shape = make_box(1, 1, 1); }, "either points with tetrahedra or a shape");
  refused([](SoftDesc& d) { d = SoftDesc{}; }, "either points with tetrahedra or a shape");
  refused([](SoftDesc& d) { d.density = 0; }, "density: expected a number above 0");
  refused([](SoftDesc& d) { d.young = 0; }, "young: expected a number above 0");
  refused([](SoftDesc& d) { d.young = NAN; }, "young: expected a number above 0");
  refused([](SoftDesc& d) { d.poisson = Real(0.5); }, "poisson: expected a number above -1, up to 0.499");
  refused([](SoftDesc& d) { d.poisson = -1; }, "poisson: expected");
  refused([](SoftDesc& d) { d.damping = -1; }, "damping: expected");
  refused([](SoftDesc& d) { d.pins = {4}; }, "pins: expected point numbers from 1 to 4, got 5");
  refused([](SoftDesc& d) { d = soft_box(Vec3(1, 1, 1), 1000); }, "expected at most 1e7 cells");
  refused([](SoftDesc& d) { d = SoftDesc{}, d.shape = make_plane(Vec3(0, 1, 0), 0); }, "expected a solid");
  // a cube without its top
  refused(
      [](SoftDesc& d) {
        d = SoftDesc{};
        const std::vector<Vec3> v = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0),
                                     Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 1, 1), Vec3(0, 1, 1)};
        const std::vector<std::uint32_t> t = {0, 2, 1, 0, 3, 2, 0, 1, 5, 0, 5, 4, 1, 2, 6,
                                              1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
        d.shape = make_mesh(v, t);
      },
      "expected a closed mesh, got one with 4 open edges round 1 m2");
  CHECK(soft.soft_count() == 0);
  CHECK(w.objects().count(kSoftKind) == 0);
  // turned inside out: turned back
  SoftDesc turned = one_tetrahedron();
  std::swap(turned.tetrahedra[0], turned.tetrahedra[1]);
  const ObjectId id = soft.add_soft(turned);
  CHECK(number(soft.volume(id)) == Approx(1.0 / 6));
  CHECK(soft.inverted(id) == 0);
  CHECK_THROWS_AS(soft.point(id, 4), SceneError);
  CHECK_THROWS_AS(soft.strain(id, 1), SceneError);
  CHECK_THROWS_AS(soft.set_point(id, 0, vec3(NAN, 0, 0)), SceneError);
}

TEST_CASE("a block large enough for all loops in parts moves alike on any number of threads", "[soft][threads]") {
  const std::string solver = GENERATE("xpbd", "vbd");
  CAPTURE(solver);
  std::uint64_t hash = 0;
  for (const int threads : {1, 4}) {
    WorldDesc desc;
    desc.threads = threads;
    World w(desc, catalog());
    SoftDesc d = soft_box(vec3(1, 1, 1), 12);
    d.solver = solver;
    d.angular_velocity = vec3(1, 2, 3);
    w.need<Soft>().add_soft(d);
    for (int k = 0; k < 2; ++k) w.step();
    CHECK(w.is_finite());
    if (threads == 1) hash = w.hash();
    CHECK(w.hash() == hash);
  }
}

TEST_CASE("a block on a box goes on from a snapshot, whatever threads and kernels", "[soft][threads]") {
  const std::string solver = any_soft_solver();
  CAPTURE(solver);
  std::uint64_t hashes[4];
  for (int k = 0; k < 4; ++k) {
    WorldDesc desc;
    desc.threads = k == 1 ? 4 : k == 3 ? 2 : 1;
    World w(desc, catalog());
    add_scene(w, solver, k == 3 ? "plain" : nullptr);
    for (int i = 0; i < 30; ++i) w.step();
    if (k == 2) {
      const std::string image = w.snapshot();
      for (int i = 0; i < 10; ++i) w.step();
      w.restore(image);
    }
    for (int i = 0; i < 30; ++i) w.step();
    hashes[k] = w.hash();
  }
  CHECK(hashes[0] == hashes[1]);
  CHECK(hashes[0] == hashes[2]);
  CHECK(hashes[0] == hashes[3]);
}

TEST_CASE("a warm step allocates nothing", "[soft]") {
  const std::string solver = any_soft_solver();
  CAPTURE(solver);
  World w(WorldDesc{}, catalog());
  add_scene(w, solver);
  for (int i = 0; i < 60; ++i) w.step();
  const std::uint64_t allocations = w.allocations();
  for (int i = 0; i < 10; ++i) w.step();
  CHECK(w.allocations() == allocations);
}

TEST_CASE("a block comes to rest on a box and sleeps", "[soft]") {
  const std::string solver = any_soft_solver();
  CAPTURE(solver);
  World w(WorldDesc{}, catalog());
  const ObjectId id = add_scene(w, solver);
  Soft& soft = w.need<Soft>();
  int begun = 0, slept = 0;
  for (int i = 0; i < 60 * 12 && !soft.asleep(id); ++i) {
    w.step();
    for (const Event& e : w.events().list()) {
      begun += e.kind == EventKind::contact_begin && (e.a == id || e.b == id);
      slept += e.kind == EventKind::sleep && e.a == id;
    }
  }
  CHECK(begun >= 1);
  CHECK(slept == 1);
  CHECK(soft.asleep(id));
  CHECK(w.is_finite());
  // its weight shortens it by rho g h^2/(2 E) and a skin of half the thickness lies between
  Real lowest = 1;
  for (std::size_t i = 0; i < soft.point_count(id); ++i) lowest = std::min(lowest, soft.point(id, i)[1]);
  CHECK(std::fabs(number(lowest) - 0.4 - number(soft.info(id).thickness) / 2) < 0.001);
  CHECK(number(soft.max_strain(id)) < 0.05);
  CHECK(std::fabs(number(soft.volume(id)) / number(soft.rest_volume(id)) - 1) < 0.01);
  // pushed, it wakes
  soft.set_script_force(id, 0, Vec3(5, 0, 0));
  w.step();
  CHECK_FALSE(soft.asleep(id));
}

TEST_CASE("a ball thrown against a block hands on its momentum", "[soft]") {
  World w(weightless(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 4);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  const ObjectId id = soft.add_soft(d);
  BodyDesc ball;
  ball.shape = make_sphere(Real(0.05));
  ball.position = vec3(Real(-0.4), Real(0.03), Real(0.02));
  ball.velocity = Vec3(5, 0, 0);
  const ObjectId body = w.need<Rigid>().add_body(ball);
  const Momentum before = w.momentum();
  for (int i = 0; i < 30; ++i) w.step();
  const Momentum after = w.momentum();
  for (int k = 0; k < 3; ++k) {
    CHECK(std::fabs(after.linear[k] - before.linear[k]) < 1e-5 * before.linear[0]);
    CHECK(std::fabs(after.angular[k] - before.angular[k]) < 1e-3 * before.linear[0]);
  }
  CHECK(number(w.need<Rigid>().bodies().velocity[w.need<Rigid>().index(body)][0]) < 1);
  CHECK(number(soft.velocity(id, 0)[0]) > 0.05);
}

TEST_CASE("a stiffness that the solver substeps do not resolve is said with its cure", "[soft]") {
  World w(weightless(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 4);
  d.young = Real(1e6), d.max_substeps = 4;
  const ObjectId id = soft.add_soft(d);
  pull_faces(soft, id, Vec3(100, 0, 0));
  w.step();
  std::string text;
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning) text = w.events().warning_message(e);
  CHECK_THAT(text, Catch::Contains("would need") && Catch::Contains("acts as if young were") &&
                       Catch::Contains("max_substeps = "));
  w.step();
  CHECK(count_warnings(w, "substep_cap") == 0);  // once
  // what the warning says is what it does
  const double acts = std::stod(text.substr(text.find("young were ") + 11));
  settle(w, 2, 1e-3);
  CHECK((side(soft, id, 0) / 0.2 - 1) * acts == Approx(100).epsilon(0.02));
}

TEST_CASE("two soft bodies and a rope are held to each other and to a body", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 2);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  d.pose.position = Vec3(0, 2, 0);
  const ObjectId upper = soft.add_soft(d);
  d.pose.position = Vec3(0, Real(1.78), 0);
  const ObjectId lower = soft.add_soft(d);
  const auto near = [&](ObjectId id, const Vec3& place) {
    std::size_t best = 0;
    for (std::size_t i = 0; i < soft.point_count(id); ++i)
      if (length(Vec3(soft.rest_point(id, i) - place)) < length(Vec3(soft.rest_point(id, best) - place))) best = i;
    return best;
  };
  const Real q = Real(0.1);
  for (const Vec3& top : {vec3(-q, q, -q), vec3(q, q, -q), vec3(-q, q, q), vec3(q, q, q)}) {
    soft.pin(upper, near(upper, top));
    soft.attach_point(lower, near(lower, top), upper, near(upper, Vec3(top[0], -q, top[2])));
  }
  for (int k = 0; k < 120; ++k) w.step();
  const Vec3 a = soft.point(lower, near(lower, vec3(q, q, q))), b = soft.point(upper, near(upper, vec3(q, -q, q)));
  CHECK(number(length(Vec3(a - b))) < 0.005);
  CHECK(number(a[1]) > 1.8);
}

// Damping that acts beyond the range of its stages feeds what it should take: seams hold tetrahedra in strain.
TEST_CASE("two damped bodies that are stitched together fall down some stairs in one piece", "[soft]") {
  const double damping = GENERATE(0.005, 0.02, 0.05);
  CAPTURE(damping);
  WorldDesc desc;
  desc.substeps = 2;
  World w(desc, catalog());
  Rigid& rigid = w.need<Rigid>();
  BodyDesc floor;
  floor.type = BodyType::fixed;
  floor.shape = make_plane(Vec3(0, 1, 0), 0);
  rigid.add_body(floor);
  const double tread = 0.26, rise = 0.16, start = 1.41;
  for (int k = 0; k <= 6; ++k) {
    const double high = (6 - std::max(k - 1, 0)) * rise;
    BodyDesc stair;
    stair.type = BodyType::fixed, stair.friction_static = stair.friction_dynamic = Real(0.6);
    stair.shape = make_box(static_cast<Real>(k ? tread : 0.6), static_cast<Real>(high), Real(1.2));
    stair.position = vec3(static_cast<Real>(k ? (k - 0.5) * tread : -0.3), static_cast<Real>(high / 2), 0);
    rigid.add_body(stair);
  }
  Soft& soft = w.need<Soft>();
  SoftDesc d;
  d.young = Real(3e4), d.density = 250, d.damping = static_cast<Real>(damping), d.friction = Real(0.6);
  d.self_collision = false, d.velocity = Vec3(2, 0, 0), d.resolution = 6;
  d.shape = make_capsule(Real(0.09), Real(0.32)), d.group = 4, d.mask = 1;
  d.pose.position = vec3(Real(-0.2), static_cast<Real>(start), 0);
  const ObjectId torso = soft.add_soft(d);
  d.shape = make_capsule(Real(0.045), Real(0.26)), d.group = 8;
  d.pose.position = vec3(Real(-0.01), static_cast<Real>(start + 0.08), 0);
  d.pose.rotation = from_axis_angle(Vec3(0, 0, 1), Real(kPi / 2));
  const ObjectId arm = soft.add_soft(d);
  // where points of both are nearest
  struct Pair {
    Real far;
    std::size_t i, j;
  };
  std::vector<Pair> pairs, seams;
  for (std::size_t i = 0; i < soft.point_count(arm); ++i)
    for (std::size_t j = 0; j < soft.point_count(torso); ++j)
      pairs.push_back({length(Vec3(soft.point(arm, i) - soft.point(torso, j))), i, j});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.far < b.far; });
  for (const Pair& p : pairs) {
    if (std::any_of(seams.begin(), seams.end(), [&](const Pair& q) { return q.i == p.i || q.j == p.j; })) continue;
    soft.set_point(arm, p.i, soft.point(torso, p.j)), soft.attach_point(arm, p.i, torso, p.j);
    seams.push_back(p);
    if (seams.size() == 4) break;
  }
  double widest = 0, fastest = 0, mass = 0;
  for (const ObjectId id : {torso, arm})
    for (std::size_t i = 0; i < soft.point_count(id); ++i) mass += number(soft.point_mass(id, i));
  for (int k = 0; k < 240; ++k) {
    w.step();
    for (const Pair& p : seams)
      widest = std::max(widest, number(length(Vec3(soft.point(arm, p.i) - soft.point(torso, p.j)))));
    fastest = std::max(fastest, std::sqrt(2 * w.energy().kinetic / mass));
  }
  CHECK(widest < 0.02);
  CHECK(fastest < std::sqrt(2 * 9.81 * (start + 0.1) + 4));  // what the fall gives
}

TEST_CASE("drag that is strong for its points slows a swinging ball and feeds no swing", "[soft]") {
  WorldDesc space;
  space.gravity = Vec3(0, 0, 0), space.substeps = 1;
  World w(space, catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.12), Real(0.12), Real(0.12)), 4);
  d.solver = any_soft_solver();
  CAPTURE(d.solver);
  d.density = 2000, d.young = Real(2.4e4), d.damping = 0, d.velocity = Vec3(1, 0, 0);
  const ObjectId id = soft.add_soft(d);
  for (const double linear : {0.6, 0.6}) {  // N s/m of points of 28 g, in a substep of 17 ms
    Params options;
    options.set("linear", linear);
    ForceEntry on;
    on.all = true;
    w.add_force("drag", options, std::move(on), "", 0);
  }
  for (std::uint32_t i = 0; i < soft.info(id).points.size(); i += 3)
    soft.apply_impulse(id, i, vec3(Real(i % 2 ? 0.1 : -0.1), 0, 0));
  double last = 1e9;
  for (int k = 0; k < 60; ++k) {
    w.step();
    const double now = w.energy().kinetic + w.energy().elastic;
    CHECK(now <= last * 1.0001 + 1e-9);
    last = now;
  }
  CHECK(last < 1e-6);
}

TEST_CASE("a law that a solver does not have is an error that names those that do", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = one_tetrahedron();
  d.elasticity = "corotated";
  CHECK_THROWS_WITH(soft.add_soft(d),
                    Catch::Contains("elasticity: expected what xpbd has (neo_hookean), got corotated") &&
                        Catch::Contains("solvers that have it: implicit"));
  d.elasticity = "corotatd";
  CHECK_THROWS_WITH(soft.add_soft(d), Catch::Contains("known: neo_hookean, corotated, stvk"));
  CHECK(soft.soft_count() == 0);
}

TEST_CASE("implicit says where it did not reach its tolerance", "[soft]") {
  World w(WorldDesc{}, catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 3);
  d.solver = "implicit";
  d.pins = {0, 1, 2, 3};
  const ObjectId good = soft.add_soft(d);
  d.solver_options.set("iterations", 1.0);
  const ObjectId hurried = soft.add_soft(d);
  std::size_t said = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::warning) continue;
      CHECK(w.events().warning_code(e) == std::string("unconverged"));
      CHECK(e.a == hurried);
      CHECK_THAT(w.events().warning_message(e), Catch::Contains("implicit stopped after 1 steps of Newton"));
      ++said;
    }
  }
  CHECK(said == 1);  // once
  CHECK(soft.inverted(good) == 0);
}

TEST_CASE("what has no soft body has no pass of soft bodies", "[soft]") {
  World w(WorldDesc{}, catalog());
  BodyDesc box;
  box.shape = make_box(1, 1, 1);
  w.need<Rigid>().add_body(box);
  w.step();
  CHECK(w.find<Soft>() == nullptr);
  const ObjectId id = w.need<Soft>().add_soft(one_tetrahedron());
  w.step();
  w.need<Soft>().destroy_soft(id, "here");
  w.step();
  CHECK(w.need<Soft>().count() == 0);
}

}  // namespace feder::test
