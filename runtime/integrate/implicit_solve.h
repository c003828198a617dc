// What implicit methods share: the matrix A = M - g D - g^2 K with a solver behind it, and Newton's method for one
// implicit stage. Options of every method that uses them: `solver` = "auto", "direct" or "cg"; `iterations`, the cap of
// Newton steps; `cg_iterations`, the cap within a solve (0: as many as could be needed).
#pragma once
#include "integrate/pattern.h"
#include "linear/block_ldl.h"
#include "linear/cg.h"

namespace feder {

// Of a method that is stable on linear systems at any step, with any damping.
inline IntegratorInfo unlimited_info(int order, int evals_per_step) {
  const auto limit = [](double) { return static_cast<double>(kInfinity); };
  return {.order = order,
          .stability_limit = static_cast<double>(kInfinity),
          .evals_per_step = evals_per_step,
          .implicit = true,
          .damped_limit = limit};
}

// "auto" factors when that costs no more than a hard conjugate-gradient solve would: chains, sheets of some thousand
// points; not solid lattices. The order of elimination is found once per pattern.
class ImplicitMatrix {
 public:
  ImplicitMatrix(Arena& a, const Params& p);

  // K and D at (x, v, t), and A with this g.
  void assemble(ForceField& field, double t, Real g, std::span<const Vec3> x, std::span<const Vec3> v,
                IntegratorStats& stats);
  // A d = r for the free points, d = 0 for the others. False when it missed its tolerance.
  bool solve(const ForceField& field, std::span<const Vec3> r, std::span<Vec3> d, IntegratorStats& stats);
  // out = K u
  void multiply_stiffness(std::span<const Vec3> u, std::span<Vec3d> out) const { k_.multiply<Vec3>(u, out); }

 private:
  enum class Solver { automatic, direct, iterative };
  static Solver solver_option(const Params& p);
  void update_pattern(const ForceField& field, std::size_t n);

  Solver solver_;
  int cg_cap_;
  BlockSparse k_, d_, a_;
  BlockLdl ldl_;
  ConjugateGradient cg_;
  bool direct_ = false, factored_ = false;
  FieldPattern pattern_;
};

// One implicit stage: finds v with
//   M (v - v_star) = g f(x + x_past + g v, v, t);   the new position is x + x_past + g v.
// implicit Euler: v_star = v before, g = h, x_past only the low part of x; implicit midpoint: g = h/2; BDF2 and
// TR-BDF2: x_past and v_star collect the past. x_past and g v are added first: together they are small beside x.
struct StageProblem {
  double t = 0;                          // s, of the force
  Real g = 0;                            // s
  std::span<const Vec3> x;               // m, the state before, where the first Newton step linearises
  std::span<const Vec3> x_past, v_star;  // x_past is zero for pinned points, but for low parts
};

class ImplicitStage {
 public:
  ImplicitStage(Arena& a, const Params& p);
  // `v` holds the guess, then the solution. Counts a miss of the tolerance in stats.unconverged.
  void solve(ForceField& field, const StageProblem& p, std::span<Vec3> v, IntegratorStats& stats);
  // The stage of a method without a past, from (x + low, v); returns the velocities before, valid until the next.
  std::span<const Vec3> solve_from(ForceField& field, double t, Real g, std::span<const Vec3> x,
                                   std::span<const Vec3> low, std::span<Vec3> v, IntegratorStats& stats) {
    v_before_.assign(v.begin(), v.end());
    solve(field, {t, g, x, low, v_before_}, v, stats);
    return v_before_;
  }

 private:
  void evaluate(ForceField& field, const StageProblem& p, std::span<const Vec3> v, IntegratorStats& stats);
  bool first_direction(ForceField& field, const StageProblem& p, std::span<const Vec3> v, IntegratorStats& stats);
  double squared_residual(const ForceField& field) const;
  double slope_along_direction() const;
  double search(ForceField& field, const StageProblem& p, std::span<Vec3> v, IntegratorStats& stats);
  bool update_is_rounding(const StageProblem& p, Real units) const;
  void set_residual(ForceField& field, const StageProblem& p, std::span<const Vec3> v);

  int newton_cap_;
  ImplicitMatrix matrix_;
  Array<Vec3> force_, x_new_, v_base_, residual_, dv_, v_before_;
  Array<Vec3d> product_;
};

}  // namespace feder
