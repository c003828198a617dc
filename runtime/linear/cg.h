// Preconditioned conjugate gradient for symmetric positive definite block matrices.
#pragma once
#include "linear/block_sparse.h"

namespace feder {

struct CgOptions {
  double tolerance = 1e-5;  // wanted reduction of the residual in the norm of the preconditioner
  int max_iterations = 100;
};

struct CgResult {
  int iterations = 0;
  double residual = 0;     // reached, relative, in the norm of the preconditioner
  bool converged = false;  // false: cap reached, or a direction without positive curvature was met
};

// Keeps its work arrays; no allocation after the first solve of a size.
class ConjugateGradient {
 public:
  explicit ConjugateGradient(Arena& a) : inverse_(&a), x_(&a), r_(&a), z_(&a), p_(&a), ap_(&a) {}

  // Solves A x = b for the points with free[i] != 0; the others keep x = 0 (their rows and columns are filtered
  // out). `x` is output only: the start is zero.
  CgResult solve(const BlockSparse& a, std::span<const Real> free, std::span<const Vec3> b, const CgOptions& options,
                 std::span<Vec3> x);

 private:
  double precondition();  // z = P^-1 r; returns r . z

  Array<Mat3d> inverse_;  // of the diagonal blocks; zero for fixed points, which filters them
  Array<Vec3d> x_, r_, z_, p_, ap_;
};

}  // namespace feder
