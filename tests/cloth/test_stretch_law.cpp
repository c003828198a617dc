// What one sweep per solver substep leaves of strain: the law that chooses the number of solver substeps.
#include <cmath>
#include <cstdio>

#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("a hanging sheet keeps the strain of the law 2 g n^2 h^2/L, and g n^2 h^2/(2 L) as a whole", "[cloth]") {
  const std::uint32_t rows = GENERATE(20u, 50u, 100u);
  const int small = GENERATE(2, 5, 20);
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(5, rows + 1, Real(4.0 / rows), 1);
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
  d.stretch = Real(1e7);
  d.shear = 0;
  d.bend = 0;
  d.damping = Real(0.01);
  d.self_collision = false;
  d.pin_names = {"top"};
  d.substeps = small;
  d.max_strain = kInfinity;  // what the solver substeps leave by themselves
  const ObjectId id = cloth.add_cloth(d);
  relax(w, id, 10);
  const double h = wd.dt / wd.substeps / small, law = 9.81 * rows * rows * h * h;
  const double whole = component(cloth.point(id, 2) - cloth.point(id, 5 * rows + 2), 1) - 1;
  const double worst = static_cast<double>(cloth.max_strain(id));
  std::printf("hanging n %u, %d solver substeps: max %.4f (law %.4f), whole %.4f (law %.4f)\n", rows,
              small * wd.substeps, worst, 2 * law, whole, law / 2);
  if (law > 0.3) return;  // beyond its range
  CAPTURE(rows, small, law, whole, worst);
  CHECK(whole == Approx(law / 2).epsilon(0.1));
  CHECK(worst < 2.2 * law);
}

TEST_CASE("a hanging sheet takes the strain of its material: stretch is newtons per metre of width", "[cloth]") {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  const char* solver = cloth_solvers()[static_cast<std::size_t>(row)].name;
  CAPTURE(solver);
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(11, 11, 1, 1);
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
  d.solver = solver;
  d.stretch = 20;
  d.max_strain = kInfinity;
  d.bend = 0;
  d.damping = Real(0.02);
  d.self_collision = false;
  d.pin_names = {"top"};
  d.stretch_error = Real(0.0005);
  const ObjectId id = cloth.add_cloth(d);
  relax(w, id, 8);
  const double whole = component(cloth.point(id, 5) - cloth.point(id, 10 * 11 + 5), 1) - 1;
  const double expected = 0.2 * 9.81 / (2 * 20);
  CAPTURE(whole, expected, cloth.substeps(id));
  CHECK(whole == Approx(expected).epsilon(0.1));
}
