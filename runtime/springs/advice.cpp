// Advice on a net before it runs: stability, error and resolved frequencies of its integrator.
// Stability: no eigenvalue of M^-1 K exceeds max_i (1/m_i) sum_j |K_ij| <= max_i 2 sum_k k_ik / m_i (Gershgorin
// 1931), so h sqrt of that against the method's limit on x'' = -w^2 x decides. It is an upper bound, exact for
// long chains: a net beyond it may still be stable, one below it is, as long as its springs stay near their rest
// lengths or stretched. Force generators with a known derivative add it as it is now; those of scripts have none.
// Error: a method of order p reproduces exp(i h w) up to (h w)^p, so a step errs by about z^(p+1)/(p+1)! with z = h w
// (first missing term of the series; Hairer, Norsett & Wanner, Solving ODEs I, II.3), and the 2 pi/z steps of a period
// add to 2 pi z^p / (p+1)!. Symplectic Euler is conjugate to Stoermer-Verlet (Hairer, Lubich & Wanner, Geometric
// Numerical Integration, I.1): it errs by z/2 once and for all, and its phase by z^2/24 of a period.
// Right within a factor of 10: tests/springs/test_advice.cpp runs every integrator beside it.
#include <algorithm>
#include <cmath>

#include "springs/impl.h"

namespace feder {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr int kMaxSubsteps = 1000000;  // beyond, no number is worth naming

double factorial(int n) {
  double f = 1;
  for (int k = 2; k <= n; ++k) f *= k;
  return f;
}

// Relative error after one period of a mode with h w = z.
double period_error(const IntegratorInfo& m, double z) {
  FEDER_ASSERT(m.order >= 1 && !(z < 0));
  if (m.order == 1 && m.symplectic) return z / 2 + kTwoPi * z * z / 24;
  return kTwoPi * std::pow(z, m.order) / factorial(m.order + 1);
}

// The z with this error, by bisection.
double resolved_number(const IntegratorInfo& m, double error) {
  double lo = 0, hi = 10;
  for (int k = 0; k < 60; ++k) {
    const double middle = (lo + hi) / 2;
    (period_error(m, middle) < error ? lo : hi) = middle;
  }
  return lo;
}

}  // namespace

// Damping shrinks the step of methods that are not symplectic; those take stiff damping implicitly.
double stability_number(const IntegratorInfo& m, double h, double frequency, double decay) {
  return h * (m.symplectic ? frequency : std::max(frequency, decay));
}

bool beyond_limit(const IntegratorInfo& m, double number) {
  return !m.adaptive && number > 0 && number > m.stability_limit;
}

NetAdvice Springs::advice(ObjectId id, double dt, int substeps) const {
  FEDER_ASSERT(dt > 0 && substeps >= 1);
  Net& n = impl_->net(id);
  NetAdvice a;
  a.net = id;
  a.integrator = n.integrator_name;
  a.method = n.integrator->info();
  a.h = dt / substeps;
  n.prepare(Vec3(0, 0, 0), impl_->air_density, impl_->store.find<Forces>(), impl_->objects.tags(id));
  n.bounds(a.frequency, a.decay, true);
  a.stability_number = stability_number(a.method, a.h, a.frequency, a.decay);
  const double limit = a.method.stability_limit;
  a.stable = !beyond_limit(a.method, a.stability_number);
  a.never_stable = limit == 0 && a.stability_number > 0;
  if (a.method.adaptive)
    a.solver_substeps = std::max(1, static_cast<int>(std::min(1e9, std::ceil(a.stability_number / limit))));
  if (limit > 0 && !std::isinf(limit)) {
    const double needed = std::ceil(a.stability_number * substeps / (NetAdvice::kSafeShare * limit));
    a.substeps = needed <= kMaxSubsteps ? std::max(1, static_cast<int>(needed)) : 0;
  }
  a.error = period_error(a.method, a.h * a.frequency);
  a.resolved = resolved_number(a.method, NetAdvice::kResolvedError) / a.h;
  return a;
}

}  // namespace feder
