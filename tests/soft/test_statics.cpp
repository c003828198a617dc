// Soft bodies against beams: bent under their own weight, twisted, and swinging. Backward Euler in long steps goes to
// rest at once, so `implicit` finds it; the other solvers have to hang where it does.
#include "soft_bodies.h"

namespace feder::test {
namespace {

constexpr double kWeight = 9810, kSlenderness = 5;  // N/m^3; length of 1 m by the side

// Drop of the free end of a beam of 1 m and side 1/kSlenderness under its own weight, with shear and elongation
// (Reissner 1972, the equations of a plane beam), m: from the free end to the clamp, whose slope decides the angle of
// the free end. gamma: rho A g L^3/(E I).
double beam_drop(double gamma, double nu) {
  const double side = 1 / kSlenderness, area = side * side, weight = kWeight * area;  // N/m
  const double young = 12 * weight / (gamma * area * area), stretch = young * area;
  const double shear = young / (2 * (1 + nu)) * area * (10 * (1 + nu) / (12 + 11 * nu));  // Cowper 1966
  const double bend = weight / gamma;
  const auto shoot = [&](double angle, double& drop) {
    constexpr int kParts = 4000;
    const double h = 1.0 / kParts;
    double moment = 0;
    drop = 0;
    for (int i = 0; i < kParts; ++i) {
      const double hung = weight * (i + 0.5) * h, middle = angle - 0.5 * h * moment / bend;
      const double s = std::sin(middle), c = std::cos(middle);
      const double along = 1 + hung * s / stretch, across = hung * c / shear;
      drop += h * (along * s + across * c);
      angle -= h * (moment + 0.5 * h * hung * (along * c - across * s)) / bend;
      moment += h * hung * (along * c - across * s);
    }
    return angle;
  };
  double lo = 0, hi = 1.6, drop = 0;
  for (int k = 0; k < 60; ++k) (shoot(0.5 * (lo + hi), drop) < 0 ? lo : hi) = 0.5 * (lo + hi);
  return drop;
}

// The same of a mesh of so many cells across.
struct Beam {
  std::unique_ptr<World> world;
  ObjectId id;
};
Beam clamped_beam(WorldDesc desc, std::uint32_t across, double gamma, double nu, const std::string& solver,
                  int substeps, double damping = 0.05) {
  desc.sleeping = false;
  Beam b{std::make_unique<World>(desc, catalog()), {}};
  Soft& soft = b.world->need<Soft>();
  const Real side = static_cast<Real>(1 / kSlenderness);
  SoftDesc d = soft_box(vec3(1, side, side), static_cast<std::uint32_t>(kSlenderness) * across);
  d.young = static_cast<Real>(12 * kWeight / (gamma * number(side) * number(side)));
  d.poisson = static_cast<Real>(nu), d.damping = static_cast<Real>(damping), d.solver = solver, d.substeps = substeps,
  d.self_collision = false;
  b.id = soft.add_soft(d);
  for (std::size_t i = 0; i < soft.point_count(b.id); ++i)
    if (soft.rest_point(b.id, i)[0] < Real(-0.4999)) soft.pin(b.id, i);
  return b;
}

double drop_of(const Beam& b) {
  const Soft& soft = b.world->need<Soft>();
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < soft.point_count(b.id); ++i)
    if (soft.rest_point(b.id, i)[0] > Real(0.4999)) sum -= number(soft.point(b.id, i)[1]), count += 1;
  return sum / count;
}

// In steps of half a second, until it is at rest.
WorldDesc long_steps() {
  WorldDesc desc;
  desc.dt = 0.5, desc.substeps = 1;
  return desc;
}

double drop_at_rest(std::uint32_t across, double gamma, double nu) {
  const Beam b = clamped_beam(long_steps(), across, gamma, nu, "implicit", 1);
  for (int k = 0; k < 20; ++k) {
    b.world->step();
    CHECK(count_warnings(*b.world, "unconverged") == 0);
  }
  CHECK(b.world->energy().kinetic < 1e-9);
  return drop_of(b);
}

// Of a clamped beam with shear and rotary inertia (Timoshenko 1921), rad/s: the frequency at which a motion that begins
// at the clamp can end free. Of 1 m, side 1/kSlenderness, nu 0.
double clamped_frequency(double young, double density) {
  const double side = 1 / kSlenderness, area = side * side, moment = area * area / 12;
  const double bend = young * moment, shear = young / 2 * area * 5 / 6;
  const auto end = [&](double w2) {  // determinant of moment and shear force at the free end
    constexpr int kParts = 2000;
    const double h = 1.0 / kParts;
    double last[2][2];
    for (int start = 0; start < 2; ++start) {
      double s[4] = {0, 0, start == 0 ? 1.0 : 0.0, start == 1 ? 1.0 : 0.0};  // place, angle, moment, shear force
      const auto slope = [&](const double(&y)[4], double(&d)[4]) {
        d[0] = y[1] + y[3] / shear, d[1] = y[2] / bend;
        d[2] = -y[3] - density * moment * w2 * y[1], d[3] = -density * area * w2 * y[0];
      };
      for (int k = 0; k < kParts; ++k) {
        double d[4], middle[4];
        slope(s, d);
        for (int n = 0; n < 4; ++n) middle[n] = s[n] + 0.5 * h * d[n];
        slope(middle, d);
        for (int n = 0; n < 4; ++n) s[n] += h * d[n];
      }
      last[start][0] = s[2], last[start][1] = s[3];
    }
    return last[0][0] * last[1][1] - last[0][1] * last[1][0];
  };
  const double thin = 3.51602 * std::sqrt(bend / (density * area));
  double lo = 0.5 * thin, hi = 1.1 * thin;
  const bool rises = end(lo * lo) < 0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (lo + hi);
    ((end(middle * middle) < 0) == rises ? lo : hi) = middle;
  }
  return lo;
}

}  // namespace

TEST_CASE("a clamped beam hangs by its weight as beams do, to second order in the cells", "[soft][heavy]") {
  const double gamma = GENERATE(0.1, 1.0, 10.0);
  const double coarse = drop_at_rest(2, gamma, 0), middle = drop_at_rest(4, gamma, 0), fine = drop_at_rest(8, gamma, 0);
  CAPTURE(gamma, coarse, middle, fine, beam_drop(gamma, 0));
  CHECK(std::fabs(fine / beam_drop(gamma, 0) - 1) < 0.05);
  CHECK(std::log2((fine - coarse) / (fine - middle)) >= 1.5);
}

TEST_CASE("a beam hangs where backward Euler has it, whatever the solver", "[soft]") {
  const double at_rest = drop_at_rest(2, 1, 0.3);  // two cells across are too stiff by half: it is this mesh's own rest
  CHECK(at_rest > 0.5 * beam_drop(1, 0.3));
  const std::string solver = any_soft_solver();
  const Beam b = clamped_beam(WorldDesc{}, 2, 1, 0.3, solver, 0);
  CAPTURE(solver, at_rest);
  for (int k = 0; k < 300; ++k) b.world->step();
  if (is_springs(solver)) {  // of few cells springs bend more easily than tetrahedra do, as less than the beam
    CHECK(drop_of(b) > at_rest);
    CHECK(drop_of(b) < beam_drop(1, 0.3));
    return;
  }
  CHECK(drop_of(b) == Approx(at_rest).epsilon(0.005));
}

// T = 0.1406 a^4 G theta/L (Saint-Venant). The torque is that whose work is the energy; the twist is that of the half
// between the clamps, which keep their ends flat.
TEST_CASE("a square bar resists twisting as Saint-Venant says", "[soft][heavy]") {
  const double side = 0.1, length = 0.3, theta = 0.1, shear = 1e6 / 2.6;
  WorldDesc desc = long_steps();
  desc.gravity = Vec3(0, 0, 0);
  World w(desc, catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.1), Real(0.1)), 36);
  d.young = Real(1e6), d.poisson = Real(0.3), d.solver = "implicit", d.substeps = 1, d.self_collision = false;
  const ObjectId id = soft.add_soft(d);
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const Vec3 r = soft.rest_point(id, i);
    const double turn = theta * (number(r[0]) / length + 0.5), y = number(r[1]), z = number(r[2]);
    if (std::fabs(number(r[0])) > 0.4999 * length) soft.pin(id, i);
    soft.set_point(id, i,
                   vec3(r[0], static_cast<Real>(y * std::cos(turn) - z * std::sin(turn)),
                        static_cast<Real>(y * std::sin(turn) + z * std::cos(turn))));
  }
  for (int k = 0; k < 6; ++k) w.step();
  CHECK(w.energy().kinetic < 1e-9);
  double turned[2] = {0, 0}, square[2] = {0, 0};
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const Vec3 r = soft.rest_point(id, i), x = soft.point(id, i);
    if (std::fabs(std::fabs(number(r[0])) - length / 4) > 1e-4) continue;
    const int end = r[0] > 0;
    turned[end] += number(r[1] * x[2] - r[2] * x[1]), square[end] += number(r[1] * r[1] + r[2] * r[2]);
  }
  const double rate = (turned[1] / square[1] - turned[0] / square[0]) / (length / 2);
  const double torque = 2 * w.energy().elastic / theta;
  CHECK(rate * length / theta == Approx(1).epsilon(0.05));
  CHECK(torque / (0.1406 * side * side * side * side * shear * rate) == Approx(1).epsilon(0.05));
}

TEST_CASE("a clamped beam swings at Timoshenko's frequency", "[soft][heavy]") {
  WorldDesc desc = weightless();
  const double gamma = 12 * kWeight / (1e6 / (kSlenderness * kSlenderness)), wanted = clamped_frequency(1e6, 1000);
  const Beam b = clamped_beam(desc, 8, gamma, 0, "xpbd", 0, 0);  // of 1 MPa
  Soft& soft = b.world->need<Soft>();
  for (std::size_t i = 0; i < soft.point_count(b.id); ++i) {
    const double z = 1.8751 * (number(soft.rest_point(b.id, i)[0]) + 0.5);
    const double shape = std::cosh(z) - std::cos(z) - 0.73410 * (std::sinh(z) - std::sin(z));
    soft.set_velocity(b.id, i, vec3(0, static_cast<Real>(0.02 * shape), 0));
  }
  double last = 0, first_time = 0, last_time = 0;
  int crossings = 0;
  for (int k = 1; k <= 140 && crossings < 4; ++k) {
    b.world->step();
    const double now = drop_of(b);
    if (last * now < 0) {
      last_time = (k - 1 + last / (last - now)) / 60;
      if (crossings++ == 0) first_time = last_time;
    }
    last = now;
  }
  REQUIRE(crossings == 4);
  CHECK(3.14159265358979 * 3 / (last_time - first_time) == Approx(wanted).epsilon(0.03));
}

}  // namespace feder::test
