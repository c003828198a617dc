// A free sheet in a state that nobody should make: it stays finite, gets no energy from nothing, and comes back.
#pragma once
#include "base/rng.h"
#include "cloth/sheets.h"

namespace feder::test {

struct Extreme {
  enum Kind { as_made, one_far, random, one_spot, one_line };
  double stretch = 1, bend = 0;
  Kind kind = as_made;
  bool self = false;
  const char* solver = "xpbd";
  std::uint32_t side = 9;  // vertices
  int steps = 240;
};

inline void run_extreme(const Extreme& x) {
  CAPTURE(x.solver, x.stretch, x.bend, int(x.kind), x.self);
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(x.side, x.side, 1, 1);
  d.solver = x.solver;
  d.stretch = static_cast<Real>(x.stretch);
  d.bend = static_cast<Real>(x.bend);
  d.damping = Real(0.01);
  d.self_collision = x.self;
  const ObjectId id = cloth.add_cloth(d);
  const std::size_t count = cloth.vertex_count(id), middle = count / 2;
  const Vec3 spot = cloth.point(id, middle);
  if (x.kind == Extreme::one_far) cloth.set_point(id, middle, Vec3(100, 30, -20));
  Rng rng(7);
  for (std::size_t i = 0; i < count; ++i) {
    const double a = rng.unit(), b = rng.unit(), c = rng.unit();
    if (x.kind == Extreme::random) cloth.set_point(id, i, Vec3(Real(a), Real(b), Real(c)));
    if (x.kind == Extreme::one_spot) cloth.set_point(id, i, spot);
    if (x.kind == Extreme::one_line) cloth.set_point(id, i, Vec3(cloth.point(id, i)[0], 0, 0));
  }
  const Energy start = w.energy();
  for (int k = 0; k < x.steps; ++k) {
    w.step();
    REQUIRE(w.is_finite());
  }
  // what moves and has fallen got its energy from somewhere
  const Energy end = w.energy();
  CHECK(end.kinetic + end.potential < start.kinetic + start.potential + start.elastic + 0.02);
  if (x.self && x.kind != Extreme::as_made) return;  // what is tangled cannot come back through itself
  if (x.kind == Extreme::one_spot || x.kind == Extreme::one_line) return;  // nothing says which way
  // it came back: no longer than a few times its size
  CHECK(static_cast<double>(cloth.max_strain(id)) < (x.stretch < 10 ? 60.0 : 2.0));
}

}  // namespace feder::test
