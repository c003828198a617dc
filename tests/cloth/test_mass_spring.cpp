// What springs across hinges cannot do, and what hinges can: the drop of a clamped strip per load, for lighter and
// lighter loads. It tends to a constant for a material with bending stiffness, and grows without bound for springs.
#include <cmath>
#include <cstdio>

#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

double drop_per_load(const char* solver, double load) {
  WorldDesc wd;
  wd.sleeping = false;
  wd.gravity = Vec3(0, static_cast<Real>(-9.81 * load), 0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(11, 2, 1, Real(0.1));
  d.area_density = 1;
  d.stretch = 3000;
  d.bend = 2;
  d.damping = Real(0.03);
  d.self_collision = false;
  d.solver = solver;
  if (d.solver == "mass_spring") d.solver_options.set("integrator", std::string("velocity_verlet"));
  d.pin_names = {"left"};
  d.pins = {1, 12};  // the second column too: springs have nothing to lean on behind the first
  const ObjectId id = cloth.add_cloth(d);
  relax(w, id, 20, 1e-3 * load);
  return -component(cloth.point(id, 10), 1) / load;
}

}  // namespace

TEST_CASE("bend springs have no stiffness at a flat rest state; hinges have", "[cloth]") {
  double hinge[3], spring[3];
  const double load[3] = {1, 0.1, 0.01};
  for (int k = 0; k < 3; ++k) {
    hinge[k] = drop_per_load("xpbd", load[k]);
    spring[k] = drop_per_load("mass_spring", load[k]);
    std::printf("strip of 10 segments, load %g: drop/load %.4f with hinges, %.4f with springs\n", load[k], hinge[k],
                spring[k]);
  }
  CHECK(hinge[2] < 1.3 * hinge[1]);
  CHECK(spring[1] > 1.8 * spring[0]);
  CHECK(spring[2] > 2.5 * spring[1]);
}

TEST_CASE("a default mass_spring sheet of any stiffness stays finite and keeps its shape when a vertex is thrown",
          "[cloth]") {
  const double stiffness = GENERATE(7e4, 1e6, 1e8);
  const int substeps = GENERATE(1, 4);
  WorldDesc wd;
  wd.substeps = substeps;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(6, 3, Real(0.6), Real(0.3));
  d.solver = "mass_spring";
  d.stretch = static_cast<Real>(stiffness), d.shear = 3000;
  d.pin_names = {"left"};
  const ObjectId id = cloth.add_cloth(d);
  int warned = 0;
  double most = 0;
  for (int k = 0; k < 60; ++k) {
    if (k == 5) {
      cloth.set_point(id, 17, cloth.point(id, 17) + Vec3(Real(0.1), Real(0.1), 0));
      cloth.set_velocity(id, 11, Vec3(0, 5, 0));
    }
    w.step();
    for (const Event& e : w.events().list()) warned += e.kind == EventKind::warning;
    most = k > 10 ? std::max(most, w.energy().kinetic) : 0;
  }
  CAPTURE(stiffness, substeps, cloth.substeps(id), most);
  CHECK(w.is_finite());
  CHECK(warned <= 1);
  CHECK(cloth.max_strain(id) < 0.05);
  CHECK(most < 1);  // 0.036 kg: no more than 7.5 m/s on the mean
}
