// Slender bodies on joints, at the default step and around it: one rod against the closed form, chains by their energy.
// Thin boxes have moments of inertia in the ratio of 2 (thickness/length)^2.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

constexpr double kTurn = 6.28318530717958647692;

struct RodChain {
  ClosedScene s;
  std::vector<ObjectId> rods;
  double mass = 1;

  // Rods in a row along x, each joined to the one before, the first to the world; all rotate about the vertical axis
  // through the first joint (rad/s).
  RodChain(const char* solver, int count, double thick, const char* type, double dt, int substeps, double turn = 0,
           double friction = 0)
      : s(solver, dt, substeps) {
    ObjectId above;
    for (int k = 0; k < count; ++k) {
      BodyDesc d =
          body_of(make_box(1, Real(thick), Real(thick)), Vec3(Real(k + 0.5), 0, 0), Real(mass), Real(friction));
      d.velocity = Vec3(0, 0, Real(-turn * (k + 0.5)));
      d.angular_velocity = Vec3(0, Real(turn), 0);
      rods.push_back(s.rigid().add_body(d));
      JointDesc j;
      j.type = type;
      j.a = above, j.b = rods.back();
      j.anchor_a = Vec3(Real(k), 0, 0);
      j.axis = Vec3(0, 0, 1);
      s.rigid().add_joint(j);
      above = rods.back();
    }
  }
  double energy() {
    const Energy e = s.world().energy();
    return e.kinetic + e.potential;
  }
  // What is set free from the start to hanging straight.
  double drop() const {
    const double n = static_cast<double>(rods.size());
    return n * mass * kG * n / 2;
  }
  // Largest |E - E0| by the energy of the drop.
  double worst_energy(double seconds) {
    const double start = energy();
    double worst = 0;
    for (int i = 0; i < static_cast<int>(seconds / s.desc.dt + 0.5); ++i) {
      s.world().step();
      const double off = std::abs(energy() - start) / drop();
      if (!(off < 1e6)) return 1e6;
      worst = std::max(worst, off);
    }
    return worst;
  }
};

// sn, cn, dn of Jacobi at u for the parameter m, by descending Gauss transformations (Abramowitz, Stegun 16.4).
void jacobi(double u, double m, double& sn, double& cn) {
  double a[20] = {1}, c[20] = {std::sqrt(m)}, b = std::sqrt(1 - m);
  int n = 0;
  for (; n < 18 && c[n] > 1e-17; ++n) {
    a[n + 1] = (a[n] + b) / 2, c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
  }
  double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  sn = std::sin(phi), cn = std::cos(phi);
}

// The largest distance between the free end and where a pendulum released from the horizontal has it (m), over one
// swing there and back: sin(angle/2) = k sn(K - w t) with k^2 = 1/2.
double end_error(const char* solver, double thick, double dt, int substeps) {
  RodChain c(solver, 1, thick, "hinge", dt, substeps);
  const double inertia = (1 + thick * thick) / 12 + 0.25, w = std::sqrt(kG * 0.5 / inertia), k2 = 0.5;
  const double quarter = elliptic_k(k2), period = 4 * quarter / w;
  double worst = 0;
  for (int i = 1; i * dt <= period; ++i) {
    c.s.world().step();
    double sn, cn;
    jacobi(quarter + w * (i * dt), k2, sn, cn);
    const double half = std::asin(std::sqrt(k2) * sn), angle = 2 * half;  // from hanging down
    const Vec3 at = c.s.position(c.rods[0]);
    const double off = std::hypot(2 * double(at[0]) - std::sin(angle), 2 * double(at[1]) + std::cos(angle));
    if (!(off < 1e6)) return 1e6;
    worst = std::max(worst, off);
  }
  return worst;
}

}  // namespace

TEST_CASE("a hinged rod converges to the closed form", "[rigid][closed][rods]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double thick = GENERATE(0.001, 0.01, 0.1);
  CAPTURE(solver, thick);
  const double at_default = end_error(solver, thick, 1.0 / 60, 4);
  CHECK(at_default < 0.012);  // m: the travel of half a substep
  double before = end_error(solver, thick, 1.0 / 60, 1);
  CHECK(before < 0.05);
  if (sizeof(Real) == 4) return;
  for (const int substeps : {2, 4, 8, 16}) {
    CAPTURE(substeps);
    const double now = end_error(solver, thick, 1.0 / 60, substeps);
    CHECK(now * 1.8 <= before);
    before = now;
  }
}

// Height of the turning points, at the default step.
TEST_CASE("a hinged rod keeps swinging", "[rigid][closed][rods]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double thick = GENERATE(0.001, 0.02, 0.1);
  CAPTURE(solver, thick);
  RodChain c(solver, 1, thick, "hinge", 1.0 / 60, 4);
  const double period = kTurn / std::sqrt(kG * 0.5 / ((1 + thick * thick) / 12 + 0.25)) * elliptic_k(0.5) * 4 / kTurn;
  const int swings = 5;
  double top = -1;
  for (int i = 0; i < static_cast<int>((swings + 0.25) * period * 60); ++i) {
    c.s.world().step();
    if (i > (swings - 0.25) * period * 60) top = std::max(top, double(c.s.position(c.rods[0])[1]));
  }
  CHECK(top > -0.5 * 0.01 * swings);  // at most 1 % of the energy in a swing
  CHECK(top < 0.005);
}

TEST_CASE("chains of rods keep their energy", "[rigid][closed][rods]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const char* type = GENERATE("hinge", "ball");
  const int count = GENERATE(2, 5, 10);
  const double thick = GENERATE(0.001, 0.003, 0.03, 0.1);
  CAPTURE(solver, type, count, thick);
  double before = 0.05;
  for (const int substeps : {1, 4, 16}) {
    CAPTURE(substeps);
    RodChain c(solver, count, thick, type, 1.0 / 60, substeps, type[0] == 'b' ? 0.5 : 0);
    const double now = c.worst_energy(2);
    CHECK(now < before);
    before = now;
  }
}

// Contacts use the arms and axes of the start of the step: in a slender body that must not add rotation about its axis.
TEST_CASE("chains of rods that hit each other gain no energy", "[rigid][once][rods]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const char* type = GENERATE("hinge", "ball");
  const double thick = GENERATE(0.001, 0.01);
  CAPTURE(solver, type, thick);
  RodChain c(solver, 10, thick, type, 1.0 / 60, 4, 0, 0.6);
  const double start = c.energy();
  double most = 0;
  for (int i = 0; i < 600; ++i) {
    c.s.world().step();
    const double gain = (c.energy() - start) / c.drop();
    most = gain < 1e6 ? std::max(most, gain) : 1e6;
  }
  CHECK(most < 0.05);
}
