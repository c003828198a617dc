// The collapse of a square column: its first moments against potential theory, its front and height against the films
// of Martin & Moyce, Phil. Trans. R. Soc. A 244 (1952), column a x a, T = t sqrt(g/a), Z = front / a, H = height / a.
//
// The films and an instant release do not share their zero of time. A column that is let go at once starts with the
// accelerations of potential theory (first test, no shift): the top sinks with g/2 and the foot of the face, where the
// acceleration has a logarithmic pole, is at Z = 1.38 at T = 0.62, when the films show 1.22. Both solvers, at any
// resolution, and volume-of-fluid codes too (interFoam: 10 % ahead on average) run ahead of the tables by the same
// time, and so does the height of the column, which neither the floor nor the way of reading a front can delay. The
// diaphragm of the experiment took time: 0.1 to 0.2 of T; comparisons of other codes use 0.175 of t sqrt(2g/a)
// (Lethe's dam-break example), which is taken here, once for all solvers and resolutions.
// Two copies of the table are in use that differ by up to 0.06 of T; the front must suit both. Ahead of them, in %:
//            first copy, as it is / shifted    second copy     height, behind
//   dfsph    14 to 17 / 4 to 9                10 to 17 / 2 to 6    4 to 7 / 2
//   pbf      11 to 14 / 0 to 6                 8 to 13 / 0 to 4    3 to 6 / -1 to 1
//   wcsph    11 to 14 / 1 to 6                 8 to 13 / 0 to 4    3 to 7 / -1 to 2
// Finer, pbf and wcsph come to where dfsph is, 7 to 8 (scenes/study/dam_break.lua, 60 and 120 particles a side): they
// start late, by the pressure waves that they wait for.
#include <cmath>
#include <fstream>

#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

constexpr double kG = 9.81;

// Of the library that scenes and studies use, so that it stands in one place.
double library_number(const std::string& name) {
  std::ifstream file(FEDER_SOURCE_DIR "/scripts/feder/fluid.lua");
  for (std::string line; std::getline(file, line);)
    if (line.compare(0, name.size(), name) == 0) return std::stod(line.substr(name.size()));
  return NAN;
}
const double kDelay = library_number("fluid.diaphragm_delay = ");

struct Column {
  explicit Column(const std::string& solver) : world(fluid_world(2), fluid_catalog()) {
    add_plane(world, vec3(0, 1, 0), 0), add_plane(world, vec3(1, 0, 0), 0);
    desc.solver = solver, desc.spacing = Real(1) / 30;
    desc.viscosity = Real(0.073);  // the Reynolds number of their 5.7 cm column of water; walls do not slip
    water = add_water(world, desc, vec3(1, 1, 0));
  }
  double front() {
    double x = 0;
    for (const Vec3& p : places(world, water))
      if (p[1] < 2 * desc.spacing) x = std::max<double>(x, p[0] + desc.spacing / 2);
    return x;
  }
  double height() {
    Real y = 0;
    return world.query<Fluid>()->height_at(water, desc.spacing / 2, 0, y) ? y : 0;
  }
  World world;
  FluidDesc desc;
  ObjectId water;
};

// Acceleration over g of a unit column between a wall at x = 0 and air at x = 1 at the moment it is let go: from
// p/(rho g) = 1 - y - sum 2/l^2 cos(l y) cosh(l x)/cosh(l), l = (k + 1/2) pi, which is harmonic, 0 where there is air,
// and does not push through wall and floor.
void released(double x, double y, double& ax, double& ay) {
  ax = ay = 0;
  for (int k = 0; k < 60; ++k) {
    const double l = (k + 0.5) * 3.14159265358979323846, scale = 2 / l / (1 + std::exp(-2 * l));
    const double near = std::exp(l * (x - 1)), far = std::exp(-l * (x + 1));
    ax += scale * std::cos(l * y) * (near - far);
    ay -= scale * std::sin(l * y) * (near + far);
  }
}

}  // namespace

TEST_CASE("scenes, studies and tests shift the films of the dam break by one number", "[fluid][analytic]") {
  REQUIRE(std::isfinite(kDelay));
  CHECK(std::fabs(kDelay - 0.175 / std::sqrt(2.0)) < 1e-3);
}

TEST_CASE("a column that is let go starts as potential theory says", "[fluid][closed]") {
  // before the column has changed its shape: by then pressure waves have crossed it, and the particles have moved by
  // 0.02 and, of dfsph, which has no waves to wait for, 0.005 on average
  const std::string solver = any_fluid_solver();
  const bool at_once = solver == "dfsph";
  CAPTURE(solver);
  Column c(solver);
  const std::vector<Vec3> before = places(c.world, c.water);
  run(c.world, at_once ? 0.05 : 0.1);  // T = 0.16, 0.31
  const std::vector<Vec3> after = places(c.world, c.water);
  const double t = c.world.time();
  // n steps of velocities first carry it (1 + 1/n) as far as half the acceleration would
  const double t2 = t * t * (at_once ? 1 + 1 / (60 * 4 * t) : 1);
  double error = 0, whole = 0, face = 0, face_expected = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    double ax = 0, ay = 0;
    released(before[i][0], before[i][1], ax, ay);
    const double sx = kG * ax * t2 / 2, sy = kG * ay * t2 / 2;
    const double x = after[i][0] - before[i][0], y = after[i][1] - before[i][1];
    error += (x - sx) * (x - sx) + (y - sy) * (y - sy), whole += sx * sx + sy * sy;
    if (before[i][0] > 1 - c.desc.spacing) face += x, face_expected += sx;
  }
  CHECK(std::sqrt(error / whole) < (at_once ? 0.1 : 0.15));
  CHECK(face == Approx(face_expected).epsilon(at_once ? 0.1 : 0.06));
}

TEST_CASE("the front of a dam break runs as Martin and Moyce measured", "[fluid][closed]") {
  const std::string solver = any_fluid_solver();
  const bool at_once = solver == "dfsph";  // ahead by what the others start late
  CAPTURE(solver);
  Column c(solver);
  const double fronts[][2] = {{0.62, 1.22},
                              {0.80, 1.44},
                              {1.02, 1.67},
                              {1.19, 1.89},
                              {1.34, 2.11},
                              {1.50, 2.33},
                              {1.66, 2.56},
                              {1.81, 2.78},
                              {1.97, 3.00},
                              // the other copy
                              {0.614, 1.218},
                              {0.796, 1.437},
                              {0.970, 1.671},
                              {1.137, 1.893},
                              {1.292, 2.109},
                              {1.442, 2.334},
                              {1.621, 2.564},
                              {1.757, 2.787},
                              {1.929, 3.001}};
  const double heights[][2] = {{0.80, 0.89}, {1.29, 0.78}, {1.74, 0.67}};
  std::vector<double> t{0}, z{1}, h{1};
  for (int k = 0; k < static_cast<int>(40 * kShare) + 1; ++k) {
    c.world.step();
    t.push_back(c.world.time() * std::sqrt(kG)), z.push_back(c.front()), h.push_back(c.height());
    CHECK(z.back() < 1 + 2 * t.back() + c.desc.spacing);  // Ritter's front is never beaten
  }
  if (!kFull) return;
  const auto at = [&](const std::vector<double>& f, double when) {
    std::size_t k = 1;
    while (t[k] < when) ++k;
    return f[k - 1] + (f[k] - f[k - 1]) * (when - t[k - 1]) / (t[k] - t[k - 1]);
  };
  for (const auto& m : fronts) {
    CAPTURE(m[0], at(z, m[0]));
    CHECK(at(z, m[0] - kDelay) == Approx(m[1]).epsilon(at_once ? 0.09 : 0.08));
    CHECK(at(z, m[0]) < (at_once ? 1.18 : 1.15) * m[1]);  // and unshifted no further ahead than said above
  }
  for (const auto& m : heights) CHECK(at(h, m[0] - kDelay) == Approx(m[1]).epsilon(0.03));
}
