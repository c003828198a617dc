// One step of the Runge-Kutta pair 5(4) of Dormand & Prince 1980 and its error estimate: for rk45 and for references.
#pragma once
#include "integrate/runge_kutta.h"

namespace feder {

class DormandPrince {
 public:
  explicit DormandPrince(Arena& a);

  // The slope at (x, v), for a first step from there.
  void start(ForceField& field, double t, std::span<const Vec3> x, std::span<const Vec3> low, std::span<const Vec3> v,
             IntegratorStats& stats);
  // Tries a step of h from (x + low, v), whose slope is known; its end is in end_x() + end_low() and end_v(). Returns
  // the error estimate: root mean square over the free points of error / (absolute + relative |state|), of x and of v.
  double attempt(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<const Vec3> low,
                 std::span<const Vec3> v, double absolute, double relative, IntegratorStats& stats);
  std::span<const Vec3> end_x() const { return stages_.last_x(); }
  std::span<const Vec3> end_low() const { return stages_.last_low(); }
  std::span<const Vec3> end_v() const { return stages_.last_v(); }
  // The end of the last attempt becomes the start of the next: its slope is known already.
  void accept();

 private:
  RungeKutta stages_;
};

}  // namespace feder
