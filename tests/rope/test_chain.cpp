// The step of a chain alone, with random contacts: Newton's method ends, forces and motion balance, and what contacts
// exert obeys Coulomb's law.
#include "base/rng.h"
#include "rope/chain.h"
#include "ropes.h"

namespace feder::test {
namespace {

constexpr double kStep = 1.0 / 240, kLength = 0.05, kMass = 0.0157;

// A chain thrown on the ground, over a step whose edge has a slanted normal.
struct Thrown {
  explicit Thrown(std::uint64_t seed) : rng(seed) {
    const auto among = [&](double a, double b) { return a + (b - a) * rng.unit(); };
    const auto n = static_cast<std::uint32_t>(2 + 30 * rng.unit());
    step.h = kStep, step.count = n, step.stretch = std::pow(10, among(2, 5));
    step.bend = seed % 3 == 0 ? std::pow(10, among(-4, 0)) : 0, step.damping = 0.002;
    chain.resize(n);
    lengths.assign(n - 1, static_cast<Real>(kLength)), masses.assign(n, kMass);
    step.rest_length = lengths.data(), step.mass = masses.data();
    if (seed % 4 == 1) masses[0] = double(kInfinity);
    friction = among(0, 1);
    Double3 x{0, 0.01, 0}, along{1, 0, 0}, v{among(-2, 2), among(-4, 0), among(-2, 2)};
    for (std::uint32_t i = 0; i < n; ++i) {
      chain.start[i] = x;
      const double turn = step.bend > 0 ? 0.4 : 3;  // stiff ones are not folded
      const Double3 way{among(-1, 1), among(-0.3, 0.3), among(-1, 1)}, d = along + turn * way;
      along = (1 / length(d)) * d;
      x = x + (kLength * among(0.95, 1.02) / length(d)) * d;
      x.y = std::fmax(x.y, 0.0);
      velocity.push_back(v + Double3{among(-1, 1), among(-1, 1), among(-1, 1)});
    }
    if (!(masses[0] < double(kInfinity))) velocity[0] = {0, 0, 0};
    forces.assign(n, {0, 0, 0});
  }

  // A solver substep; contacts are kept by point.
  void advance() {
    contacts.clear();
    for (std::uint32_t i = 0; i < step.count; ++i) {
      const bool held = !(masses[i] < double(kInfinity));
      chain.guess[i] = chain.start[i] + kStep * velocity[i];
      chain.target[i] = chain.guess[i] + (held ? 0 : kStep * kStep) * Double3{0, -9.81, 0};
      ChainContact c;
      c.first = i;
      const bool slanted = i % 7 == 3;
      c.normal = slanted ? Double3{0.6, 0.8, 0} : Double3{0, 1, 0};
      c.gap = c.start_gap = slanted ? dot(c.normal, chain.start[i]) + 0.1 : chain.start[i].y;
      c.friction = friction, c.force = forces[i], c.row = i;
      if (c.gap < 0.05) contacts.push_back(c);
    }
    before.assign(chain.start.begin(), chain.start.end());
    end = &chain.solve(step, contacts, Array<ChainLoad>{&arena});
    old_forces = forces;
    forces.assign(step.count, {0, 0, 0});
    for (const ChainContact& c : contacts) forces[c.first] = c.force;
    for (std::uint32_t i = 0; i < step.count; ++i) velocity[i] = (1 / kStep) * ((*end)[i] - before[i]);
  }
  void go_on() {
    for (std::uint32_t i = 0; i < step.count; ++i) chain.start[i] = (*end)[i];
  }

  Rng rng;
  Arena arena{"test"};
  Chain chain{arena};
  ChainStep step;
  double friction = 0;
  std::vector<Real> lengths;
  std::vector<double> masses;
  std::vector<Double3> velocity, forces, old_forces, before;
  Array<ChainContact> contacts{&arena};
  const Array<Double3>* end = nullptr;
};

}  // namespace

TEST_CASE("the step of a chain with random contacts ends in balance, with Coulomb's law", "[rope][chain]") {
  int solves = 0, unsolved = 0, iterations = 0, pressing = 0, outside = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Thrown t(seed);
    for (int k = 0; k < 60; ++k, t.go_on()) {
      t.advance();
      CAPTURE(seed, k, t.step.count, t.step.bend, t.friction, t.chain.iterations, t.chain.missed);
      ++solves, iterations += t.chain.iterations;
      REQUIRE(std::isfinite(t.chain.missed));
      if (t.chain.missed > 1e-6 * kLength) {
        ++unsolved;
        continue;
      }
      // momentum
      Double3 lacks{0, 0, 0};
      double scale = 0;
      const bool held = !(t.masses[0] < double(kInfinity));
      for (std::uint32_t i = 0; i < t.step.count && !held; ++i)
        lacks = lacks + (kMass / (kStep * kStep)) * ((*t.end)[i] - t.chain.target[i]);
      for (const ChainContact& c : t.contacts) {
        if (!held) lacks = lacks - c.force;
        scale += length(c.force);
        const double normal = dot(c.normal, c.force);
        const Double3 across = c.force - normal * c.normal, moved = (*t.end)[c.first] - t.before[c.first];
        const Double3 slide = moved - dot(c.normal, moved) * c.normal;
        REQUIRE(normal >= -1e-9);
        REQUIRE(normal == Approx(c.pressed).margin(1e-9));
        pressing += normal > 0;
        outside += length(across) > t.friction * normal * 1.002 + 1e-6;
        // friction acts against a slide that is long beside what the force of before may give way, by a hundredth of
        // what inertia does
        if (length(slide) > 0.01 * kStep * kStep / kMass * length(t.old_forces[c.first]))
          REQUIRE(dot(across, slide) <= 0);
        if (normal == 0 && length(across) == 0) REQUIRE(c.gap + dot(c.normal, moved) > -1e-9 - std::fmax(-c.gap, 0.0));
      }
      const double tolerance = 1e-6 * kLength * kMass / (kStep * kStep) * t.step.count;  // of the iterations
      if (!held) REQUIRE(length(lacks) < 1e-6 * scale + 10 * tolerance);
    }
  }
  CAPTURE(solves, unsolved, iterations, pressing, outside);
  CHECK(unsolved <= solves / 100);
  CHECK(outside <= pressing / 200);
  CHECK(iterations < 8 * solves);
}

// What took as many iterations as there may be, in every solver substep: contacts that rest between sticking and
// slipping, with bending.
TEST_CASE("a heap of stiff rope on the ground is solved in few steps of Newton's method", "[rope]") {
  World w(WorldDesc{}, catalog());
  BodyDesc ground;
  ground.type = BodyType::fixed;
  ground.shape = make_plane(Vec3(0, 1, 0), 0);
  w.need<Rigid>().add_body(ground);
  Rope& rope = w.need<Rope>();
  RopeDesc d;
  for (int i = 0; i <= 60; ++i) {
    const double k = i;
    d.points.push_back(narrow({0.02 * std::sin(1.3 * k), 0.1 + 0.05 * k, 0.02 * std::cos(0.7 * k)}));
  }
  d.bend = Real(1e-3), d.self_collision = false;
  const ObjectId id = rope.add_rope(d);
  const auto residual = [&](const char* name) {
    for (const Residual& r : w.residuals())
      if (std::string(r.name) == name) return r.value;
    return -1.0;
  };
  for (int k = 0; k < 120; ++k) w.step();
  REQUIRE_FALSE(rope.asleep(id));
  double solves = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    solves += residual("rope.solves") / (4 * residual("rope.substeps"));
    CHECK(residual("rope.missed") < 1e-7);
  }
  CHECK(solves / 60 < 4);
}

}  // namespace feder::test
