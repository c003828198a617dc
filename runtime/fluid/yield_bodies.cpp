// A body lighter than the particles that press on it is a mass on stiff springs, one per contact: k = m c^2 (slope of
// the density)^2. Within a substep of the world its pose is where its velocity of the moment leads in all of the time
// since the beginning, so an explicit fluid throws it about however small the solver substeps are. With the change D of
// its velocities, linear and angular, and rows J (normal, arm x normal), the impulses that are left are
//   i' = i + h lead k J D,  D = -M^-1 sum J^T i',
// a linear system of six unknowns for each body (linearly implicit Euler: Rosenbrock 1963). What the body does not
// take, the particles keep, so momentum is kept. Kept between calls: nothing. Weak spot: contacts may pull in a kick,
// as far as the body runs from the pressure that it had.
#include "fluid/yield_bodies.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

constexpr int kUnknowns = 6;
// Of h lead M^-1 sum J^T k J, a bound of its eigenvalues: below, the explicit step is as stable (2 would be the limit)
// and the body is left alone.
constexpr double kExplicitTrace = 1;

struct YieldSystem {
  double a[kUnknowns][kUnknowns] = {}, b[kUnknowns] = {};  // a: first sum J^T k J, then I + h lead M^-1 of it
  bool pressed = false;
};

// Gauss with pivots; the solution replaces b.
void solve_six(YieldSystem& s) {
  for (int k = 0; k < kUnknowns; ++k) {
    int best = k;
    for (int r = k + 1; r < kUnknowns; ++r)
      if (std::fabs(s.a[r][k]) > std::fabs(s.a[best][k])) best = r;
    if (best != k) std::swap(s.a[best], s.a[k]), std::swap(s.b[best], s.b[k]);
    FEDER_ASSERT(s.a[k][k] != 0);
    for (int r = k + 1; r < kUnknowns; ++r) {
      const double by = s.a[r][k] / s.a[k][k];
      for (int n = k; n < kUnknowns; ++n) s.a[r][n] -= by * s.a[k][n];
      s.b[r] -= by * s.b[k];
    }
  }
  for (int k = kUnknowns - 1; k >= 0; --k) {
    for (int n = k + 1; n < kUnknowns; ++n) s.b[k] -= s.a[k][n] * s.b[n];
    s.b[k] /= s.a[k][k];
  }
}

// M^-1 times a vector of linear and angular parts.
void divide_by_mass(const BoundaryBody& body, double* v) {
  double out[kUnknowns];
  for (int k = 0; k < 3; ++k) {
    out[k] = static_cast<double>(body.inv_mass[k]) * v[k];
    out[k + 3] = 0;
    for (int n = 0; n < 3; ++n) out[k + 3] += static_cast<double>(body.inv_inertia(k, n)) * v[n + 3];
  }
  std::copy(out, out + kUnknowns, v);
}

struct ContactRow {
  double j[kUnknowns];
  double stiffness;  // N/m
};

ContactRow row_of(const FluidPool& p, const BoundaryBody& body, const BoundaryContact& k) {
  const Vec3 x = p.x[k.particle].vec(), turn = cross(x - body.center, k.normal);
  ContactRow row;
  for (int n = 0; n < 3; ++n) row.j[n] = static_cast<double>(k.normal[n]), row.j[n + 3] = static_cast<double>(turn[n]);
  const double slope = static_cast<double>(p.table->at(k.distance(x) / p.support).slope / p.support);
  const double sound = static_cast<double>(p.sound);
  row.stiffness = k.impulse > 0 ? static_cast<double>(p.mass) * sound * sound * slope * slope : 0.0;
  return row;
}

}  // namespace

void yield_bodies(FluidPool& p, const Boundary& boundary, Real h, Real lead, StepContext& c) {
  FEDER_ASSERT(h > 0 && lead >= h);
  const Scratch::Frame frame(*c.scratch);
  const std::size_t bodies = boundary.bodies.size();
  YieldSystem* systems = c.scratch->take<YieldSystem>(bodies);
  for (std::size_t b = 0; b < bodies; ++b) systems[b] = YieldSystem();
  // springs and pushes
  for (const std::uint32_t at : p.dynamic_contacts) {
    const BoundaryContact& k = p.contacts[at];
    YieldSystem& s = systems[boundary.shapes[k.shape].body];
    const ContactRow row = row_of(p, boundary.body_of(k), k);
    s.pressed = s.pressed || k.impulse > 0;
    for (int n = 0; n < kUnknowns; ++n) {
      s.b[n] -= static_cast<double>(k.impulse) * row.j[n];
      for (int m = 0; m < kUnknowns; ++m) s.a[m][n] += row.stiffness * row.j[m] * row.j[n];
    }
  }
  // how the bodies yield
  const double scale = static_cast<double>(h) * static_cast<double>(lead);
  for (std::size_t b = 0; b < bodies; ++b) {
    YieldSystem& s = systems[b];
    if (!s.pressed) continue;
    divide_by_mass(boundary.bodies[b], s.b);
    for (int n = 0; n < kUnknowns; ++n) {
      double column[kUnknowns];
      for (int m = 0; m < kUnknowns; ++m) column[m] = scale * s.a[m][n];
      divide_by_mass(boundary.bodies[b], column);
      for (int m = 0; m < kUnknowns; ++m) s.a[m][n] = column[m] + (m == n);
    }
    double trace = 0;
    for (int n = 0; n < kUnknowns; ++n) trace += s.a[n][n] - 1;
    s.pressed = trace > kExplicitTrace;
    if (s.pressed) solve_six(s);
  }
  // what is left of the pushes
  for (const std::uint32_t at : p.dynamic_contacts) {
    BoundaryContact& k = p.contacts[at];
    const YieldSystem& s = systems[boundary.shapes[k.shape].body];
    if (!s.pressed) continue;
    const ContactRow row = row_of(p, boundary.body_of(k), k);
    double change = 0;
    for (int n = 0; n < kUnknowns; ++n) change += row.j[n] * s.b[n];
    const Real by = static_cast<Real>(scale * row.stiffness * change);
    k.impulse += by;
    Row4& a = p.move[k.particle];
    a.set(a.vec() + by / (p.mass_of(k.particle) * h) * k.normal);
  }
}

}  // namespace feder
