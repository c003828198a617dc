// Time integrators: orders, stability limits and costs, and statistics of their work. Plain data.
#pragma once
#include <span>
#include <string>

#include "feder/types.h"

namespace feder {

struct IntegratorInfo {
  int order = 1;               // of the global error
  double stability_limit = 0;  // largest h*omega on the undamped oscillator; 0 = never stable, infinity = always
  int evals_per_step = 1;      // force evaluations; at least that many where `implicit` or `adaptive`
  bool implicit = false;       // solves systems with K
  bool symplectic = false;     // without damping; the energy error is bounded
  bool adaptive = false;       // divides h into solver substeps (limits and order are those of one, see rk45.cpp)
  bool l_stable = false;       // modes far too stiff for h are damped out in a step
  bool exact_linear = false;   // linear forces are integrated exactly
  const char* effort_option = nullptr;  // integer option that caps the work within a step, or null
  // Largest h*omega with the damping ratio zeta, where a formula gives it.
  double (*damped_limit)(double zeta) = nullptr;
  // Of explicit Runge-Kutta methods: one step multiplies a solution e^(lambda t) by sum c_k (h lambda)^k.
  std::span<const double> stability_polynomial = {};
};

struct IntegratorStats {
  std::uint64_t force_evals = 0, jacobian_evals = 0, linear_solves = 0, cg_iterations = 0;
  std::uint64_t unconverged = 0;             // solves that ended at the cap: reported as a warning
  std::uint64_t substeps = 0, rejected = 0;  // of adaptive methods: accepted and rejected
  double residual = 0;                       // of the last solve, relative
};

// symplectic_euler, or the first of this build where that is left out.
std::string default_integrator();

}  // namespace feder
