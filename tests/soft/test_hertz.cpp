// A hard ball pressed into a block: F = 4/3 E/(1 - nu^2) sqrt(R) d^1.5 (Hertz 1882). The block is deep and wide against
// the contact, which asks for a graded mesh, fine where the ball is: small tetrahedra that carry all of the load.
#include <memory>

#include "soft_bodies.h"

namespace feder::test {
namespace {

constexpr double kYoung = 1e5, kPoisson = 0.3, kThickness = 0.004;
constexpr double kHertz = 4.0 / 3 * kYoung / (1 - kPoisson * kPoisson);  // of a ball of 1 m, N/m^1.5

// Cells per radius of the ball; half its fine part, half its width and its depth at least, m; growth of cells beyond.
struct Grading {
  int cells;
  double fine, width, growth;
};

// Places of points along an axis from 0, m.
std::vector<double> places(const Grading& g) {
  std::vector<double> x{0};
  const double cell = 1.0 / g.cells;
  for (int k = 1; x.back() < g.fine; ++k) x.push_back(k * cell);
  for (double step = cell * g.growth; x.back() < g.width; step *= g.growth) x.push_back(x.back() + step);
  return x;
}

// Cubes of five tetrahedra, which alternate; the ball comes from above (y) at the origin.
SoftDesc graded_block(const Grading& g) {
  const std::vector<double> half = places(g);
  std::vector<double> across, down(half.rbegin(), half.rend());
  for (double& y : down) y = -y;
  across.assign(down.begin(), down.end() - 1);
  across.insert(across.end(), half.begin(), half.end());
  const std::size_t n = across.size(), deep = down.size();
  SoftDesc d;
  for (const double x : across)
    for (const double y : down)
      for (const double z : across)
        d.points.push_back(vec3(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z)));
  constexpr unsigned kFive[2][5][4] = {{{0, 4, 2, 1}, {6, 4, 7, 2}, {5, 4, 1, 7}, {3, 1, 2, 7}, {1, 4, 2, 7}},
                                       {{1, 0, 5, 3}, {2, 0, 3, 6}, {4, 0, 6, 5}, {7, 3, 5, 6}, {0, 3, 6, 5}}};
  for (std::size_t i = 0; i + 1 < n; ++i)
    for (std::size_t j = 0; j + 1 < deep; ++j)
      for (std::size_t k = 0; k + 1 < n; ++k)
        for (const auto& t : kFive[(i + j + k) % 2])
          for (const unsigned c : t)
            d.tetrahedra.push_back(
                static_cast<std::uint32_t>(((i + (c >> 2)) * deep + j + (c >> 1 & 1u)) * n + k + (c & 1u)));
  for (std::uint32_t i = 0; i < d.points.size(); ++i)
    if (number(d.points[i][1]) < down.front() + 1e-6) d.pins.push_back(i);
  d.young = static_cast<Real>(kYoung), d.poisson = static_cast<Real>(kPoisson);
  d.thickness = static_cast<Real>(kThickness), d.friction = 0, d.damping = Real(0.1), d.self_collision = false;
  return d;
}

struct Indentation {
  std::unique_ptr<World> world;
  ObjectId block, ball;

  // The ball is light, so that the block lets it swing for no longer than half a second.
  Indentation(const Grading& g, const std::string& solver) {
    WorldDesc desc = weightless();
    desc.sleeping = false;
    world = std::make_unique<World>(desc, catalog());
    SoftDesc d = graded_block(g);
    d.solver = solver;
    block = world->need<Soft>().add_soft(d);
    BodyDesc b;
    b.shape = make_sphere(1), b.friction_static = b.friction_dynamic = 0, b.mass = 100;
    b.position = vec3(0, static_cast<Real>(1.001 + kThickness / 2), 0);
    ball = world->need<Rigid>().add_body(b);
  }

  void press(double force, int steps) {
    for (int k = 0; k < steps; ++k) {
      world->need<Rigid>().apply_force(ball, vec3(0, static_cast<Real>(-force), 0), nullptr);
      world->step();
    }
  }
  double depth() const { return 1 + kThickness / 2 - number(world->need<Rigid>().pose(ball).position[1]); }

  // Goes on where another one is, at rest: the ball is held there until contacts have found their forces.
  void take_over(const Indentation& from) {
    const Soft& as = from.world->need<Soft>();
    for (std::size_t i = 0; i < as.point_count(block); ++i)
      world->need<Soft>().set_point(block, i, as.point(from.block, i));
    Rigid& rigid = world->need<Rigid>();
    rigid.set_type(ball, BodyType::kinematic);
    rigid.set_pose(ball, from.world->need<Rigid>().pose(from.ball));
    rigid.set_velocity(ball, Vec3(0, 0, 0));
    for (int k = 0; k < 4; ++k) world->step();
    rigid.set_type(ball, BodyType::dynamic);
  }
};

}  // namespace

// Coarse: a cell is wider than the contact, so Hertz is 1.5 of it too soft; but all solvers have this one mesh.
TEST_CASE("a ball rests at one depth in a graded block, whatever the solver and its substeps", "[soft]") {
  const Grading coarse{6, 0.4, 3, 1.6};
  const double force = kHertz * std::pow(0.02, 1.5);
  Indentation at_rest(coarse, "vbd");
  at_rest.press(force, 120);
  const double depth = at_rest.depth();
  CHECK(depth > 0.01);
  const std::string solver = any_soft_solver();
  if (is_springs(solver)) return;  // another material
  CAPTURE(solver, depth);
  if (solver == "xpbd") {
    Indentation other(coarse, solver);
    other.press(force, 120);
    CHECK(other.depth() == Approx(depth).epsilon(0.03));
    return;
  }
  Indentation other(coarse, solver);
  other.take_over(at_rest);
  other.press(force, 20);
  CHECK(other.depth() == Approx(depth).epsilon(0.03));
}

TEST_CASE("a block resists a ball by Hertz's law, in its exponent and its constant", "[soft][late]") {
  const Grading fine{16, 0.35, 6, 1.6};
  const std::string solver = GENERATE(as<std::string>(), "vbd", "implicit");
  Indentation in(fine, solver);
  double first = 0;
  for (const double load : {1.0, 10.0}) {
    const double force = kHertz * std::pow(0.02, 1.5) * load;
    in.press(force, solver == "vbd" ? 180 : 70);
    const double depth = in.depth(), constant = force / (kHertz * std::pow(depth, 1.5));
    CAPTURE(solver, force, depth, constant);
    CHECK(std::fabs(number(in.world->need<Rigid>().velocity(in.ball)[1])) < 0.02);  // 1 % of the depth
    CHECK(constant == Approx(1).epsilon(0.15));
    if (first == 0) first = depth;
  }
  const double exponent = std::log(10) / std::log(in.depth() / first);
  CAPTURE(solver);
  CHECK(exponent == Approx(1.5).margin(0.1));
}

}  // namespace feder::test
