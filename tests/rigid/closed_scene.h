// Scenes for the closed-form tests: a world with rigid bodies and collision detection, and functions that fill it.
#pragma once
#include <memory>

#include "base/rng.h"
#include "feder/query.h"
#include "feder/rigid.h"
#include "feder/world.h"
#include "rigid/solver.h"
#include "rigid/tolerances.h"
#include "state/bodies.h"
#include "support/catch.h"

namespace feder {

inline constexpr double kG = 9.81;

// The solver a test runs with: GENERATE(range(0, solver_count())), then solver_name(i).
inline int solver_count() { return static_cast<int>(rigid_solvers().size()); }
inline const char* solver_name(int i) { return rigid_solvers()[static_cast<std::size_t>(i)].name; }

struct ClosedScene {
  WorldDesc desc;
  Executor executor;
  std::unique_ptr<World> made;

  explicit ClosedScene(const char* solver, double dt = 1.0 / 60, int substeps = 4, int dimension = 3) {
    desc.dt = dt;
    desc.substeps = substeps;
    desc.dimension = dimension;
    desc.sleeping = false;
    desc.systems["rigid"].set("solver", std::string(solver));
  }
  World& world() {
    static const SystemDescriptor* const catalog[] = {&Collide::descriptor(), &Rigid::descriptor()};
    if (!made) made = std::make_unique<World>(desc, catalog, executor);
    return *made;
  }
  Rigid& rigid() { return world().need<Rigid>(); }
  double h() const { return desc.dt / desc.substeps; }
  // Steps until at least `seconds` have passed.
  void run(double seconds) {
    const int steps = static_cast<int>(std::ceil(seconds / desc.dt - 1e-9));
    for (int i = 0; i < steps; ++i) world().step();
  }

  Vec3 position(ObjectId b) { return rigid().bodies().position[rigid().index(b)]; }
  Vec3 velocity(ObjectId b) { return rigid().bodies().velocity[rigid().index(b)]; }
  Vec3 spin(ObjectId b) { return rigid().bodies().angular_velocity[rigid().index(b)]; }
  Quat rotation(ObjectId b) { return rigid().bodies().rotation[rigid().index(b)]; }
};

inline BodyDesc body_of(ShapePtr shape, const Vec3& position, Real mass = 1, Real friction = 0) {
  BodyDesc d;
  d.shape = std::move(shape);
  d.position = position;
  d.mass = mass;
  d.friction_static = d.friction_dynamic = friction;
  return d;
}

// Solid below the plane n.x = d.
inline BodyDesc ground_of(Real friction, const Vec3& normal = Vec3(0, 1, 0), Real distance = 0) {
  BodyDesc d;
  d.type = BodyType::fixed;
  d.shape = make_plane(normal, distance);
  d.friction_static = d.friction_dynamic = friction;
  return d;
}

// Three draws one after another: the order of function arguments is the compiler's choice.
inline Vec3 draw(Rng& rng, Real size) {
  Vec3 v;
  for (int k = 0; k < 3; ++k) v[k] = rng.uniform(-size, size);
  return v;
}

// Complete elliptic integral K(m) by the arithmetic-geometric mean.
inline double elliptic_k(double m) {
  double a = 1, b = std::sqrt(1 - m);
  for (int i = 0; i < 40; ++i) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return 3.14159265358979323846 / (2 * a);
}

}  // namespace feder
