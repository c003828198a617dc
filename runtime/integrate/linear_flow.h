// The exact flow of a linear second-order system, by Krylov subspaces: the kernel of the exponential integrator.
#pragma once
#include "integrate/integrator.h"

namespace feder {

// M x'' = K x + D x' with K, D symmetric negative semidefinite.
struct LinearSystem {
  const BlockSparse *k = nullptr, *d = nullptr;
  std::span<const Real> mass, inv_mass;  // inv_mass 0: pinned
};

class LinearFlow {
 public:
  explicit LinearFlow(Arena& a);

  // Solves y' = L y + b + ramp (t/h) from y = 0 to t = h for y = (x, v), L the system's matrix. `ramp` (of v only, per
  // mass) may be empty. False when the tolerance was missed: y is then bounded but not accurate.
  bool solve(const LinearSystem& s, double h, std::span<const Vec3d> b_x, std::span<const Vec3d> b_v,
             std::span<const Vec3d> ramp, int max_substeps);
  std::span<const Vec3d> x() const { return x_; }
  std::span<const Vec3d> v() const { return v_; }

 private:
  struct Basis {
    std::size_t n;
    int size;     // vectors
    double beta;  // norm of the start vector
    bool closed;  // the space is invariant: the flow in it is exact
  };
  void apply(std::span<const Vec3d> x, std::span<const Vec3d> v, std::span<Vec3d> out) const;
  void weigh(std::span<const Vec3d> x, std::span<Vec3d> out) const;
  double norm_and_store(int j);
  double project(int i, int j) const;
  Basis build_basis(double h);
  double error(const Basis& b, double tau);
  void move(const Basis& b, double tau);

  std::span<Vec3d> column(Array<Vec3d>& a, int j) const { return {a.data() + static_cast<std::size_t>(j) * n_, n_}; }

  LinearSystem system_;
  std::size_t n_ = 0;
  double h_ = 0, ramp_scale_ = 0;
  std::span<const Vec3d> ramp_;
  Array<Vec3d> x_, v_, rate_x_, rate_v_;
  double extra_ = 0, rate_extra_ = 0;
  mutable Array<Vec3d> product_;
  Array<Vec3d> basis_x_, basis_v_, basis_p_;  // by vector, then point; p: the x part times its weight
  Array<double> basis_extra_;
  Array<double> hessenberg_, small_, power_, sum_;
};

}  // namespace feder
